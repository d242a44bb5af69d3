#!/usr/bin/env bash
# The tables of the silo: they have the spheres, replace no file of another kind and no link, and a full
# disk is said.
#   tables_test.sh PROGRAM
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
fail() { echo "$*"; exit 1; }
silo() { "$1" --quiet --spheres 100 --steps 100 --settling 0.002 "${@:2}"; }

silo "$1" --settled settled.csv --csv silo.csv --csv-every 50
[[ $(grep -c ,sphere, settled.csv) == 100 ]] || fail "settled.csv has not 100 spheres"
[[ $(head -n 1 silo.csv) == *,above_the_lip* && $(tail -n 1 silo.csv) == *,100 ]] || fail "silo.csv: $(cat silo.csv)"

echo precious >mine
ln -s mine link
for file in mine link; do
  ! silo "$1" --settled "$file" 2>out || fail "$file was taken"
  grep -q "$file is" out || fail "no word of $file: $(cat out)"
  [[ $(cat mine) == precious ]] || fail "$file was written to"
done
! (ulimit -f 4 && silo "$1" --settled full.csv 2>out) || fail "a full disk is not seen"
grep -q 'full.csv cannot be written' out || fail "no word of a full disk: $(cat out)"
[[ ! -e full.csv ]] || fail "a part of a table is left"
