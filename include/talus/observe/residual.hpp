#pragma once
// How well the velocities and impulses of the last step satisfy the contact law.
#include "talus/step/last_residual.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Collective: the residual of the last step, regardless of later changes of bodies and
/// connections; it is also recorded in world::convergence(). Changes nothing else.
template <class Scenario>
contact_residual measure_residual(world<Scenario>& w) {
  w.require_all_ranks("measure_residual");
  return detail::last_residual(detail::state_of(w));
}

}  // namespace talus
