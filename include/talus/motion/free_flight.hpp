#pragma once
// The path of a body in a step without contacts.
#include <cmath>

#include "talus/core/math.hpp"
#include "talus/motion/free_rotation.hpp"
#include "talus/motion/integrate.hpp"

namespace talus::detail {

/// A parabola through the positions of semi-implicit Euler: x + (v + a dt/2) t + a t^2/2 coincides
/// with it after any number of steps of constant acceleration, so that a velocity of that scheme is
/// the true one half a step before. A body with an orientation rotates freely.
template <bool Turns>
struct free_flight {
  vec3 position{0, 0, 0};
  vec3 velocity{0, 0, 0};  ///< at time 0, the true one
  vec3 acceleration{0, 0, 0};
  quat orientation{1, 0, 0, 0};  ///< at time `turned`
  real turned = 0;
  vec3 spin{0, 0, 0};     ///< angular velocity
  vec3 inertia{1, 1, 1};  ///< principal moments, to a factor
  real later = 1;         ///< the part of the spin that is left after the time `turned`
  real coarse = 0;        ///< error of the angle that at() may have beside that of rotate_freely()

  [[nodiscard]] vec3 place(real t) const {
    return position + t * velocity + (real(0.5) * t * t) * acceleration;
  }
  [[nodiscard]] vec3 speed(real t) const { return velocity + t * acceleration; }
  /// The time in which it turns, with its spin, from `orientation` to that at time t.
  [[nodiscard]] real turning_until(real t) const {
    const real lasts = t - turned;
    return lasts > 0 ? later * lasts : lasts;
  }
  [[nodiscard]] pose at(real t) const {
    pose p{place(t), orientation};
    if constexpr (Turns) {
      const real square = spin.squaredNorm(), lasts = turning_until(t);
      if (square == 0 || lasts == 0) return p;
      if (const real angle = std::sqrt(square) * std::abs(lasts);
          angle * angle * angle <= 6 * coarse)
        p.orientation = detail::turned(orientation, turn_midway(orientation, spin, inertia, lasts));
      else
        (void)rotate_either_way(p.orientation, spin, inertia, lasts);
    }
    return p;
  }
  /// The body at rest at its position at time t.
  [[nodiscard]] free_flight stopped(real t) const {
    const pose p = at(t);
    free_flight f;
    f.position = p.position;
    f.orientation = p.orientation;
    return f;
  }
};

}  // namespace talus::detail
