#pragma once
// How well the velocities and impulses of the last step satisfy the contact law.
#include "talus/step/last_residual.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Collective: the residual of the last step, regardless of later changes of bodies and
/// connections; of soft contacts that of the present state. It is also recorded in
/// world::convergence(), except of soft contacts with `residual_monitor`, which records that of the
/// step. Changes nothing else.
template <class Scenario>
contact_residual measure_residual(world<Scenario>& w) {
  w.require_all_ranks("measure_residual");
  return detail::last_residual(detail::state_of(w));
}

}  // namespace talus
