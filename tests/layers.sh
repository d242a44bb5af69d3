#!/usr/bin/env bash
# Checks that headers include only from layers below their own, by the one spelling
# "talus/<layer>/<file>.hpp", that no headers include each other in a circle, that only the MPI
# transport includes MPI, and that the step and the integrators name no feature.
#   layers.sh INCLUDE_DIR | --self-test
set -euo pipefail

# Sets `level` to that of a header, from its path below talus/; empty for an unknown place. CONTRIBUTING.md and
# docs/architecture.md say what lives where.
find_level() {
  level=''
  case $1 in
    core/* | concepts.hpp) level=0 ;;
    geometry/* | shape/*) level=1 ;;
    body/* | contact/*) level=2 ;;
    detect/* | constraint/* | interaction/* | motion/*) level=3 ;;
    solver/* | parallel/*) level=4 ;;
    scenario/*) level=5 ;;
    state/*) level=6 ;;
    ghosts/*) level=7 ;;
    pairs/*) level=8 ;;
    features/*) level=9 ;;
    step/*) level=10 ;;
    world/*) level=11 ;;
    io/* | observe/*) level=12 ;;
    scene/*) level=13 ;;
    response/*) level=14 ;;  # former places of the solvers
    talus.hpp) level=14 ;;
    python/*) level=14 ;;
    python.hpp | mpi.hpp | checkpoint.hpp | vtk.hpp | mesh.hpp | config.hpp | observe.hpp | feature.hpp | liquid.hpp | filters.hpp | events.hpp | queries.hpp | adhesion.hpp) level=15 ;;
  esac
}

# Sets `layer` to the folder of a header.
find_layer() {
  case $1 in
    concepts.hpp) layer=core ;;
    *) layer=${1%%/*} ;;
  esac
}

# Sets `why` to the reason why header $1 (of the tree $3) may not include $2; empty if it may.
find_objection() {
  local from=$1 what=$2 tree=$3 from_level from_layer to level layer
  why=''
  find_level "$from" && from_level=$level
  find_layer "$from" && from_layer=$layer
  case $what in
    '<mpi.h>' | '<mpi/'* | '<boost/mpi'*)
      [[ $from =~ ^parallel/(detail/)?(mpi|as_launched) ]] ||
        why="only parallel/mpi*.hpp and parallel/as_launched.hpp may include MPI" ;;
    '"talus/'*.hpp'"')
      to=${what#'"talus/'} to=${to%'"'}
      find_level "$to"
      find_layer "$to"
      if [[ ! -e $tree/talus/$to ]]; then
        why="there is no such header"
      elif [[ -z $level ]]; then
        why="'$to' belongs to no layer"
      elif [[ $from_layer == "$layer" ]]; then
        :
      elif ((level >= from_level)); then
        why="layer '$from_layer' (level $from_level) may include only below its level, not '$layer' (level $level)"
      elif [[ $to == */detail/* ]]; then
        why="the details of layer '$layer' are its own"
      fi ;;
    '<talus'* | '"'*) why='spell it "talus/<layer>/<file>.hpp"' ;;
  esac
}

# Prints the headers of the tree $1 that include each other in a circle. X_definitions.hpp may
# include back the header that includes it: the two are one, in two files.
circles() {
  local tree=$1
  grep -rnoE '^[[:space:]]*#[[:space:]]*include[[:space:]]*"talus/[^"]*"' "$tree/talus" \
    --include='*.hpp' |
    sed -E 's#^([^:]*):[0-9]*:[^"]*"(talus/[^"]*)"#\1 '"$tree"'/\2#' |
    awk '{ to[$1, $2] = 1; from[NR] = $1; what[NR] = $2 }
         END { for (i = 1; i <= NR; ++i)
                 if (!(from[i] ~ /_definitions.hpp$/ && ((what[i], from[i]) in to)))
                   print from[i], what[i] }' |
    tsort 2>&1 >/dev/null | grep -v 'input contains a loop' | sed 's/^tsort: //' || true
}

check() {
  local tree=$1 faults=0 files=0 header from line what why level layer
  while IFS= read -r header; do
    files=$((files + 1))
    from=${header#"$tree"/talus/}
    find_level "$from"
    if [[ -z $level ]]; then
      echo "$header:1: lies in no layer"
      faults=$((faults + 1))
      continue
    fi
    while IFS=: read -r line what; do
      [[ $what =~ (\<[^\>]*\>|\"[^\"]*\") ]] && what=${BASH_REMATCH[1]}
      find_objection "$from" "$what" "$tree"
      if [[ -n $why ]]; then
        echo "$header:$line: $what: $why"
        faults=$((faults + 1))
      fi
    done < <(grep -nE '^[[:space:]]*#[[:space:]]*include[[:space:]]*(<(talus|mpi|boost/mpi)|")' \
      "$header" || true)
    if [[ $from == step/step.hpp || $from == step/integrators/* ]]; then
      while IFS=: read -r line what; do
        echo "$header:$line: $what: features act by their hooks, at stages: no step names one"
        faults=$((faults + 1))
      done < <(grep -nE 'monitored<|has_feature|world_state<.*>::(sleeps|drives|continuous|balances)' \
        "$header" || true)
    fi
  done < <(find "$tree/talus" -name '*.hpp' | sort)
  while IFS= read -r what; do
    echo "$what:1: is part of a circle of headers that include each other"
    faults=$((faults + 1))
  done < <(circles "$tree")
  echo "$files headers, $faults faults"
  ((faults == 0 && files > 0))
}

# A tree with one fault of each kind: every one must be found, with file and line.
self_test() {
  local out
  tree=$(mktemp -d)  # global, for the trap
  trap 'rm -rf "$tree"' EXIT
  mkdir -p "$tree"/talus/{core,shape,geometry/detail,step,state,world,odd,parallel}
  cd "$tree/talus"
  echo '#include "talus/shape/b.hpp"' >core/a.hpp
  printf '\n#include "talus/core/a.hpp"\n#include "talus/geometry/g.hpp"\n' >shape/b.hpp
  echo '#include <talus/core/a.hpp>' >geometry/g.hpp
  printf '#include "talus/core/none.hpp"\n#include "g.hpp"\n' >geometry/detail/h.hpp
  printf '#include "talus/geometry/detail/h.hpp"\n# include <boost/mpi.hpp>\n' >world/w.hpp
  echo '#include <mpi.h>' >parallel/mpi.hpp
  printf '\n  if constexpr (monitored<Scenario, energy_ledger>) book(s);\n' >step/step.hpp
  touch odd/o.hpp
  echo '#include "talus/state/q.hpp"' >state/p.hpp
  echo '#include "talus/state/p.hpp"' >state/q.hpp
  echo '#include "talus/state/x_definitions.hpp"' >state/x.hpp  # no circle: one header in two files
  echo '#include "talus/state/x.hpp"' >state/x_definitions.hpp
  out=$(check "$tree") && { echo "a tree full of faults passed"; exit 1; }
  echo "$out"
  local place
  for place in core/a.hpp:1 shape/b.hpp:3 geometry/g.hpp:1 geometry/detail/h.hpp:1 \
    geometry/detail/h.hpp:2 world/w.hpp:1 world/w.hpp:2 step/step.hpp:2 odd/o.hpp:1 \
    'state/p.hpp:1: is part of a circle' 'state/q.hpp:1: is part of a circle' \
    '12 headers, 13 faults'; do
    grep -q "$place" <<<"$out" || { echo "missed: $place"; exit 1; }
  done
}

if [[ ${1:?usage: layers.sh INCLUDE_DIR | --self-test} == --self-test ]]; then
  self_test
else
  check "$1"
fi
