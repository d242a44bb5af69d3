#pragma once
// The end of a time step: the time advances.
#include "talus/state/state.hpp"

namespace talus::detail {

inline void advance(step_conditions& s) {
  s.time = s.clock.after(s.time, s.steps, 1, s.dt);
  ++s.steps;
}

}  // namespace talus::detail
