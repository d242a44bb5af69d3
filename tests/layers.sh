#!/usr/bin/env bash
# Checks that headers include only from layers below their own, by the one spelling
# "talus/<layer>/<file>.hpp", that only the MPI transport includes MPI, and that the step and the
# integrators name no feature.
#   layers.sh INCLUDE_DIR | --self-test
set -euo pipefail

# Level of a header, from its path below talus/; empty for an unknown place.
level() {
  case $1 in
    core/* | concepts.hpp) echo 0 ;;
    geometry/* | shape/*) echo 1 ;;
    body/* | contact/*) echo 2 ;;
    detect/* | response/* | parallel/* | interaction/*) echo 3 ;;
    world/*) echo 4 ;;
    io/* | observe/*) echo 5 ;;
    scene/*) echo 6 ;;
    talus.hpp) echo 7 ;;
    mpi.hpp | checkpoint.hpp | vtk.hpp | mesh.hpp | observe.hpp | feature.hpp) echo 8 ;;
  esac
}

layer() {
  case $1 in
    concepts.hpp) echo core ;;
    */*) echo "${1%%/*}" ;;
    *) echo "$1" ;;
  esac
}

# Prints why header $1 (of the tree $3) may not include $2; nothing if it may.
objection() {
  local from=$1 what=$2 tree=$3 from_level to to_level
  from_level=$(level "$from")
  case $what in
    '<mpi.h>' | '<mpi/'* | '<boost/mpi'*)
      [[ $from =~ ^parallel/(detail/)?(mpi|as_launched) ]] ||
        echo "only parallel/mpi*.hpp and parallel/as_launched.hpp may include MPI" ;;
    '"talus/'*.hpp'"')
      to=${what#'"talus/'} to=${to%'"'}
      to_level=$(level "$to")
      if [[ ! -e $tree/talus/$to ]]; then
        echo "there is no such header"
      elif [[ -z $to_level ]]; then
        echo "'$to' belongs to no layer"
      elif [[ $(layer "$from") == $(layer "$to") ]]; then
        :
      elif ((to_level >= from_level)); then
        echo "layer '$(layer "$from")' (level $from_level) may include only below its level," \
          "not '$(layer "$to")' (level $to_level)"
      elif [[ $to == */detail/* ]]; then
        echo "the details of layer '$(layer "$to")' are its own"
      fi ;;
    '<talus'* | '"'*) echo 'spell it "talus/<layer>/<file>.hpp"' ;;
  esac
}

check() {
  local tree=$1 faults=0 files=0 header from line what why
  while IFS= read -r header; do
    files=$((files + 1))
    from=${header#"$tree"/talus/}
    if [[ -z $(level "$from") ]]; then
      echo "$header:1: lies in no layer"
      faults=$((faults + 1))
      continue
    fi
    while IFS=: read -r line what; do
      [[ $what =~ (\<[^\>]*\>|\"[^\"]*\") ]] && what=${BASH_REMATCH[1]}
      why=$(objection "$from" "$what" "$tree")
      if [[ -n $why ]]; then
        echo "$header:$line: $what: $why"
        faults=$((faults + 1))
      fi
    done < <(grep -nE '^[[:space:]]*#[[:space:]]*include[[:space:]]*(<(talus|mpi|boost/mpi)|")' \
      "$header" || true)
    if [[ $from == world/step.hpp || $from == world/integrators/* ]]; then
      while IFS=: read -r line what; do
        echo "$header:$line: $what: features act by their hooks, at stages: no step names one"
        faults=$((faults + 1))
      done < <(grep -nE 'watches<|has_feature|world_state<.*>::(sleeps|drives|continuous|balances)' \
        "$header" || true)
    fi
  done < <(find "$tree/talus" -name '*.hpp' | sort)
  echo "$files headers, $faults faults"
  ((faults == 0 && files > 0))
}

# A tree with one fault of each kind: every one must be found, with file and line.
self_test() {
  local out
  tree=$(mktemp -d)  # global, for the trap
  trap 'rm -rf "$tree"' EXIT
  mkdir -p "$tree"/talus/{core,shape,geometry/detail,world,odd,parallel}
  cd "$tree/talus"
  echo '#include "talus/shape/b.hpp"' >core/a.hpp
  printf '\n#include "talus/core/a.hpp"\n#include "talus/geometry/g.hpp"\n' >shape/b.hpp
  echo '#include <talus/core/a.hpp>' >geometry/g.hpp
  printf '#include "talus/core/none.hpp"\n#include "g.hpp"\n' >geometry/detail/h.hpp
  printf '#include "talus/geometry/detail/h.hpp"\n# include <boost/mpi.hpp>\n' >world/w.hpp
  echo '#include <mpi.h>' >parallel/mpi.hpp
  printf '\n  if constexpr (watches<Scenario, energy_ledger>) book(s);\n' >world/step.hpp
  touch odd/o.hpp
  out=$(check "$tree") && { echo "a tree full of faults passed"; exit 1; }
  echo "$out"
  local place
  for place in core/a.hpp:1 shape/b.hpp:3 geometry/g.hpp:1 geometry/detail/h.hpp:1 \
    geometry/detail/h.hpp:2 world/w.hpp:1 world/w.hpp:2 world/step.hpp:2 odd/o.hpp:1 '8 headers, 9 faults'; do
    grep -q "$place" <<<"$out" || { echo "missed: $place"; exit 1; }
  done
}

if [[ ${1:?usage: layers.sh INCLUDE_DIR | --self-test} == --self-test ]]; then
  self_test
else
  check "$1"
fi
