#!/usr/bin/env bash
# ./dev new makes a project that follows its README: configure, compile, run, on ranks too, with
# checkpoints, against the source tree and against an installed talus; and prints advice if it finds
# neither.
#   new.sh ROOT PRESET MPIEXEC NUMPROC_FLAG
set -euo pipefail
root=$1 preset=$2 launch=("$3" "$4")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
export TALUS_PRESET=$preset TALUS_NO_APT=1
fail() { echo "$*"; exit 1; }
# The value of a number in a file of --json.
number() { sed -n "s/^ *\"$2\": \([^,]*\),*$/\1/p" "$1"; }

echo "== a project"
"$root/dev" new shore
[[ $(cd shore && find . -type f | sort | paste -sd ' ') == "./.gitignore ./CMakeLists.txt ./README.md ./job.sh ./main.cpp" ]] ||
  fail "other files than announced: $(find shore -type f)"
! grep -n '@' shore/CMakeLists.txt shore/README.md <(sed 's/USR1@120//; s/\[@\]//' shore/job.sh) || fail "something was not filled in"
for name in 3x shore test 'a b' ''; do
  ! "$root/dev" new "$name" 2>said || fail "'$name' was taken as a name"
  grep -Eq 'one name of letters|here already|meaning in CMake' said || fail "no reason for '$name': $(cat said)"
done

echo "== its three commands"
cd shore
mapfile -t commands < <(sed -n '/^```$/,/^```$/p' README.md | sed '/^```$/d; s/  *#.*//')
((${#commands[@]} == 3)) || fail "not three commands: ${commands[*]}"
(unset CXX CXXFLAGS && bash -ec "${commands[0]}" && bash -ec "${commands[1]}") 2>&1 | tee ../built
! grep -E '(warning|note):' ../built || fail "the compiler complains"
grep -qx "talus_DIR:PATH=$root/build/$preset" build/CMakeCache.txt || fail "another talus was found: $(grep talus_DIR build/CMakeCache.txt)"
bash -ec "${commands[2]} --steps 300 --json one.json" | tee said
grep -q '^  error ' said || fail "no summary"
"${launch[@]}" 2 ./build/shore --steps 300 --quiet --json two.json
./build/shore --ranks 4 --steps 300 --quiet --json four.json --frames pictures --every 300
[[ $(number one.json bodies) == 729 && $(number two.json bodies) == 729 ]] || fail "bodies are missing"
[[ $(number two.json ranks) == 2 && $(number four.json ranks) == 4 ]] || fail "not on these ranks"
[[ -s pictures/frame_00001.pov ]] || fail "no pictures"

echo "== its job.sh, with a stand-in for srun; with checkpoints it goes on from there"
bash -n job.sh && [[ -x job.sh ]] || fail "job.sh is no script"
mkdir ../bin
cat >../bin/srun <<END
#!/usr/bin/env bash
[[ \$1 == --cpu-bind=cores ]] || { echo "srun: \$1?"; exit 1; }
shift
exec "$3" "$4" 2 "\${@/#2000/\$STEPS}"
END
chmod +x ../bin/srun
STEPS=20 PATH=$work/bin:$PATH ./job.sh
[[ $(number shore.json ranks) == 2 && $(number shore.json steps) == 20 && -s shore.csv ]] || fail "the job did not run"

echo "== with checkpoints, as its README says"
sed -i 's/COMPONENTS mpi/COMPONENTS mpi hdf5/; s/PRIVATE talus::mpi/PRIVATE talus::mpi talus::hdf5/' CMakeLists.txt
sed -i 's|^#include <talus/mpi.hpp>|#include <talus/checkpoint.hpp>\n&|; s/transport<as_launched>>/transport<as_launched>, features<checkpoints>>/' main.cpp
grep -q 'features<checkpoints>' main.cpp || fail "main.cpp is not what the README thinks"
cmake -B build && cmake --build build
./build/shore --steps 20 --quiet --checkpoint half.h5
./build/shore --steps 40 --quiet --restart half.h5 --json rest.json
[[ $(number rest.json restarted_at) == 20 && $(number rest.json steps) == 40 ]] || fail "no restart"
sed -i 's/^# \(keep=\|\[\[\)/\1/; s/^##SBATCH/#SBATCH/' job.sh
for steps in 20 40; do STEPS=$steps PATH=$work/bin:$PATH ./job.sh; done
[[ $(number shore.json restarted_at) == 20 && $(number shore.json steps) == 40 ]] || fail "the job was not continued"

echo "== an installed talus goes first"
cmake --install "$root/build/$preset" --prefix "$work/prefix" >/dev/null
cmake -B elsewhere -DCMAKE_PREFIX_PATH="$work/prefix" >/dev/null
grep -q "^talus_DIR:PATH=$work/prefix/" elsewhere/CMakeCache.txt || fail "the installed one was not taken"

echo "== and where there is none, what to do"
! cmake -B nowhere -DCMAKE_DISABLE_FIND_PACKAGE_talus=ON >said 2>&1 || fail "configured without talus"
tr '\n' ' ' <said | tr -s ' ' | grep -qF "talus was not found: run 'cmake --preset $preset' in $root, or say where it is installed by -DCMAKE_PREFIX_PATH=FOLDER" ||
  fail "no advice: $(cat said)"
