#!/usr/bin/env bash
# The checkpoints of a run with damaged files, full disks, signals and killed ranks: with a real
# program.
#   checkpoint_runs.sh PROGRAM FOLDER WHAT [MPIRUN...]
# PROGRAM is the example drop, or well, which draws pictures; MPIRUN... starts it on two ranks.
set -euo pipefail
program=$1 folder=$2/$3 what=$3
shift 3
launch=("$@")
few=()  # what makes it small
[[ $(basename "$program") == well ]] && few=(--spheres 100)
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"

trap 'kill $(jobs -p) 2>/dev/null || true' EXIT  # what runs on after a failure
fail() { echo "FAILED: $*"; exit 1; }
digest() { sed -n 's/.*"state_digest": "\([0-9a-f]*\)".*/\1/p' "$1"; }

# Runs the program, which must end with the code, within a minute, and print all of the words.
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
run() { expect 0 -- "$program" --quiet "$@"; }
wait_for() {  # a file, for up to 20 s
  local n
  for ((n = 0; n < 2000; ++n)); do
    [[ -e $1 ]] && return
    sleep 0.01
  done
  fail "$1 does not come"
}

# Nothing remains of a checkpoint that could not be written, nor of its lock.
nothing_beside() {
  local left
  left=$(find "$(dirname "$1")" -maxdepth 1 -name "$(basename "$1").*" | head -n 1)
  [[ -z $left ]] || fail "$left is left behind"
}
# One line, without HDF5's own messages.
quiet_failure() {
  ! grep -qE '[.](part|lock)' out || fail "an unfinished file or a lock is left behind"
  ! grep -qiE 'HDF5|H5F|Segmentation|core dumped' out || { cat out; fail "HDF5 says something"; }
  [[ $(grep -vcx 'c.h5' out) == 1 ]] || { cat out; fail "more than one line"; }
}

# A disk that cannot reserve room and becomes full after so many bytes, as network disks do: by a
# library between the program and the system.
full_while_writing() {
  cat >full.c <<'END'
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>
static long left = -1;
static int full(size_t bytes) {
  if (left < 0) left = atol(getenv("DISK_BYTES"));
  if ((long)bytes <= left) { left -= (long)bytes; return 0; }
  errno = ENOSPC;
  return 1;
}
int fallocate(int f, int mode, off_t at, off_t bytes) {
  (void)f; (void)mode; (void)at; (void)bytes; errno = EOPNOTSUPP; return -1;
}
int fallocate64(int f, int mode, off_t at, off_t bytes) { return fallocate(f, mode, at, bytes); }
ssize_t pwrite(int f, const void* from, size_t bytes, off_t at) {
  return full(bytes) ? -1 : syscall(SYS_pwrite64, f, from, bytes, at);
}
ssize_t pwrite64(int f, const void* from, size_t bytes, off_t at) { return pwrite(f, from, bytes, at); }
ssize_t write(int f, const void* from, size_t bytes) {
  return f > 2 && full(bytes) ? -1 : syscall(SYS_write, f, from, bytes);
}
END
  cc -shared -fPIC -o full.so full.c 2>out || { echo "no disk to pretend: $(cat out)"; return 0; }
  local bytes ranks
  for bytes in 0 20000 90000; do
    for ranks in 1 2; do
      expect 1 'the checkpoint c.h5 cannot be written: there is no room for' 'are missing' -- \
        env LD_PRELOAD="$PWD/full.so" DISK_BYTES=$bytes \
        "$program" --quiet --ranks "$ranks" --steps 20 --checkpoint c.h5 --checkpoint-every 20
      quiet_failure
      cmp c.h5 before.h5
      nothing_beside c.h5
    done
  done
  expect 1 'the checkpoint c.h5 cannot be written: there is no room for' 'are missing' -- \
    env LD_PRELOAD="$PWD/full.so" DISK_BYTES=30000 \
    "${launch[@]}" "$program" --quiet --steps 20 --checkpoint c.h5 --checkpoint-every 20
  cmp c.h5 before.h5
}

damage() {
  run --steps 30 --checkpoint good.h5 --checkpoint-every 30
  run --steps 30 --restart good.h5
  local size at byte flipped=0
  size=$(stat -c %s good.h5)
  # Single bits: the first block, HDF5's own metadata, the tables.
  for ((at = 0; at < size; at += at < 4096 ? 97 : size / 150)); do
    cp good.h5 bad.h5
    byte=$(od -An -tu1 -j "$at" -N 1 good.h5)
    printf "\\x$(printf %02x $((byte ^ 1 << at % 8)))" |
      dd of=bad.h5 bs=1 seek="$at" conv=notrunc status=none
    expect 1 'drop: the checkpoint bad.h5 is ' -- "$program" --quiet --steps 30 --restart bad.h5
    flipped=$((flipped + 1))
  done
  ((flipped > 150)) || fail "only $flipped bits were tried"
  local length
  for length in 0 1 31 32 55 100 511 512 513 4096 $((size / 2)) $((size - 1)); do
    head -c "$length" good.h5 >bad.h5
    expect 1 'drop: the checkpoint bad.h5 is ' -- "$program" --quiet --steps 30 --restart bad.h5
  done
  { cat good.h5; echo; } >bad.h5
  expect 1 "is damaged: it has $((size + 1)) bytes, but was written with $size" -- \
    "$program" --quiet --steps 30 --restart bad.h5
  expect 1 'none.h5 cannot be read: No such file or directory; --restart takes a file that --checkpoint has written: look for it, or leave --restart out' -- "$program" --quiet --restart none.h5
  rm -f pipe
  mkfifo pipe
  for other in . pipe /dev/zero; do
    expect 1 'cannot be read: it is no file' -- "$program" --quiet --restart "$other"
  done
  expect 1 'is of step 30, but this run ends with step 20' -- \
    "$program" --quiet --steps 20 --restart good.h5
  # If ranks are processes one of them prints it.
  head -c 5000 good.h5 >bad.h5
  expect 1 'the checkpoint bad.h5 is damaged: it has 5000 bytes' -- \
    "${launch[@]}" "$program" --quiet --steps 30 --restart bad.h5
  [[ $(grep -c 'is damaged' out) == 1 ]] || fail "more than one rank complains"
}

unwritable() {
  expect 1 'the checkpoint none/c.h5 cannot be written: none/c.h5: No such file' -- \
    "$program" --quiet --checkpoint none/c.h5
  echo >file
  expect 1 'the checkpoint file/c.h5 cannot be written: file/c.h5: Not a directory' -- \
    "$program" --quiet --checkpoint file/c.h5
  expect 1 'cannot be written: /sys/c.h5: ' -- "$program" --quiet --checkpoint /sys/c.h5
  # A disk that becomes full: the last version stays, and can be used.
  run --steps 20 --checkpoint c.h5 --checkpoint-every 20
  cp c.h5 before.h5
  local ranks
  for ranks in 1 2; do
    (
      ulimit -f 60
      expect 1 'the checkpoint c.h5 cannot be written: it needs some' 'ulimit -f' 'are missing' -- \
        "$program" --quiet --ranks "$ranks" --steps 40 --checkpoint c.h5 --checkpoint-every 20
    )
    cmp c.h5 before.h5
    nothing_beside c.h5
  done
  full_while_writing
  # (If this may mount a disk of its own.)
  mkdir disk
  cat >on_small_disk.sh <<'END'
set -e
kilobytes=$(($(stat -c %s c.h5) / 4096 * 4 + 4))
mount -t tmpfs -o size=$((kilobytes + FREE))k none disk
cp c.h5 disk
"$@" || code=$?
cmp c.h5 disk/c.h5
ls disk
exit ${code:-0}
END
  if unshare -rm mount -t tmpfs none disk 2>out; then
    # Next to nothing, some tens of kilobytes, and half of the required size.
    for FREE in 4 20 60 $(($(stat -c %s c.h5) / 2048)); do
      export FREE
      for ranks in 1 2; do
        expect 1 'the checkpoint disk/c.h5 cannot be written: there is no room for ' 'are missing' -- \
          unshare -rm bash on_small_disk.sh \
          "$program" --quiet --ranks "$ranks" --steps 20 --checkpoint disk/c.h5 --checkpoint-every 20
        quiet_failure
      done
    done
    expect 1 'cannot be written: there is no room for ' 'are missing' -- unshare -rm bash on_small_disk.sh \
      "${launch[@]}" "$program" --quiet --steps 20 --checkpoint disk/c.h5 --checkpoint-every 20
    [[ $(grep -c 'no room for' out) == 1 ]] || fail "more than one rank complains"
  else
    echo "no disk to fill: $(cat out)"
  fi
  run --steps 20 --restart c.h5
}

signals() {
  export OMPI_MCA_odls_base_sigkill_timeout=5  # from mpirun's SIGTERM to its SIGKILL; one second else
  local how code pid steps signal
  for how in serial threads mpi serial-INT threads-INT; do
    signal=TERM  # or INT, that is Ctrl-C; mpirun makes SIGTERM of it
    [[ $how == *-INT ]] && signal=INT
    local start=("$program")
    [[ $how == threads* ]] && start+=(--ranks 2)
    [[ $how == mpi ]] && start=("${launch[@]}" "${start[@]}")
    rm -f c.h5 t.csv
    "${start[@]}" --steps 1000000000 --csv t.csv --csv-every 1 --checkpoint c.h5 >out 2>&1 &
    pid=$!
    wait_for t.csv
    until [[ $(wc -l <t.csv) -gt 10 ]]; do sleep 0.01; done
    kill -USR1 $pid
    wait_for c.h5
    cp c.h5 first.h5
    sleep 0.3
    kill -0 $pid || fail "SIGUSR1 ended the run ($how)"
    kill -$signal $pid
    code=0
    wait $pid || code=$?
    cat out
    # mpirun returns 1 after a signal to end.
    [[ ($signal == TERM && $code == 143) || ($signal == INT && $code == 130) ||
      ($how == mpi && $code == 1) ]] || fail "exit code $code ($how)"
    steps=$(sed -n "s/.*ended by SIG$signal in step \([0-9]*\); go on with --restart c.h5/\1/p" out)
    [[ -n $steps ]] || fail "nobody says that it was SIG$signal ($how)"
    ! cmp -s c.h5 first.h5 || fail "SIG$signal wrote nothing ($how)"
    run --steps "$steps" --restart c.h5 --csv t.csv --csv-every 1 --json end.json
    grep -q "\"steps\": $steps," end.json || fail "the run does not go on in step $steps ($how)"
    [[ $(tail -n 1 t.csv) == "$steps",* ]] || fail "the table does not end with step $steps ($how)"
    [[ $(wc -l <t.csv) == $((steps + 2)) ]] || fail "the table lacks lines ($how)"
  done
}

# Starts the program on two ranks, in the background.
start() {
  "${launch[@]}" "$program" "${few[@]}" --quiet --checkpoint c.h5 "$@" >out 2>&1 &
  pid=$!
}
# Kills one of the two: a program whose parent is that mpirun. (Not a copy of mpirun that is about to
# become it: mpirun may not notice the death of such a copy.)
kill_a_rank() {
  local victim=
  until [[ -n $victim ]]; do
    kill -0 $pid 2>/dev/null || fail "no rank to kill"
    victim=$(pgrep -P "$pid" -f -- "^$program .*--checkpoint c.h5" | tail -n 1) || true
  done
  "$@"
  kill -KILL "$victim" 2>/dev/null || true
}
# Whether a rank of the job exists and is not a zombie, whatever its parent is by now.
ranks_live() {
  ps -eo stat=,args= | awk -v program="$program" '
    $1 !~ /^Z/ && $2 == program && / --checkpoint c.h5/ { found = 1 } END { exit !found }'
}
# The whole job ends within seconds, with `code`. With "or mpirun" at least the ranks do. (In 3 of 570
# kills before the rank had reached it, the mpirun of Open MPI 4.1.4 was left alone, waiting in
# PMIx_server_finalize for a lock without a holder.)
ends_soon() {
  local n
  for ((n = 0; n < 1000; ++n)); do
    kill -0 $pid 2>/dev/null || break
    sleep 0.01
  done
  ! ranks_live || fail "the job goes on"
  if kill -0 $pid 2>/dev/null; then
    [[ $* == 'or mpirun' ]] || fail "mpirun goes on"
    echo "mpirun alone was left"
    kill -KILL $pid
  fi
  wait $pid && code=0 || code=$?
}
# From the last checkpoint the run reaches the end state of an uninterrupted run.
goes_on() {
  expect 0 -- "${launch[@]}" "$program" "${few[@]}" --quiet --steps 600 --checkpoint c.h5 \
    --checkpoint-every 30 --json end.json "$@"
  [[ $(digest end.json) == $(digest whole.json) ]] || fail "another end than without the accident"
  nothing_beside c.h5
}
whole_run() {
  expect 0 -- "${launch[@]}" "$program" "${few[@]}" --quiet --steps 600 --checkpoint whole.h5 \
    --checkpoint-every 30 --json whole.json
}

# While a file is being written, repeated until an unfinished one remains.
killed_writing() {
  local attempt n
  whole_run
  for ((attempt = 1; attempt <= 40; ++attempt)); do
    rm -f c.h5 c.h5.part-*
    start --steps 600 --checkpoint-every 30
    wait_for c.h5
    kill_a_rank eval 'for ((n = 0; n < 200000; ++n)); do ! compgen -G "c.h5.part-*" >/dev/null || break; done'
    ends_soon
    compgen -G 'c.h5.part-*' >/dev/null && [[ $code != 0 ]] && break
  done
  compgen -G 'c.h5.part-*' >/dev/null || fail "no rank could be killed in time"
  echo "killed in attempt $attempt"
  goes_on --restart c.h5
}

# While the job starts and the scene is set up: at the first sight of a rank, and later and later
# until there is a first step. Nothing was kept yet, so the run begins again.
killed_setting_up() {
  local wait
  whole_run
  for wait in 0 0.005 0.01 0.02 0.04 0.08 0.16; do
    rm -f c.h5 t.csv
    start --steps 1000000000 --csv t.csv --csv-every 1
    kill_a_rank sleep $wait
    [[ -e t.csv ]] && echo "after $wait s there are steps"
    ends_soon or mpirun
    [[ $code != 0 ]] || fail "a job with a killed rank ends well"
  done
  goes_on
}

# In a step, and while pictures are being written after every step.
killed_stepping() {
  local output
  whole_run
  for output in "" "--frames pictures --every 1"; do
    rm -rf c.h5 t.csv pictures
    # shellcheck disable=SC2086  # two words or none
    start --steps 1000000000 --checkpoint-every 30 --csv t.csv --csv-every 1 $output
    wait_for t.csv
    until [[ $(wc -l <t.csv) -gt 50 ]]; do sleep 0.01; done
    if [[ -n $output ]]; then [[ $(ls pictures | wc -l) -gt 10 ]] || fail "no pictures"; fi
    kill_a_rank
    ends_soon
    [[ $code != 0 ]] || fail "a job with a killed rank ends well"
    goes_on --restart c.h5
  done
}

# Continues from c.h5 and keeps it, without waiting for the end of the run.
goes_on_for_a_while() {
  rm -f t.csv
  "$program" --steps 1000000000 --restart c.h5 --checkpoint c.h5 --csv t.csv --csv-every 1 "$@" \
    >out 2>&1 &
  local last=$! code=0
  wait_for t.csv
  until [[ $(wc -l <t.csv) -gt 2 ]]; do
    kill -0 $last 2>/dev/null || { cat out; fail "the run does not go on"; }
    sleep 0.01
  done
  kill -TERM $last
  wait $last || code=$?
  [[ $code == 143 ]] || { cat out; fail "exit code $code"; }
}

# Killed at any moment, most of them while a file is being written: a run can continue from the existing
# file, and the files of killed runs block no other run.
killed_anywhere() {
  local ranks kills n pid step
  for ranks in 1 2; do
    rm -f c.h5*
    run --ranks "$ranks" --steps 3 --checkpoint c.h5
    for ((kills = 0; kills < 25; ++kills)); do
      "$program" --quiet --ranks "$ranks" --steps 1000000 --checkpoint c.h5 --checkpoint-every 1 \
        --restart c.h5 >out 2>&1 &
      pid=$!
      # The lock is taken when the run begins.
      for ((n = 0; n < 1000; ++n)); do [[ ! -s c.h5.lock ]] || break; sleep 0.002; done
      sleep "0.0$((RANDOM % 90 + 10))"
      kill -KILL $pid || { cat out; fail "the run has ended by itself after $kills kills"; }
      wait $pid 2>/dev/null || true
    done
    goes_on_for_a_while --ranks "$ranks"
    step=$(sed -n 's/.*ended by SIGTERM in step \([0-9]*\);.*/\1/p' out)
    ((${step:-0} > kills)) || { cat out; fail "hardly a step was kept"; }
    echo "$kills kills, step $step"
    nothing_beside c.h5
  done
}

# A requeued job that overlaps its predecessor.
two_runs() {
  local how
  for how in serial threads mpi; do
    local start=("$program")
    [[ $how == threads ]] && start+=(--ranks 2)
    [[ $how == mpi ]] && start=("${launch[@]}" "${start[@]}")
    rm -f c.h5* t.csv
    run --steps 3 --csv t.csv --csv-every 1
    cp t.csv before.csv
    "${start[@]}" --quiet --steps 1000000000 --checkpoint c.h5 --checkpoint-every 5 >out1 2>&1 &
    pid=$!
    wait_for c.h5
    # It prints the holder of the lock, and changes nothing.
    expect 1 'the checkpoint c.h5 is being written by another run (process ' "on $(uname -n), since" \
      'wait for its end or stop it, or name another file' -- \
      "${start[@]}" --quiet --steps 10 --checkpoint c.h5 --csv t.csv
    expect 1 'is being written by another run' -- \
      "$program" --quiet --steps 10 --checkpoint ./c.h5 --restart c.h5
    cmp t.csv before.csv || fail "the refused run has touched another file"
    kill -0 $pid || fail "the first run has ended ($how)"
    # Others can meanwhile continue from its files.
    run --steps 3 --checkpoint d.h5
    expect 1 'is of step' 'but this run ends with step 1:' -- \
      "$program" --quiet --steps 1 --restart c.h5 --checkpoint d.h5
    if [[ $how == mpi ]]; then
      kill -KILL "$(sed -n 's/^process //p' c.h5.lock)"  # the rank that writes; mpirun ends the others
      wait $pid || true
    else
      kill -KILL $pid
      wait $pid 2>/dev/null || true
    fi
    # The rest of it does not block the next one, which cleans up.
    [[ -e c.h5.lock ]] || fail "the lock of a killed run is gone"
    goes_on_for_a_while
    nothing_beside c.h5
  done
}

# An output replaces regular files of its own kind, and nothing else unless it is forced.
foreign() {
  local option what file
  mkdir folder
  echo 'a diary' >text
  ln -s text link
  ln -s nowhere dangling
  printf '\211HDF\r\n\032\nsomething else' >other.hdf
  mkfifo pipe
  local all=(folder text link dangling other.hdf)
  mknod node c 1 3 2>/dev/null && all+=(node)
  for option in --checkpoint --json --csv; do
    for what in "${all[@]}"; do
      expect 1 "$what is " -- "$program" --quiet --steps 1000000000 $option $what
      [[ $(wc -l <out) == 1 ]] || { cat out; fail "more than one line"; }
    done
  done
  expect 1 'the checkpoint folder is a folder: name a file in it' -- "$program" --checkpoint folder
  expect 1 'the checkpoint pipe is a device, a pipe or a socket' -- "$program" --checkpoint pipe
  expect 1 'text is there already and is not a checkpoint of talus' 'add --force' -- "$program" --checkpoint text
  expect 1 'link is a symbolic link to text: name the file itself' -- "$program" --checkpoint link
  # Not by another name of the file beside it either.
  ln -s text c.h5.part
  ln -s text j.json.part
  # One kind of output is foreign to the other.
  run --steps 5 --checkpoint c.h5 --json j.json --csv t.csv
  expect 1 'j.json is there already and is not a checkpoint' -- "$program" --quiet --checkpoint j.json
  expect 1 'c.h5 is there already and is not the results' -- "$program" --quiet --json c.h5
  expect 1 'j.json is there already and is not a time series' -- "$program" --quiet --csv j.json
  expect 2 '--json and --csv name the same file' -- "$program" --quiet --json x --csv x
  [[ $(cat text) == 'a diary' && -L link && -L dangling && ! -e nowhere && -d folder ]] ||
    fail "something was replaced"
  [[ ! -e node || -c node ]] || fail "a device was replaced"
  # Files of its own are replaced, with one message, without --quiet; empty ones have no content.
  : >empty.json
  expect 0 'j.json replaces' 't.csv replaces' 'c.h5 replaces a checkpoint' -- \
    "$program" --steps 5 --checkpoint c.h5 --json j.json --csv t.csv
  run --steps 5 --json empty.json
  [[ -s empty.json ]] || fail "an empty file is not written to"
  # By force; folders and devices never.
  cp text text2
  run --steps 5 --json text2 --checkpoint link --csv dangling --force
  [[ $(digest text2) != '' && $(cat text) == 'a diary' && -f link && ! -L link && ! -L dangling ]] ||
    fail "--force does not replace what it should, or more"
  ln -s pipe to_pipe
  ln -s folder to_folder
  for what in pipe to_pipe; do
    expect 1 "$what is a device" -- "$program" --quiet --force --checkpoint $what
  done
  [[ ! -e node ]] || ln -s node to_node
  ln -s pipe p.json.config.toml
  expect 1 'p.json.config.toml is a device' -- "$program" --quiet --force --json p.json
  for option in --checkpoint --json --csv --log; do
    for what in folder to_folder; do
      expect 1 "$what is a folder" -- "$program" --quiet --force $option $what
    done
    [[ -e node ]] || continue
    for what in node to_node; do
      expect 1 "$what is a device" -- "$program" --quiet --force $option $what
    done
  done
  [[ -p pipe && -L to_pipe && -L to_folder && (! -e node || -L to_node) ]] || fail "a link is replaced"
  # Targets that are written to instead of replaced.
  [[ $("$program" --quiet --steps 5 --json /dev/stdout | digest /dev/stdin) == "$(digest j.json)" ]] ||
    fail "results do not go to a pipe"
  expect 0 'step [1],time [T]' -- "$program" --quiet --steps 5 --csv /dev/stdout
}

"$what"
echo "$what: passed"
