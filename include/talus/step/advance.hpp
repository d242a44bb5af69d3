#pragma once
// The end of a time step: the time advances.
#include "talus/state/state.hpp"

namespace talus::detail {

template <class Scenario>
void advance(world_state<Scenario>& s) {
  s.time = s.clock.after(s.time, s.steps, 1, s.dt);
  ++s.steps;
}

}  // namespace talus::detail
