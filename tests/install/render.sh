#!/usr/bin/env bash
# ./dev render prints its progress, draws one picture on request, draws fast on request, and nothing
# twice; with a stand-in for POV-Ray.
#   render.sh ROOT
set -euo pipefail
root=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir bin pictures
cat >bin/povray <<'END'
#!/usr/bin/env bash
for word; do
  case $word in +I*) scene=${word#+I} ;; +O*) out=${word#+O} ;; esac
done
grep -q wrong "$scene" && exit 1
echo "$@" >"$out"
END
chmod +x bin/povray
export PATH=$work/bin:$PATH TALUS_NO_APT=1 TALUS_JOBS=2
fail() { echo "$*"; cat said; exit 1; }
for k in 0 1 2 7; do echo "scene" >"pictures/frame_0000$k.pov"; done
sleep 0.01

"$root/dev" render pictures 2>said
for k in 1 2 3 4; do grep -Eq "^dev: picture $k of 4, [0-9]+ s, [0-9]+ s left$" said || fail "no progress $k"; done
grep -q '+A0.2 +W800 +H600' pictures/frame_00007.png || fail "not good: $(cat pictures/frame_00007.png)"
"$root/dev" render pictures 2>said
grep -qx 'dev: all 4 pictures are drawn already' said || fail "drawn twice"
"$root/dev" render pictures --quality fast --frame 7 2>said
grep -q 'drawing 1 of 1 pictures' said && grep -q 'picture 1 of 1' said || fail "not one"
grep -q -- '-A +W400 +H300' pictures/frame_00007.png || fail "not fast: $(cat pictures/frame_00007.png)"
grep -q '+W800' pictures/frame_00002.png || fail "others were drawn too"
"$root/dev" render pictures --frame=last --width=100 2>said
grep -q '+A0.2 +W100 +H75' pictures/frame_00007.png || fail "not so wide"
echo "wrong" >pictures/frame_00001.pov
! "$root/dev" render pictures 2>said || fail "no failure"
grep -q 'frame_00001.pov cannot be drawn' said && grep -q '1 of 2 pictures could not be drawn' said || fail "no reason"
refused() { ! "$root/dev" render "${@:2}" 2>said && grep -qF -- "$1" said || fail "not refused: ${*:2}"; }
refused 'there is no picture 3 in pictures: they go from 0 to 7' pictures --frame 3
refused "the quality is fast or good, not 'best'" pictures --quality best
refused "--frame takes the number of a picture, or last, not 'x'" pictures --frame x
refused "render has no option '--qualty'" pictures --qualty fast
refused 'render which folder?' nowhere

# Films: of all pictures in their order, by ffmpeg, or .gif by ImageMagick alone.
echo "scene" >pictures/frame_00001.pov
mkdir some
for word in bash cat chmod dirname env grep ls mkdir mktemp mv nproc rm sed sleep xargs; do ln -s "$(command -v "$word")" some/; done
for word in readlink realpath date touch tail head sort tr cut awk uname find; do ! command -v "$word" >/dev/null || ln -s "$(command -v "$word")" some/; done
cat >bin/convert <<'END'
#!/usr/bin/env bash
echo "by convert: $*" >"${@: -1}"
END
chmod +x bin/convert
export PATH=$work/bin:$work/some
refused "--movie takes a file that ends with .mp4 or .gif, not 'a.avi'" pictures --movie a.avi
refused '--movie needs a value' pictures --movie ''
refused '--movie needs a value' pictures --movie=
refused 'there is no folder none for the film none/a.gif' pictures --movie none/a.gif
refused 'a film shows all pictures' pictures --movie a.gif --frame 1
refused "--rate takes the number of pictures a second, not 'x'" pictures --movie a.gif --rate x
refused 'a film a.mp4 needs the program ffmpeg' pictures --movie a.mp4
mkdir folder.gif
refused 'folder.gif is not a file' pictures --movie folder.gif
"$root/dev" render pictures --movie a.gif --rate 10 2>said
grep -qx 'dev: 4 pictures in a.gif, 10 a second' said || fail "no film"
grep -q -- '-delay 1x10 -loop 0 pictures/frame_00000.png pictures/frame_00001.png' a.gif || fail "not these pictures: $(cat a.gif)"
refused 'a.gif is there already: name another file, or add --force' pictures --movie a.gif
cat >bin/ffmpeg <<'END'
#!/usr/bin/env bash
file=${@: -1}
{ echo "by ffmpeg: $*"; cat; } >"${file#file:}"
END
chmod +x bin/ffmpeg
"$root/dev" render pictures --movie b.mp4 2>said
grep -q 'by ffmpeg: .* -framerate 25 -i - ' b.mp4 || fail "not by ffmpeg: $(cat b.mp4)"
[[ $(grep -c frame_0000 b.mp4) == 4 ]] || fail "not four pictures: $(cat b.mp4)"
[[ $(grep -o 'frame_0000.' b.mp4 | tr -d '\n') == *0*1*2*7* ]] || fail "not in their order"
[[ $(ls -A | grep -c movie) == 0 ]] || fail "left over: $(ls -A)"
printf '#!/usr/bin/env bash\nexit 1\n' >bin/ffmpeg
refused 'the film c.mp4 could not be made' pictures --movie c.mp4
[[ ! -e c.mp4 && $(ls -A | grep -c movie) == 0 ]] || fail "left over: $(ls -A)"
