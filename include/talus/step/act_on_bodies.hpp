#pragma once
// Functions of the user that exert forces on bodies in each step.
#include "talus/core/math.hpp"
#include "talus/state/function_times.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Calls them for the present positions, which are those of that time.
template <class Scenario>
void act_on_bodies(world_state<Scenario>& s, real time) {
  for (const auto& one : s.acting) {
    const function_clock clock(s, one.number);
    one.f(time);
  }
}

}  // namespace talus::detail
