#pragma once
// From a symmetric second moment to principal axes. Templates of the scalar here and in the other
// headers of shape/detail: programs without polyhedra and unions do not compile them.
#include <cmath>

#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"

namespace talus::detail {

/// Axes (columns, right-handed) in which `m`, symmetric, is diagonal, by Jacobi's rotations.
/// Principal axes are kept to the bit; round-off beside the diagonal counts as zero.
template <class Real>
[[nodiscard]] matrix3<Real> principal_axes(matrix3<Real> m, Real round_off = Real(1e-13)) {
  matrix3<Real> axes = matrix3<Real>::Identity();
  const Real zero = round_off * (m(0, 0) + (m(1, 1) + m(2, 2)));
  for (int sweep = 0; sweep < 50; ++sweep) {
    bool diagonal = true;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (!(std::abs(m(p, q)) > zero)) continue;
        diagonal = false;
        const Real theta = (m(q, q) - m(p, p)) / (2 * m(p, q));
        const Real t = (theta < 0 ? -1 : 1) / (std::abs(theta) + portable::hypot(theta, Real(1)));
        const Real c = 1 / portable::hypot(t, Real(1)), s = t * c;
        matrix3<Real> turn = matrix3<Real>::Identity();
        turn(p, p) = turn(q, q) = c;
        turn(p, q) = s, turn(q, p) = -s;
        m = turn.transpose() * m * turn;
        axes = axes * turn;
      }
    if (diagonal) break;
  }
  return axes;
}

/// Where a body is, and how it resists turning.
template <class Real>
struct principal_frame {
  pose frame;             ///< centre of mass, principal axes
  vector3<Real> inertia;  ///< moments per unit mass
};

/// The rotation to the axes in which `m`, symmetric, is diagonal.
template <class Real>
[[nodiscard]] quaternion<Real> principal_rotation(const matrix3<Real>& m,
                                                  Real round_off = Real(1e-13)) {
  quaternion<Real> q(principal_axes<Real>(m, round_off));
  q.normalize();
  if (q.w() < 0) q = {-q.w(), -q.x(), -q.y(), -q.z()};
  return q;
}
/// The diagonal of `m` along the axes of a rotation.
template <class Real>
[[nodiscard]] vector3<Real> diagonal_along(const quaternion<Real>& q, const matrix3<Real>& m) {
  const matrix3<Real> turned = q.toRotationMatrix();
  vector3<Real> along;
  for (int i = 0; i < 3; ++i) along[i] = turned.col(i).dot(m * turned.col(i));
  return along;
}
/// The principal axes and moments of a tensor of inertia.
template <class Real>
[[nodiscard]] principal_frame<Real> principal_inertia(const vector3<Real>& centre,
                                                      const matrix3<Real>& tensor) {
  const quaternion<Real> q = principal_rotation(tensor);
  return {{centre, q}, diagonal_along(q, tensor)};
}

/// Mass with its first and second moments about a fixed point.
template <class Real>
struct mass_moments {
  Real mass = 0;
  vector3<Real> first = vector3<Real>::Zero();
  matrix3<Real> second = matrix3<Real>::Zero();  ///< integral of x x^T

  mass_moments& operator+=(const mass_moments& other) {
    mass += other.mass, first += other.first, second += other.second;
    return *this;
  }
  [[nodiscard]] principal_frame<Real> reduce(Real round_off = Real(1e-13)) const {
    const vector3<Real> centre = first / mass;
    const matrix3<Real> spread = second / mass - outer(centre, centre);
    const quaternion<Real> q = principal_rotation(spread, round_off);
    const vector3<Real> along = diagonal_along(q, spread);
    return {{centre, q}, {along[1] + along[2], along[2] + along[0], along[0] + along[1]}};
  }
};

}  // namespace talus::detail
