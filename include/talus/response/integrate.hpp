#pragma once
// Semi-implicit Euler: velocities from forces, then positions from the new velocities. Templates of
// the scalar, so that only programs with bodies that turn compile them.
#include "talus/core/math.hpp"

namespace talus::detail {

/// Inverse of the inertia tensor in the world frame, from the principal inverse moments.
template <class Real>
[[nodiscard]] matrix3<Real> inverse_tensor(const quaternion<Real>& q,
                                           const vector3<Real>& inverse_moments) {
  const matrix3<Real> rotation = q.toRotationMatrix();
  return rotation * inverse_moments.asDiagonal() * rotation.transpose();
}

/// `q` turned by the rotation vector `angle` (radians), given in the world frame.
template <class Real>
[[nodiscard]] quaternion<Real> turned(const quaternion<Real>& q, const vector3<Real>& angle) {
  const Real length = angle.norm();
  if (length == 0) return q;
  return (quaternion<Real>(Eigen::AngleAxis<Real>(length, angle / length)) * q).normalized();
}

/// Free rotation of a body with principal moments `inertia` over `dt`: turns `q` and returns the
/// new angular velocity. The Hamiltonian is split into rotations about the three principal axes,
/// composed symmetrically (Dullweber, Leimkuhler, McLachlan 1997, eq. 2.6): second order, the
/// angular momentum in the world frame is kept to round-off and the energy does not drift.
template <class Real>
[[nodiscard]] vector3<Real> rotate_freely(quaternion<Real>& q, const vector3<Real>& w,
                                          const vector3<Real>& inertia, Real dt) {
  using vector = vector3<Real>;
  const vector momentum = q * vector(inertia.cwiseProduct(q.conjugate() * w));
  const auto about = [&](int axis, Real step) {
    const Real spin = (q.conjugate() * momentum)[axis] / inertia[axis];
    q = q * quaternion<Real>(Eigen::AngleAxis<Real>(spin * step, vector::Unit(axis)));
  };
  about(0, dt / 2), about(1, dt / 2), about(2, dt), about(1, dt / 2), about(0, dt / 2);
  q.normalize();
  return q * vector((q.conjugate() * momentum).cwiseQuotient(inertia));
}

}  // namespace talus::detail
