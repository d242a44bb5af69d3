#!/usr/bin/env bash
# Runs the tests of one file: with the program of the file alone if that was built last, else with the
# program that several files share.
#   run_file.sh ALONE SHARED FILE
set -euo pipefail
[[ ! $1 -nt $2 ]] || exec "$1"
out=$("$2" --source-file="*/tests/$3" 2>&1) && code=0 || code=$?
printf '%s\n' "$out"
if [[ $out =~ 'test cases:'\ +0\ \| ]]; then
  echo "$2 has no test of tests/$3"
  exit 1
fi
exit "$code"
