#!/usr/bin/env bash
# The output of a compiler for each refusal begins with the expected sentence, and is short: a table of
# line counts, and a failure if there are over 25 lines, or if the first error is another.
#   lines.sh COMPILER FLAGS_FILE [SOURCE ...]
# Of the flags only include folders and definitions are used, so that any compiler works.
set -euo pipefail
compiler=$1
mapfile -t flags < <(grep -E '^-(I|isystem|D)' "$2")
here=$(cd "$(dirname "$0")" && pwd)
shift 2
(($#)) || set -- "$here"/*.cpp
most=25 failed=0
compile=("$compiler" -std=c++20 -fsyntax-only -fmessage-length=0 -fdiagnostics-color=never -w)

judge() {  # name, what was expected, the output
  local lines first
  lines=$(wc -l <<<"$3")
  first=$(grep -m 1 -E 'error: ' <<<"$3" || true)
  printf '%4d  %s\n' "$lines" "$1"
  if ((lines > most)) || [[ $first != *"$2"* ]]; then
    echo "      more than $most lines, or the first error is not the sentence: $first"
    failed=1
  fi
}

for source in "$@"; do
  expected=$(head -n 8 "$source" | sed -n 's|^// expects: *||p' | head -n 1)
  if out=$("${compile[@]}" "${flags[@]}" "$source" 2>&1); then
    echo "$source compiles, but must be refused"
    failed=1
  else
    judge "$(basename "$source" .cpp)" "$expected" "$out"
  fi
done

# The places of the libraries that talus needs are not set.
expected='talus needs Eigen 3.4, fmt and Boost.Hana: in CMake write find_package(talus) and link talus::talus'
out=$(echo '#include <talus/talus.hpp>' |
  "${compile[@]}" "-I$here/../../include" -x c++ - 2>&1) || true
judge "(libraries not found)" "$expected" "$out"
exit $failed
