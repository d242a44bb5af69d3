#pragma once
// Newton's law of impact in a time step.
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Separating velocity at the end of a step in which surfaces meet that approach at un < 0, by
/// Newton's law: -e u_n at the surface itself. The step places the impact above the surface, by up
/// to the gap; with an acceleration `fall` towards it, the correct velocity there leads to the same
/// height as the true impact: e^2 of the energy of the true one, minus the potential energy of the
/// gap. (Stored velocities are those of half a step before, as in free_flight.)
[[nodiscard]] inline real rebound(real e, real un, real gap, real dt, real fall) {
  if (!(fall > 0)) return -e * un;
  const real height = std::max(gap, real{0}), speed = fall * dt / 2 - un;
  const real lost = fall * height + fall * fall * dt * dt / 8;
  const real square = e * e * (speed * speed / 2 + fall * height) - lost;
  return square > 0 ? std::sqrt(fall * fall * dt * dt / 4 + 2 * square) - fall * dt / 2 : 0;
}

}  // namespace talus::detail
