#!/usr/bin/env bash
# The ends of runs of a real program, serially, as threads and under MPI: from files of options, until
# rest, at a time limit with a checkpoint, dry.
#   run_ends.sh PROGRAM FOLDER WHAT [MPIRUN...]
# PROGRAM is the example drop; MPIRUN... starts it on two ranks.
set -euo pipefail
program=$1 folder=$2/$3 what=$3
shift 3
launch=("$@")
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"

fail() { echo "FAILED: $*"; exit 1; }
value() { sed -n "s/.*\"$1\": \"\\{0,1\\}\\([^\",]*\\).*/\\1/p" "$2"; }

# Runs the program, which must end with the code within two minutes, and print all of the words.
expect() {
  local code=$1 got=0 word
  shift
  local words=()
  while [[ $1 != -- ]]; do words+=("$1"); shift; done
  shift
  timeout -k 5 120 "$@" >out 2>&1 || got=$?
  [[ $got == "$code" ]] || { cat out; fail "exit code $got instead of $code: $*"; }
  for word in "${words[@]}"; do
    grep -qF -- "$word" out || { cat out; fail "nothing says '$word': $*"; }
  done
}

# The same file of options on one rank, on four threads and under MPI; what it wrote makes the run again.
config() {
  cat >drop.toml <<'END'
steps = 60
reproducible = true
quiet = true
seed = 5
END
  local n=0 first='' json
  for ranks in "$program --ranks 1" "$program --ranks 4" "${launch[*]} $program"; do
    json=$((n += 1)).json
    expect 0 -- $ranks --config drop.toml --json "$json"
    [[ $(value steps "$json") == 60 ]] || fail "steps of the file"
    [[ -n $first ]] || first=$(value state_digest "$json")
    [[ $(value state_digest "$json") == "$first" ]] || fail "another digest: $ranks"
    grep -q '^seed = 5  # drop.toml:4$' "$json.config.toml" || fail "no configuration beside $json"
  done
  cp 2.json.config.toml again.toml
  rm 2.json
  expect 0 -- "$program" --config again.toml
  [[ $(value state_digest 2.json) == "$first" ]] || fail "the configuration makes another run"
}

# A fault in a file is reported once, and no rank waits.
faults() {
  printf 'steps = 60\nitertions = 5\n' >drop.toml
  local ranks
  for ranks in "$program" "${launch[*]} $program"; do
    expect 2 "drop: drop.toml:2: 'itertions' is not an option of this program; did you mean iterations?" \
      -- $ranks --config drop.toml
    [[ $(grep -c itertions out) == 1 ]] || { cat out; fail "said more than once"; }
    expect 2 'drop: --config none.toml cannot be read: No such file' -- $ranks --config none.toml
    [[ $(grep -c none.toml out) == 1 ]] || { cat out; fail "said more than once"; }
    expect 2 'drop: --config . cannot be read: it is a folder' -- $ranks --config .
  done
  # One of the ranks reads another file: none computes.
  cat >each.sh <<'END'
#!/bin/sh
r=${OMPI_COMM_WORLD_RANK:-$PMI_RANK}
mkdir -p r$r && cd r$r
printf 'seed = %d\n' "$r" >x.toml
exec "$1" --quiet --steps 5 --config x.toml --json o.json
END
  chmod +x each.sh
  local got=0
  timeout -k 5 60 "${launch[@]}" ./each.sh "$program" >out 2>&1 || got=$?
  [[ $got != 0 && $got != 124 && $got != 137 ]] || { cat out; fail "exit code $got"; }
  grep -q 'the ranks have different options' out || { cat out; fail "nobody says that they differ"; }
  [[ ! -e r0/o.json ]] || fail "results of a run that was refused"
}

# All ranks end in the same step; where the bits are those of one rank, it is the step of one rank.
rest() {
  local n=0 first='' steps='' json ranks
  for ranks in "$program --ranks 1" "$program --ranks 2" "$program --ranks 4" "${launch[*]} $program"; do
    json=$((n += 1)).json
    expect 0 'ended by --until rest in step' -- $ranks --reproducible --steps 20000 --dt 0.005 \
      --until rest --until-speed 0.2 --json "$json"
    [[ $(value ended_by "$json") == rest ]] || fail "not ended by rest"
    [[ -n $first ]] || first=$(value state_digest "$json") steps=$(value steps "$json")
    [[ $(value steps "$json") == "$steps" ]] || fail "$(value steps "$json") steps, not $steps: $ranks"
    [[ $(value state_digest "$json") == "$first" ]] || fail "another digest: $ranks"
  done
  echo "at rest after $steps steps"
  ((steps > 200 && steps < 20000)) || fail "$steps steps"
}

# The state is kept at the limit, and a restart goes on from it to the same end.
limit() {
  expect 0 -- "$program" --quiet --reproducible --steps 2000 --json whole.json
  local ranks code=0 times=0
  for ranks in "$program --ranks 1" "$program --ranks 4" "${launch[*]} $program"; do
    rm -f c.h5
    expect 75 'drop: ended by --time-limit in step' 'go on with --restart c.h5' -- $ranks --reproducible \
      --steps 10000000 --time-limit 2 --checkpoint c.h5 --json part.json
    [[ -e c.h5 ]] || fail "no checkpoint"
    [[ $(value ended_by part.json) == 'time limit' ]] || fail "ended by something else"
  done
  # The end of the limited run is not the end of the call of simulate(): it goes on.
  rm -f c.h5
  expect 75 'ended by --time-limit' -- "$program" --reproducible --steps 10000000 --time-limit 1 \
    --checkpoint c.h5 --json part.json
  local at
  at=$(value steps part.json)
  expect 0 -- "$program" --quiet --reproducible --steps $((at + 50)) --restart c.h5 --json on.json
  [[ $(value steps on.json) == $((at + 50)) ]] || fail "it has not gone on"
  expect 0 -- "$program" --quiet --reproducible --steps $((at + 50)) --json straight.json
  [[ $(value state_digest on.json) == "$(value state_digest straight.json)" ]] || fail "another digest"
}

# A killed run keeps the lines of its log; a restart adds to it, and another run replaces it.
logged() {
  "$program" --quiet --seed 3 --steps 1000000000 --log l.log --checkpoint c.h5 --checkpoint-every 50 &
  local pid=$! n
  for ((n = 0; n < 2000; ++n)); do
    [[ -e c.h5 ]] && break
    sleep 0.01
  done
  kill -KILL $pid
  wait $pid || true
  grep -q '^seed         3$' l.log || fail "the log of the killed run has no seed"
  ! grep -q '^digest' l.log || fail "the log of the killed run has a digest"
  expect 1 'the checkpoint c.h5 is of step' -- "$program" --quiet --steps 1 --restart c.h5 --log l.log
  grep -q 'the checkpoint c.h5 is of step' l.log || fail "the log has no error"
  [[ $(grep -c '^# log of a run of talus: drop$' l.log) == 2 ]] || fail "the restart has not added to the log"
  expect 0 -- "${launch[@]}" "$program" --quiet --steps 5 --log l.log --json o.json
  [[ $(grep -c '^# log of a run of talus: drop$' l.log) == 1 ]] || fail "the log was not replaced"
  grep -q '^ranks        2$' l.log || fail "the log has no ranks"
  grep -q "^digest $(value state_digest o.json), " l.log || fail "the log has no digest"
}

# The estimate beside the run itself, and the configuration in the checkpoint.
dry() {
  local ranks
  for ranks in "$program" "$program --ranks 4" "${launch[*]} $program"; do
    expect 0 'drop: dry run, no output of the options is written' 'bodies   729, of which 729 can move' \
      'for the 700 steps' -- $ranks --dry-run --steps 700 --json o.json --checkpoint c.h5 --log l.log
    [[ ! -e o.json && ! -e c.h5 && ! -e l.log && ! -e o.json.config.toml ]] || fail "files of a dry run"
  done
  # Without a step, and of a run that is complete.
  expect 0 -- "$program" --quiet --steps 5 --checkpoint five.h5
  expect 0 'there is no step to be made' -- "$program" --dry-run --steps 0
  expect 0 'there is no step to be made' -- "$program" --dry-run --steps 5 --restart five.h5
  expect 0 -- "$program" --dry-run --steps 700
  local estimate
  estimate=$(sed -n "s/.* on the rank with most, about \([0-9.]*\) \([kM]B\) at rest.*/\1\2/p" out |
    sed 's/kB/e3/; s/MB/e6/')
  expect 0 -- "$program" --quiet --steps 700 --json o.json --checkpoint c.h5
  local found
  found=$(value bytes_per_body o.json)
  awk -v e="$estimate" -v f="$found" 'BEGIN { r = e / (f * 729); print "estimate over memory at the end:", r
    exit !(r > 0.5 && r < 2.5) }' || fail "the estimate $estimate beside $found a body"
  if command -v h5dump >/dev/null; then
    h5dump -d /run/configuration -b LE -o again.toml c.h5 >/dev/null
    grep -q 'steps = 700  # command line' again.toml || fail "no configuration in c.h5"
    cp o.json before.json
    expect 0 -- "$program" --config again.toml
    [[ $(value state_digest o.json) == "$(value state_digest before.json)" ]] || fail "another digest"
  else
    grep -aq 'steps = 700  # command line' c.h5 || fail "no configuration in c.h5"
  fi
}

"$what"
