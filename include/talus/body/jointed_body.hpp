#pragma once
// What a joint sees of a body that it joins, and what it does to it.
#include "talus/core/math.hpp"

namespace talus {

/// An impulse and an angular impulse about the centre of mass of a body.
struct wrench {
  vec3 impulse{0, 0, 0};  ///< mass times velocity
  vec3 moment{0, 0, 0};   ///< moment of inertia times angular velocity
};

namespace detail {

/// The state of a jointed body before a step.
struct jointed_body {
  pose at;                 ///< in periodic space the image next to the other body
  vec3 spin{0, 0, 0};      ///< angular velocity
  vec3 velocity{0, 0, 0};  ///< of the centre of mass
};

/// The work of a wrench on a body with this velocity and angular velocity.
[[nodiscard]] inline real work_of(const wrench& x, const vec3& v, const vec3& w) {
  return x.impulse.dot(v) + x.moment.dot(w);
}

}  // namespace detail
}  // namespace talus
