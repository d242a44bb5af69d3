#pragma once
// Semi-implicit Euler: velocities from forces, then positions from the new velocities.
#include "talus/core/math.hpp"

namespace talus::detail {

/// Inverse of the inertia tensor in the world frame, from the principal inverse moments.
[[nodiscard]] inline mat3 inverse_tensor(const quat& q, const vec3& inverse_moments) {
  const mat3 rotation = q.toRotationMatrix();
  return rotation * inverse_moments.asDiagonal() * rotation.transpose();
}

/// `q` turned by the rotation vector `angle` (radians), given in the world frame.
[[nodiscard]] inline quat turned(const quat& q, const vec3& angle) {
  const real length = angle.norm();
  if (length == 0) return q;
  return (quat(Eigen::AngleAxis<real>(length, angle / length)) * q).normalized();
}

/// Free rotation of a body with principal moments `inertia` over `dt`: turns `q` and returns the
/// new angular velocity. The Hamiltonian is split into rotations about the three principal axes,
/// composed symmetrically (Dullweber, Leimkuhler, McLachlan 1997, eq. 2.6): second order, the
/// angular momentum in the world frame is kept to round-off and the energy does not drift.
[[nodiscard]] inline vec3 rotate_freely(quat& q, const vec3& w, const vec3& inertia, real dt) {
  const vec3 momentum = q * vec3(inertia.cwiseProduct(q.conjugate() * w));
  const auto about = [&](int axis, real step) {
    const real spin = (q.conjugate() * momentum)[axis] / inertia[axis];
    q = q * quat(Eigen::AngleAxis<real>(spin * step, vec3::Unit(axis)));
  };
  about(0, dt / 2), about(1, dt / 2), about(2, dt), about(1, dt / 2), about(0, dt / 2);
  q.normalize();
  return q * vec3((q.conjugate() * momentum).cwiseQuotient(inertia));
}

}  // namespace talus::detail
