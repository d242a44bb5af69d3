#pragma once
// Further sweeps in steps without loads.
#include "talus/constraint/impact_stage.hpp"

namespace talus::detail {

/// Without loads all impulses are impacts, and what sweeps leave over is energy that is lost: more
/// of them, sweep(k) for k = 0, 1, ..., until velocities on all ranks are exact to round-off. After
/// further strikes, no bodies overlap that the last of them has driven together.
template <class State, class Ranks, class Sweep>
void finish_impacts(State& s, const Ranks& ranks, impact_stage stage, Sweep&& sweep) {
  const int most_sweeps = stage == impact_stage::release ? 400 : 40;
  s.stage = stage;
  auto before = s.bodies;
  for (int k = 0; k < most_sweeps; ++k) {
    sweep(k);
    if (!ranks.changed_since(before)) return;
    before = s.bodies;
  }
}

}  // namespace talus::detail
