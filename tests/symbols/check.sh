#!/usr/bin/env bash
# Code that a scenario does not name is not in its program: checks the functions of program.cpp.
#   check.sh NM SPHERES_OBJECT BOXES_OBJECT SOFT_OBJECT
# Patterns that mark boxes and monitors must be missing from the first object and present in the second,
# otherwise the test would prove nothing.
set -euo pipefail
functions() { "$1" -C "$2" | grep -E ' [tTwW] '; }
spheres=$(functions "$1" "$2")
boxes=$(functions "$1" "$3")
soft=$(functions "$1" "$4")
failed=0

absent() {
  if grep -m 3 -E "$1" <<<"$spheres"; then
    echo "a serial world of spheres has functions that match '$1'"
    failed=1
  fi
}
for pattern in 'talus::box\b' 'box_(pair|axes|manifold)' 'general_contact' \
  'inverse_tensor' 'rotate_freely' 'toRotationMatrix' '::conjugate' \
  '(energy|momentum|overlap)_record' '(book|open|close)_(response|contacts|motion|energy|momentum)' \
  'each_moving_local'; do
  absent "$pattern"
  if ! grep -qE "$pattern" <<<"$boxes"; then
    echo "a world of boxes has no function that matches '$pattern': correct this test"
    failed=1
  fi
done
for pattern in 'talus::plane\b' '(\b|[^y]_)orientation\b' 'turned' 'MPI_' 'boost::mpi' 'talus::threads' \
  'thread_team' 'std::thread' 'pthread_create' 'talus::domain<' 'grid_cells::owner' 'detail::migrate<' \
  'share_shadow_copies' 'share_velocities' 'connection_checker' 'talus::(capsule|cylinder)\b' \
  'polyhedron' 'union_of' 'convex_' '\bshared_(memory|data)' 'may_touch|note_filters|pair_body|contact_filters'; do
  absent "$pattern"
done

# Hard and soft contacts share no code.
only_in() {  # only_in HAS LACKS PATTERN
  local has=$1 lacks=$2 pattern=$3
  if ! grep -qE "$pattern" <<<"${!has}"; then
    echo "the world of $has has no function that matches '$pattern': correct this test"
    failed=1
  fi
  if grep -m 3 -E "$pattern" <<<"${!lacks}"; then
    echo "the world of $lacks has functions that match '$pattern'"
    failed=1
  fi
}
for pattern in 'nonlinear_gauss_seidel' 'detail::contact_list<' 'isotropic_contact<' 'contact_maker<' \
  'gather_velocities' 'conditions_of' 'solver_state'; do
  only_in spheres soft "$pattern"
done
for pattern in 'force_adder' 'tangential_spring' 'pair_parameters' 'measure_forces' 'gather_motion' \
  '::kick<'; do
  only_in soft spheres "$pattern"
done
exit $failed
