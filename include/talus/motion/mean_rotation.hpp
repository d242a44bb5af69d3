#pragma once
// Rotation of a rigid body by the mean of its angular velocities at both ends of a step, which
// conserves energy and angular momentum (Simo and Wong 1991).
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"

namespace talus::detail {

/// The orientation after dt of a body with the orientation `q`, principal moments `inertia`, and
/// the angular momenta `before` and `after` in the world. The body rotates by Cayley's map of the
/// mean of its angular velocities in its own frame. `angular_velocity` receives the one at the end.
[[nodiscard]] inline quat rotated_by_mean(const quat& q, const vec3& inertia, const vec3& before,
                                          const vec3& after, real dt, vec3& angular_velocity) {
  const vec3 inverse = inertia.cwiseInverse();
  const vec3 first = (q.conjugate() * before).cwiseProduct(inverse);
  vec3 last = (q.conjugate() * after).cwiseProduct(inverse), mean = real(0.5) * (first + last);
  quat end = q;
  constexpr int most = 60;
  for (int k = 0; k < most; ++k) {
    const vec3 half = (real(0.5) * dt) * mean;  // tan of half of the angle
    end = (q * quat(1, half[0], half[1], half[2])).normalized();
    last = (end.conjugate() * after).cwiseProduct(inverse);
    const vec3 next = real(0.5) * (first + last);
    const real change = (next - mean).norm();
    mean = next;
    if (!(change > real(4e-16) * mean.norm())) break;
  }
  angular_velocity = end * last;
  return end;
}

}  // namespace talus::detail
