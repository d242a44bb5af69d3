#pragma once
// The stages of a step of integrator<moreau_midpoint>: contacts are found and solved half way.
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"
#include "talus/step/act_on_bodies.hpp"
#include "talus/step/integrators/semi_implicit_euler.hpp"
#include "talus/step/joint_positions.hpp"
#include "talus/step/midpoint.hpp"
#include "talus/step/midpoint_state.hpp"

namespace talus {

template <class Scenario>
struct moreau_midpoint::state {
  detail::midpoint_state<detail::filter_types<typename Scenario::shapes, detail::is_finite>::size>
      midpoints;
};

template <class Scenario>
void moreau_midpoint::step(detail::world_state<Scenario>& s) {
  timed(s, s.seconds.integrate, [&] {
    if constexpr (detail::world_state<Scenario>::has_joints) detail::note_jointed(s);
    drift_to_midpoint(s);
  });
  act_on_bodies(s, s.time + s.dt / 2);
  step_with_contacts(s);
}

}  // namespace talus
