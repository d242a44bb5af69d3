#pragma once
// Semi-implicit Euler: velocities from forces, then positions from the new velocities. Templates of
// the scalar, so that only programs with rotating bodies compile them.
#include "talus/core/math.hpp"
#include "talus/motion/free_rotation.hpp"

namespace talus::detail {

/// Inverse of the inertia tensor in the world frame, from the principal inverse moments.
template <class Real>
[[nodiscard]] matrix3<Real> inverse_tensor(const quaternion<Real>& q,
                                           const vector3<Real>& inverse_moments) {
  const matrix3<Real> rotation = q.toRotationMatrix();
  return rotation * diagonal_matrix(inverse_moments) * rotation.transpose();
}

/// `q` rotated by the rotation vector `angle` (radians), given in the world frame.
template <class Real>
[[nodiscard]] quaternion<Real> turned(const quaternion<Real>& q, const vector3<Real>& angle) {
  const Real length = angle.norm();
  if (length == 0) return q;
  const half_angle<Real> h(length);
  const vector3<Real> axis = (h.sine / length) * angle;
  return (quaternion<Real>(h.cosine, axis[0], axis[1], axis[2]) * q).normalized();
}

}  // namespace talus::detail
