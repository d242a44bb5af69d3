#!/usr/bin/env bash
# What ./dev says while it compiles: how many files are made of all, from the first second on, and the time left;
# lines of the compiler stay whole.
#   progress.sh ROOT
set -euo pipefail
fail() { echo "$*"; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/built" <<'END'
set -euo pipefail
eval "$(sed -n '/^show_progress() {/,/^}/p' "$1/dev")"
{
  sleep 2.2
  echo '[1/3] Building CXX object a.o'
  printf 'main.cpp:1: an '
  sleep 1.2
  printf 'error\n[2/3] Building CXX object b.o\n[3/3] Linking CXX executable a\n'
} | show_progress built 3
END
# On a terminal: one line, which is rewritten.
python3 -c 'import pty, sys; pty.spawn(sys.argv[1:])' bash "$work/built" "$1" | tr '\r' '\n' | sed 's/\x1b\[K//; s/ *$//' >"$work/said"
head -n 4 "$work/said" | grep -Eqx 'dev: built 0 of 3, [0-9]+ s' || fail "nothing before the first file: $(cat "$work/said")"
grep -Eqx 'dev: built 1 of 3, [0-9]+ s, about [0-9]+ s left' "$work/said" || fail "no time left: $(cat "$work/said")"
grep -Eqx 'dev: built 3 of 3, [0-9]+ s, about 0 s left' "$work/said" || fail "no end: $(cat "$work/said")"
grep -qx 'main.cpp:1: an error' "$work/said" || fail "a line is broken: $(cat "$work/said")"
# Elsewhere short builds print what goes wrong, and nothing else.
bash "$work/built" "$1" 2>"$work/said"
[[ $(cat "$work/said") == 'main.cpp:1: an error' ]] || fail "other lines: $(cat "$work/said")"
