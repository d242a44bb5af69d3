#!/usr/bin/env bash
# The files that a real program writes with --output: as VTK and h5py read them, and after the run was
# killed.
#   output_runs.sh PROGRAM FOLDER PYTHON SOURCE [MPIRUN...]
# PROGRAM is the example hopper; MPIRUN... starts it on two ranks. Ends with 77 if VTK or h5py are
# missing.
set -euo pipefail
program=$1 folder=$2 python=$3 source=$4
shift 4
launch=("$@")
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
fail() { echo "FAILED: $*"; exit 1; }
has_readers() { "$1" -c 'import h5py, vtkmodules.vtkIOHDF' 2>/dev/null; }
has_readers "$python" || python=/usr/bin/python3  # Debian's packages belong to Debian's Python
has_readers "$python" || { echo 'skipped: no VTK or h5py'; exit 77; }

"${launch[@]}" "$program" --quiet --steps 600 --output two --output-every 100 --output-surfaces \
  --json two.json
"$python" -B "$source/tests/io/read_output.py" two two.json
"$program" --quiet --steps 600 --output one --output-every 100 --json one.json
"$python" -B "$source/tests/io/read_output.py" one one.json
if command -v pvpython >/dev/null; then
  env -u DISPLAY pvpython "$source/tests/io/read_output_paraview.py" two 7
fi

# Whatever its name, an output is read; the name does not command the terminal, nor the page.
odd=$'a "b"\\<\t\e[2J\xe2\x80\xae'
"$program" --quiet --steps 20 --output "$odd"
PYTHONPATH=$source/python "$python" -B -c 'import sys, talus; print(len(talus.open(sys.argv[1])[0]), "bodies")' "$odd"
echo THREE >three.js
TALUS_THREE=$PWD/three.js "$python" -B "$source/viewer/view.py" "$odd" >out 2>&1 || { cat -v out; fail 'no page of an odd name'; }
! grep -qe $'\e' -e $'\xe2\x80\xae' out "$odd.html" || fail 'a name commands the terminal or the page'

# A run is killed: all files that its series names are complete. Another run continues from its
# checkpoint.
kept=0
for ((try = 0; try < 5; ++try)); do
  rm -f killed*
  "$program" --quiet --steps 100000 --bodies 400 --output killed --output-every 1 \
    --checkpoint killed.h5 --checkpoint-every 20 &
  child=$!
  while [[ ! -e killed.h5 ]]; do sleep 0.02; done
  sleep "0.$((10 + try * 7))"  # fewer than 400 steps
  kill -KILL $child
  wait $child || true
  "$python" -B - <<'END' || fail 'the series of a killed run'
import h5py, json
for name in ("killed.hdf.series", "killed_contacts.hdf.series"):
    files = json.load(open(name))["files"]
    for n, entry in enumerate(files):
        assert entry["name"].endswith(f"_{n:010}.hdf"), entry
        with h5py.File(entry["name"]) as f:
            assert f["VTKHDF/FieldData/step"][0] == n
    print(len(files), "files of a killed run")
END
done
"$program" --quiet --steps 400 --bodies 400 --output killed --output-every 1 --restart killed.h5
"$program" --quiet --steps 400 --bodies 400 --output whole --output-every 1
for what in '' _contacts; do
  diff <(sed "s/killed/whole/" killed$what.hdf.series) whole$what.hdf.series ||
    fail 'the series of a restarted run differs'
done
