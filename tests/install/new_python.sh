#!/usr/bin/env bash
# ./dev new --python makes a project that follows its README: its program and its module have the same
# digest, drive.py runs, and a sweep of the program works.
#   new_python.sh ROOT PRESET
set -euo pipefail
root=$1 preset=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
export TALUS_PRESET=$preset TALUS_NO_APT=1
fail() { echo "$*"; exit 1; }

echo "== a project"
"$root/dev" new --python shore 2>said || fail "$(cat said)"
[[ $(cd shore && find . -type f | sort | paste -sd ' ') == \
  "./.gitignore ./CMakeLists.txt ./README.md ./drive.py ./main.cpp ./module.cpp ./scene.hpp" ]] ||
  fail "other files than announced: $(find shore -type f)"
! grep -rn '@[A-Z]*@' shore || fail "something was not filled in"
! "$root/dev" new --python 'a b' 2>said || fail "'a b' was taken as a name"
grep -q 'one name of letters' said || fail "no reason for 'a b': $(cat said)"

echo "== its three commands"
cd shore
mapfile -t commands < <(sed -n '/^```$/,/^```$/p' README.md | sed '/^```$/d; s/  *#.*//')
((${#commands[@]} == 3)) || fail "not three commands: ${commands[*]}"
(unset CXX CXXFLAGS && bash -ec "${commands[0]}" && bash -ec "${commands[1]}")
bash -ec "${commands[2]}" | tee said
digest=$(sed -n 's/^digest //p' said)
[[ -n $digest ]] || fail "drive.py printed no digest"

echo "== the program has the digest of the module"
./build/shore --ranks 1 --steps 600 --friction 0.4 --seed 1 --quiet --json one.json
grep -qF "\"state_digest\": \"$digest\"" one.json || fail "the module has $digest, but: $(grep digest one.json)"

echo "== a sweep of the program"
"$root/dev" sweep ./build/shore --vary friction=0.1,0.8 --jobs 2 -- --steps 20 --ranks 1 2>said || fail "$(cat said)"
[[ $(cut -d, -f1,2,3 sweep_shore/table.csv | paste -sd ' ') == \
  "run,status,friction friction=0.1,done,0.1 friction=0.8,done,0.8" ]] || fail "$(cat sweep_shore/table.csv)"
[[ -s sweep_shore/plots/kinetic_energy.svg ]] || fail "no plots: $(cat said)"
