#pragma once
// The stages of a step of integrator<moreau_midpoint>: contacts are found and solved half way.
#include "talus/world/integrators/semi_implicit_euler.hpp"
#include "talus/world/midpoint.hpp"
#include "talus/world/midpoint_state.hpp"
#include "talus/world/stage_clock.hpp"
#include "talus/world/state.hpp"

namespace talus {

template <class Scenario>
struct moreau_midpoint::state {
  detail::midpoint_state<detail::filter_types<typename Scenario::shapes, detail::is_finite>::size>
      midpoints;
};

template <class Scenario>
void moreau_midpoint::step(detail::world_state<Scenario>& s) {
  timed(s, s.seconds.integrate, [&] { drift_to_midpoint(s); });
  step_with_contacts(s);
}

}  // namespace talus
