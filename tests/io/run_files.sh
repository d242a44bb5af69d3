#!/usr/bin/env bash
# The files of runs of a real program where they cannot be written, have odd names, are shared by two
# runs, or are those of a killed run; and signals in the first moments.
#   run_files.sh PROGRAM FOLDER WHAT [MPIRUN...]
# PROGRAM is the example drop, or hopper, which writes --output, or powder, which writes --frames too; MPIRUN... starts it on two ranks.
set -euo pipefail
program=$1 folder=$2/$3 what=$3
shift 3
launch=("$@")
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
name=$(basename "$program")

trap 'kill $(jobs -p) 2>/dev/null || true' EXIT  # what runs on after a failure
fail() { echo "FAILED: $*"; exit 1; }
digest() { sed -n 's/.*"state_digest": "\([0-9a-f]*\)".*/\1/p' "$1"; }

# Runs the program, which must end with the code within a minute, and print all of the words.
expect() {
  local code=$1 got=0 word
  shift
  local words=()
  while [[ $1 != -- ]]; do words+=("$1"); shift; done
  shift
  timeout -k 5 60 "$@" >out 2>&1 || got=$?
  [[ $got == "$code" ]] || { cat out; fail "exit code $got instead of $code: $*"; }
  for word in "${words[@]}"; do
    grep -qF -- "$word" out || { cat out; fail "nothing says '$word': $*"; }
  done
}
wait_for() {  # a file, for up to 20 s
  local n
  for ((n = 0; n < 2000; ++n)); do
    [[ -e $1 ]] && return
    sleep 0.01
  done
  fail "$1 does not come"
}
nothing_left() {
  local left
  left=$(find . -name '*.part-*' -o -name '*.lock' | head -n 1)
  [[ -z $left ]] || fail "$left is left behind"
}

# A disk that says only when a file is closed that it is full, as network disks do: earlier files stay.
late_disk() {
  cat >late.c <<'END'
#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>
int close(int f) {
  char link[64], path[4096] = "";
  snprintf(link, sizeof link, "/proc/self/fd/%d", f);
  if (readlink(link, path, sizeof path - 1) < 0) path[0] = 0;
  const int code = (int)syscall(SYS_close, f);
  const char* const name = strstr(path, "/late.file");  // or a file that has no name yet
  if (code != 0 || (strstr(path, "(deleted)") == NULL && (name == NULL || (name[10] != 0 && strncmp(name + 10, ".part-", 6) != 0))))
    return code;
  errno = ENOSPC;
  return -1;
}
END
  cc -shared -fPIC -o close.so late.c 2>out || { echo "no disk to pretend: $(cat out)"; return 0; }
  local option
  for option in --json --csv; do
    "$program" --quiet --steps 5 "$option" late.file
    cp late.file late_before
    expect 1 'cannot be written: there is no room' -- \
      env LD_PRELOAD="$PWD/close.so" "$program" --quiet --steps 7 "$option" late.file
    cmp late_before late.file || fail "a file of $option is replaced by one that may be incomplete"
    rm late.file
  done
}

# What takes no more ends no run without its files or without a word.
full() {
  local words code
  for words in --help --dry-run '--steps 5'; do
    code=0
    # shellcheck disable=SC2086  # several words
    "$program" $words >/dev/full 2>out || code=$?
    [[ $code == 1 ]] || fail "exit code $code with a full standard output: $words"
    grep -q "^$name: standard output cannot be written: No space left on device" out ||
      { cat out; fail "nothing says that standard output is full: $words"; }
  done
  "$program" --steps 5 --csv o.csv --json o.json >&- 2>out && fail "a closed standard output is nothing to say"
  grep -q 'standard output cannot be written: Bad file descriptor' out || { cat out; fail "nothing says that it is closed"; }
  [[ $(wc -l <o.csv) == 3 && $(digest o.json) != '' ]] || { cat o.csv; fail "other files with a closed standard output"; }
  "$program" --quiet --steps 5 --json /dev/stdout >&- 2>out && fail "results for a closed standard output"
  grep -q '/dev/stdout (--json) cannot be written: ' out || { cat out; fail "nothing says that results are lost"; }
  "$program" --quiet --steps 5 >/dev/full 2>out || { cat out; fail "a quiet run needs standard output"; }
  # Nobody reads: progress stops, and the files come.
  code=0
  { "$program" --steps 300 --json p.json --csv p.csv 2>&1 || echo $? >code; } | true
  [[ -e p.json && $(tail -n 1 p.csv) == 300,* ]] || fail "no files without a reader"
  [[ $(cat code) == 1 ]] || fail "exit code $(cat code) with a summary that nobody reads"
  "$program" --steps 300 --json q.json 2> >(true) >/dev/null || fail "progress that nobody reads ends a run"
  [[ $(digest q.json) == "$(digest p.json)" ]] || fail "no results without a reader of progress"
  # Files that may not be so long, and full disks.
  (
    ulimit -f 1
    expect 1 '(ulimit -f): raise that limit' -- "$program" --quiet --steps 5 --json x.json
    expect 1 '--log x.log cannot be written: ' '(ulimit -f)' -- "$program" --quiet --steps 5 --log x.log
  )
  (
    ulimit -f 8
    expect 1 'the time series x.csv (--csv) cannot be written: ' '(ulimit -f)' -- \
      "$program" --quiet --steps 300 --csv x.csv --csv-every 1
  )
  # The table of an earlier run stays until the first lines of this one are there.
  cp o.csv before
  (ulimit -f 0; "$program" --quiet --steps 5 --csv o.csv 2>&1 || true) | cat >out
  grep -qF 'the time series o.csv (--csv) cannot be written: ' out || { cat out; fail "nothing says that o.csv cannot be written"; }
  cmp before o.csv || fail "a table is replaced by nothing"
  late_disk
  # What MPI shares between processes lies in a file, too.
  expect 1 'MPI cannot share memory between processes' '(ulimit -f): raise that limit' -- \
    "${launch[@]}" bash -c 'ulimit -f 4; exec "$0" --quiet --steps 5' "$program"
  [[ ! -e x.json && ! -e x.log && $(tail -n 2 x.csv | head -n 1) == *,* ]] || fail "other files than the lines that fit"
  nothing_left
  expect 1 '--log /dev/fd/3 cannot be written: there is no room' -- \
    "$program" --quiet --steps 5 --log /dev/fd/3 3>/dev/full
  expect 1 'cannot be written: there is no room' -- "$program" --quiet --steps 5 --json /dev/fd/3 3>/dev/full
  # A log that ends in the middle: the run goes on, and does not end well.
  mkfifo pipe
  head -n 1 pipe >/dev/null &
  expect 1 'the log pipe cannot be written: Broken pipe' -- \
    "$program" --quiet --steps 300 --log pipe --json l.json
  [[ $(digest l.json) == "$(digest p.json)" ]] || fail "no results beside a log that cannot be written"
}

# What a name says or does not say.
names() {
  expect 0 -- "$program" --quiet --steps 5 --checkpoint c.h5
  local option
  for option in --restart --checkpoint --json --csv --log --view --frames --until --time-limit; do
    expect 2 "$option needs a value, but is empty" -- "$program" --quiet --steps 9 $option ''
    expect 2 "$option needs a value, but is empty" -- "$program" --quiet --steps 9 "$option="
    expect 2 "$option needs a value, but is empty" -- "$program" --quiet --steps 9 --set "${option#--}="
  done
  printf 'restart = ""\n' >empty.toml
  expect 2 'empty.toml:1: restart needs a value, but is empty' -- "$program" --quiet --steps 9 --config empty.toml
  printf 'json = "a\\u0000b"\n' >zero.toml
  expect 2 'zero.toml:1: json needs a text without zero bytes' -- "$program" --quiet --steps 9 --config zero.toml
  expect 2 '--json needs a text in UTF-8' -- "$program" --quiet --steps 5 --json $'a\xff'
  expect 2 '--json needs a text of one line' -- "$program" --quiet --steps 5 --json $'a\nb'
  # The configuration beside an output says what is not given, and makes the run again.
  expect 0 -- "$program" --quiet --steps 5 --json $'a "b"\\<\t.json'
  grep -qx '# restart: not given' ./a*.config.toml || fail "the configuration names an empty restart"
  cp ./a*.config.toml again.toml
  rm ./a*.json
  expect 0 -- "$program" --config again.toml
  [[ -e $'a "b"\\<\t.json' ]] || fail "the configuration has another name"
  # Names control no terminal.
  local esc=$'\e]0;owned\a\r\xc2\x9b31m.h5'
  expect 1 '\x1b]0;owned\x07\x0d\x9b31m.h5 cannot be read' -- "$program" --quiet --restart "$esc"
  expect 2 '\x1b' -- "$program" $'--\e[2J'
  expect 2 'a\x9b31m.h5' -- "$program" --quiet --restart $'a\x9b31m.h5'
  expect 1 '\x1b' -- "$program" --quiet --steps 5 --json $'none/\e[2J' --log e.log
  ! LC_ALL=C grep -q $'[\e\a\r\x9b]' out e.log || fail "a name controls the terminal"
  # A pipe whose writer comes later, and a key of many parts.
  mkfifo late
  { sleep 0.5; exec 3>late; sleep 1.5; printf 'steps = ' >&3; sleep 1.5; printf '7\n' >&3; } &
  expect 0 -- "$program" --quiet --config late --json late.json
  grep -q '"steps": 7,' late.json || fail "a pipe that is written to later is not read"
  { printf 'a'; for ((n = 0; n < 50000; ++n)); do printf '.a'; done; printf ' = 1\n'; } >deep.toml
  { printf '# '; printf '.%.0s' {1..200}; printf '\nsteps = 6 # '; printf '.%.0s' {1..200}; } >dots.toml
  expect 0 -- "$program" --quiet --config dots.toml
  expect 2 'deep.toml:1: has a key with more than 100 dots' -- "$program" --quiet --config deep.toml
  nothing_left
}

# What a link leads to stays, whatever replaces the link; of a file with two names one is replaced.
links() {
  local option
  for option in --log --json --csv --checkpoint; do
    echo 'a diary' >text
    rm -f link hard
    ln -s text link
    ln text hard
    expect 1 'link is a symbolic link to text' -- "$program" --quiet --steps 5 $option link
    expect 1 'hard is there already' -- "$program" --quiet --steps 5 $option hard
    expect 0 -- "$program" --quiet --steps 5 $option link --force
    expect 0 -- "$program" --quiet --steps 5 $option hard --force
    [[ $(cat text) == 'a diary' && -f link && ! -L link && -s hard ]] || fail "$option --force destroys more than the link"
    rm -f link
    ln -s text link
    [[ $option == --log || $option == --json ]] || continue
    expect 0 -- "$program" --quiet --steps 5 --checkpoint c.h5
    expect 0 -- "$program" --quiet --steps 9 --restart c.h5 $option link --force
    [[ $(cat text) == 'a diary' && ! -L link ]] || fail "$option --force destroys more than the link at a restart"
  done
  # A restart goes on with a table or a log; another name of the file keeps what it has.
  for option in --log --csv; do
    expect 0 -- "$program" --quiet --steps 5 --checkpoint c.h5 $option goes_on
    ln goes_on other
    cp goes_on before
    expect 0 -- "$program" --quiet --steps 20 --restart c.h5 $option goes_on
    cmp other before || fail "a restart with $option changes another name of the file"
    (($(wc -l <goes_on) > $(wc -l <before))) || fail "a restart with $option has added nothing"
    [[ $option != --log ]] || head -c "$(stat -c %s before)" goes_on | cmp - before || fail "the restart has not kept the log"
    rm goes_on other
  done
  nothing_left
}

# Whether processes with that command line run, and all of them handle SIGUSR1.
hears() {
  local each mask all
  all=$(pgrep -f "$1") || return 1
  [[ $start != mpirun* && $start != */mpirun* || $(wc -l <<<"$all") == 2 ]] || return 1
  for each in $all; do
    mask=$(sed -n 's/^SigCgt:[[:space:]]*//p' /proc/$each/status 2>/dev/null) || return 1
    [[ -n $mask ]] && ((0x$mask >> 9 & 1)) || return 1
  done
}

# A signal in the first moments, and one when the terminal is gone.
early() {
  export OMPI_MCA_odls_base_sigkill_timeout=5  # from mpirun's SIGTERM to its SIGKILL; one second else
  local wait start code pid
  for start in "$program" "${launch[*]} $program"; do
    for wait in 0 0.05 0.2 0.5; do
      rm -f c.h5
      $start --quiet --steps 1000000000 --checkpoint c.h5 >out 2>&1 &
      pid=$!
      # Until the program itself runs; what its launcher or the loader does with the signal is not its own.
      until hears "^$program .*--checkpoint c.h5"; do
        kill -0 $pid || { cat out; fail "$start does not start"; }
        sleep 0.001
      done
      sleep $wait
      kill -USR1 $pid
      wait_for c.h5
      kill -0 $pid || fail "SIGUSR1 after $wait s ended $start"
      kill -TERM $pid
      wait $pid || true
    done
  done
  rm -f c.h5
  "$program" --steps 1000000000 --checkpoint c.h5 --csv t.csv >out 2>&1 &
  pid=$!
  wait_for t.csv
  kill -HUP $pid  # a closing terminal sends two
  kill -HUP $pid
  code=0
  wait $pid || code=$?
  [[ $code == 129 ]] || { cat out; fail "exit code $code after SIGHUP"; }
  grep -q 'ended by SIGHUP in step [0-9]*; go on with --restart c.h5' out || { cat out; fail "nobody says SIGHUP"; }
  [[ -e c.h5 ]] || fail "SIGHUP wrote nothing"
  nohup "$program" --quiet --steps 1000000000 --checkpoint d.h5 >out 2>&1 &
  pid=$!
  wait_for d.h5.lock
  sleep 0.3
  kill -HUP $pid
  sleep 0.5
  kill -0 $pid || fail "SIGHUP ended a run under nohup"
  kill -TERM $pid
  wait $pid || true
  nothing_left
}

# A signal ends a run that waits for the writer of its configuration.
waiting() {
  local signal pid code n
  mkfifo pipe
  for signal in TERM INT HUP; do
    python3 -c 'import os, signal, sys
signal.signal(signal.SIGINT, signal.SIG_DFL)
os.execv(sys.argv[1], sys.argv[1:])' "$program" --quiet --steps 5 --checkpoint c.h5 --config pipe >out 2>&1 &
    pid=$!
    sleep 1
    kill -0 $pid || { cat out; fail "a run waits for no writer"; }
    kill -$signal $pid
    for ((n = 0; n < 500; ++n)); do
      kill -0 $pid 2>/dev/null || break
      sleep 0.01
    done
    ! kill -0 $pid 2>/dev/null || fail "SIG$signal does not end a run that waits"
    code=0
    wait $pid || code=$?
    [[ $code == $((128 + $(kill -l $signal))) ]] || { cat out; fail "exit code $code after SIG$signal"; }
  done
  nothing_left
}

# A run that is killed just before a file gets its name, by a library between the program and the system,
# leaves the unfinished file.
leave_rest() {
  local named=$1 code=0
  shift
  LD_PRELOAD=$PWD/killed.so KILLED_BEFORE=$named "$program" --quiet --steps 5 "$@" >out 2>&1 || code=$?
  [[ $code == 137 ]] && compgen -G "$named.part-*" >/dev/null || { cat out; fail "no rest of $named, code $code"; }
}

# Every output is of one run at a time, and the rest of a killed run goes with the next one.
shared() {
  local option file
  cat >killed.c <<'END'
#define _GNU_SOURCE
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>
int rename(const char* from, const char* to) {
  if (strcmp(to, getenv("KILLED_BEFORE")) == 0) kill(getpid(), SIGKILL);
  return (int)syscall(SYS_rename, from, to);
}
END
  cc -shared -fPIC -o killed.so killed.c 2>out || echo "no run is killed before a file gets its name: $(cat out)"
  for option in --json --csv --log --view --output; do
    [[ $option != --view || -e ${TALUS_THREE:-/usr/share/javascript/three/three.min.js} ]] || continue
    file=x$option
    "$program" --quiet --steps 1000000000 $option $file >out1 2>&1 &
    local pid=$!
    local n=0
    until compgen -G "$file*.lock" >/dev/null; do
      sleep 0.01
      ((n += 1))
      ((n < 2000)) || fail "$option takes no lock"
    done
    sleep 0.2
    expect 1 "$file" "is being written by another run (process $pid on " -- "$program" --quiet --steps 5 $option ./$file
    # The contacts of the one output would be the bodies of the other.
    [[ $option != --output ]] ||
      expect 1 "${file}_contacts.hdf.series is being written by another run (process $pid on " -- \
        "$program" --quiet --steps 5 --output ${file}_contacts
    kill -KILL $pid
    wait $pid || true
    if [[ -e killed.so ]]; then
      if [[ $option == --output ]]; then
        leave_rest ${file}_contacts_0000000003.hdf $option $file --output-every 1
      else
        leave_rest $file $option $file
      fi
      [[ $option == --log ]] || leave_rest $file.config.toml $option $file
    fi
    expect 0 -- "$program" --quiet --steps 5 $option $file
    nothing_left
  done
  # Processes that end together, by an error, leave no lock.
  expect 1 'the checkpoint none cannot be read' -- \
    "${launch[@]}" "$program" --quiet --steps 5 --log failed --restart none
  nothing_left
  # What no run has made stays.
  : >mine.json.lock
  mkdir mine.json.part-folder
  ln -s /dev/null mine.json.part-linked
  echo mine >mine.json.part-backup
  expect 0 -- "$program" --quiet --steps 5 --json mine.json
  [[ -f mine.json.lock && ! -s mine.json.lock && -d mine.json.part-folder && -L mine.json.part-linked &&
    $(cat mine.json.part-backup) == mine ]] || fail "a file of the user is gone"
}

# While a run writes a series, no other run replaces its files and its configuration, also with --force; and no
# run begins a series one of whose files another run writes.
forced() {
  local pid n option file
  "$program" --quiet --steps 1000000000 --output x --output-every 10 --frames pictures --every 10 >out1 2>&1 &
  pid=$!
  wait_for x_0000000010.hdf
  wait_for pictures/frame_00001.pov
  for option in --json --csv --log --view --output --checkpoint; do
    [[ $option != --view || -e ${TALUS_THREE:-/usr/share/javascript/three/three.min.js} ]] || continue
    for file in x_0000000010.hdf ./x_contacts_0000000010.hdf x_9999999999.hdf pictures/frame_00001.pov; do
      [[ $option != --output ]] || continue
      expect 1 "$file belongs to the series " "which is being written by another run (process $pid on " -- \
        "$program" --quiet --steps 5 $option $file --force
    done
    file=x.config.toml
    [[ $option != --output ]] || file=x  # with a configuration of that name
    expect 1 "is being written by another run (process $pid on " -- "$program" --quiet --steps 5 $option $file --force
  done
  expect 1 "the configuration beside --json ./x.config.toml is being written by another run (process $pid on " -- \
    "$program" --quiet --steps 5 --json ./x --force
  kill -0 $pid || { cat out1; fail "the first run has ended"; }
  cmp -n 8 x_0000000010.hdf x_contacts_0000000010.hdf || fail "a file of the series is replaced"
  kill -TERM $pid
  wait $pid || true
  nothing_left
  expect 0 -- "$program" --quiet --steps 5 --csv x_0000000010.hdf --force
  rm x*
  "$program" --quiet --steps 1000000000 --csv x_0000000010.hdf >out1 2>&1 &
  pid=$!
  wait_for x_0000000010.hdf
  expect 1 "x_0000000010.hdf is being written by another run (process $pid on " -- \
    "$program" --quiet --steps 20 --output x --output-every 10 --force
  kill -TERM $pid
  wait $pid || true
  nothing_left
}

# Of two runs that begin at the same time one has the lock, and removes it at its end.
raced() {
  cat >raced.c <<'END'
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <unistd.h>
int flock(int f, int how) {
  static int before;
  for (int n = 0; before++ == 0 && access("go", F_OK) != 0 && n < 2000; ++n, before = 0) usleep(10000);
  return (int)syscall(SYS_flock, f, how);
}
END
  cc -shared -fPIC -o raced.so raced.c 2>out || { echo "no run waits before its lock: $(cat out)"; return 0; }
  LD_PRELOAD=$PWD/raced.so "$program" --quiet --steps 1000000000 --json r.json >out1 2>&1 &
  local first=$! second code=0
  sleep 0.5
  "$program" --quiet --steps 1000000000 --json r.json >out2 2>&1 &
  second=$!
  wait_for r.json.lock
  sleep 0.5
  : >go
  wait $first || code=$?
  [[ $code == 1 ]] || { cat out1; fail "exit code $code of the first run"; }
  grep -qF "r.json is being written by another run (process $second on " out1 || { cat out1; fail "nobody says who writes"; }
  kill -TERM $second
  wait $second || true
  nothing_left
}

# On a file system without locks the text of FILE.lock tells which run writes.
unlocked() {
  cat >unlocked.c <<'END'
#include <errno.h>
int flock(int f, int how) {
  (void)f, (void)how, errno = ENOLCK;
  return -1;
}
END
  cc -shared -fPIC -o unlocked.so unlocked.c 2>out || { echo "no file system lacks locks: $(cat out)"; return 0; }
  export LD_PRELOAD=$PWD/unlocked.so
  expect 0 -- "$program" --quiet --steps 5 --json u.json
  nothing_left
  rm u.json u.json.config.toml
  "$program" --quiet --steps 1000000000 --json u.json >out1 2>&1 &
  local pid=$!
  wait_for u.json.config.toml
  expect 1 "u.json is being written by another run (process $pid on " -- "$program" --quiet --steps 5 --json u.json
  kill -TERM $pid
  wait $pid || true
  unset LD_PRELOAD
  nothing_left
}

# A signal that ends a run leaves no lock. mpirun may give processes no time when another one is killed: then the
# next run removes the locks.
ended() {
  local signal pid code page=()
  [[ ! -e ${TALUS_THREE:-/usr/share/javascript/three/three.min.js} ]] || page=(--view e.html)
  for signal in TERM INT HUP USR1 XCPU; do
    rm -f l.log
    # (A shell without jobs starts what is in the background without SIGINT.)
    python3 -c 'import os, signal, sys
signal.signal(signal.SIGINT, signal.SIG_DFL)
os.execv(sys.argv[1], sys.argv[1:])' "$program" --quiet --steps 1000000000 --log l.log --json e.json --csv e.csv "${page[@]}" >out 2>&1 &
    pid=$!
    wait_for l.log
    wait_for e.csv.config.toml
    kill -$signal $pid
    code=0
    wait $pid || code=$?
    [[ $code == $((128 + $(kill -l $signal))) ]] || { cat out; fail "exit code $code after SIG$signal"; }
    nothing_left
    rm e.*
  done
  rm -f l.log
  "${launch[@]}" "$program" --quiet --steps 1000000000 --log l.log --json e.json --csv e.csv >out 2>&1 &
  pid=$!
  wait_for e.csv.config.toml
  # The process that holds no lock is killed.
  local holder each
  holder=$(sed -n 's/^process //p' e.json.lock)
  for each in $(pgrep -f "^$program .*--json e.json"); do [[ $each == "$holder" ]] || kill -KILL $each; done
  code=0
  wait $pid || code=$?
  [[ $code != 0 ]] || fail "a job without one of its processes ends well"
  expect 0 -- "$program" --quiet --steps 5 --log l.log --json e.json --csv e.csv
  nothing_left
}

# The index of a series is JSON whatever its name, and of this run alone.
index() {
  local odd=$'a "b"\\<\t'
  expect 0 -- "$program" --quiet --steps 200 --output "$odd" --output-every 100
  python3 - "$odd" <<'END'
import json, os, sys
for end in ("", "_contacts"):
    files = json.load(open(sys.argv[1] + end + ".hdf.series"))["files"]
    assert len(files) == 3 and all(os.path.exists(f["name"]) for f in files), files
END
  cp "$odd.hdf.series" before
  expect 0 "replaces a series" -- "$program" --steps 200 --output "$odd" --output-every 100
  cmp before "$odd.hdf.series"
  # One that has no room for a further line stays as it is.
  local long
  long=$(printf 'n%.0s' {1..200})
  (
    ulimit -f 12
    expect 1 '.series cannot be written: ' '(ulimit -f)' -- \
      "$program" --quiet --bodies 1 --steps 300 --output "$long" --output-every 1
  )
  python3 - "$long" <<'END'
import json, os, sys
for end in ("", "_contacts"):
    files = json.load(open(sys.argv[1] + end + ".hdf.series"))["files"]
    assert len(files) > 10 and all(os.path.exists(f["name"]) for f in files), files
END
  "$program" --quiet --steps 1000000000 --output r --output-every 10 >out 2>&1 &
  local pid=$! code=0
  wait_for r_contacts_0000000050.hdf
  cp before r.hdf.series.new
  mv r.hdf.series.new r.hdf.series
  wait $pid || code=$?
  [[ $code == 1 ]] || fail "exit code $code"
  grep -q 'the output r.hdf.series is no longer the index that this run has begun' out || { cat out; fail "nobody says so"; }
  cmp before r.hdf.series
  rm r*
  "$program" --quiet --steps 1000000000 --output r --output-every 10 >out 2>&1 &
  pid=$! code=0
  wait_for r_contacts_0000000050.hdf
  rm r_contacts.hdf.series
  wait $pid || code=$?
  [[ $code == 1 ]] || fail "exit code $code"
  grep -q 'the output r_contacts.hdf.series is no longer the index that this run has begun' out || { cat out; fail "nobody says so"; }
  nothing_left
}

# A table or a log that something else removes or replaces while the run goes on.
replaced() {
  local option way end
  for option in --csv --log; do
    end=1  # a table ends the run, a log is looked at when the time limit has
    [[ $option == --csv ]] || end=75
    for way in "rm t" "mv u t"; do
      echo mine >u
      rm -f t
      "$program" --quiet --steps 1000000000 --time-limit 2s $option t >out 2>&1 &
      local pid=$! code=0
      wait_for t
      sleep 0.3
      $way
      wait $pid || code=$?
      [[ $code == $end ]] || { cat out; fail "exit code $code: $option, $way"; }
      grep -q 't.* is no longer the file that this run has begun' out || { cat out; fail "nobody says so: $option, $way"; }
      [[ $way == rm* ]] || grep -qx mine t || fail "a file of the user is gone"
      rm -f t
    done
  done
}

"$what"
echo "$what: passed"
