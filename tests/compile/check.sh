#!/usr/bin/env bash
# Fails if a program instantiates over 10 % more than the recorded number, so that compile cost does not
# grow unnoticed: the number of weak symbols (functions and data that the compiler made from templates
# and from inline functions) in an object compiled without optimisation, where each one in use has a
# symbol. The same compiler gives the same number each time; see docs/performance.md.
#   check.sh NM ANNOUNCED PROGRAM OBJECT [PROGRAM OBJECT ...]    compare
#   check.sh --announce NM ANNOUNCED PROGRAM OBJECT ...          write the numbers into ANNOUNCED
#   check.sh --self-test                                         whether growth is found
set -euo pipefail

count() { "$1" "$2" | grep -c ' [WVwvu] '; }

# compare ANNOUNCED PROGRAM NUMBER: prints the advice; fails on growth.
compare() {
  local file=$1 program=$2 now=$3 then
  then=$(awk -v p="$program" '$1 == p { print $2 }' "$file")
  if [[ ! $then =~ ^[1-9][0-9]*$ ]]; then
    echo "$program: $now instantiations, and none announced in $file: run ./dev compile-cost --announce"
    return 1
  fi
  local percent=$(((now - then) * 1000 / then))
  local sign=+
  ((percent < 0)) && sign=- percent=$((-percent))
  local change="$sign$((percent / 10)).$((percent % 10)) %"
  if ((now * 10 > then * 11)); then
    echo "$program: $now instantiations, announced are $then ($change): what is new is compiled into" \
      "every program. Find out what it is (./dev compile-cost --compare OLD_OBJECT NEW_OBJECT), or if it" \
      "must be, announce it: ./dev compile-cost --announce, and say in the commit why"
    return 1
  fi
  echo "$program: $now instantiations, announced are $then ($change)"
  if ((now * 10 < then * 9)); then
    echo "  that is over 10 % less: lower the announced number (./dev compile-cost --announce)"
  fi
}

if [[ $1 == --self-test ]]; then
  file=$(mktemp)
  trap 'rm -f "$file"' EXIT
  printf '# comment\ndrop 1000\n' >"$file"
  compare "$file" drop 1100 >/dev/null && compare "$file" drop 500 | grep -q 'lower' &&
    ! compare "$file" drop 1101 >/dev/null && ! compare "$file" well 10 >/dev/null || exit 1
  exit 0
fi
announce=''
if [[ $1 == --announce ]]; then
  announce=yes
  shift
fi
nm=$1 file=$2 failed=0
shift 2
if [[ $announce == yes ]]; then
  text=$(grep '^#' "$file" || true)
  while (($#)); do
    text+=$'\n'"$1 $(count "$nm" "$2")"
    shift 2
  done
  printf '%s\n' "$text" >"$file"
  cat "$file"
  exit 0
fi
while (($#)); do
  compare "$file" "$1" "$(count "$nm" "$2")" || failed=1
  shift 2
done
exit $failed
