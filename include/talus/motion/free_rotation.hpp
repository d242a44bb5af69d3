#pragma once
// Free rotation of a rigid body over a time step, of fourth order. A template of the scalar, so
// that only programs with rotating bodies compile it.
#include <algorithm>
#include <cmath>
#include <utility>

#include "talus/core/math.hpp"
#include "talus/core/portable_trigonometry.hpp"

namespace talus::detail {

/// Cosine and sine of half an angle, fast if it is small.
template <class Real>
struct half_angle {
  Real cosine, sine;

  explicit half_angle(Real angle) {
    const Real x = angle / 2, y = x * x;
    if (y < Real(0.01)) {  // Taylor's series, to the last bit
      cosine = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90))));
      sine = x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72))));
    } else {
      const auto both = portable::sincos(x);
      cosine = both.cosine, sine = both.sine;
    }
  }
};

/// The symmetric composition S6 of order 4 of Blanes and Moan 2002, table 2: parts of a time step
/// about the first axis and about the second in turns, and a[0] at last.
template <class Real>
struct fourth_order_composition {
  static constexpr Real a1 = 0.0792036964311957, a2 = 0.353172906049774, a3 = -0.0420650803577195,
                        a4 = 1 - 2 * (a1 + a2 + a3), b1 = 0.209515106613362,
                        b2 = -0.143851773179818, b3 = Real(0.5) - b1 - b2;
  static constexpr Real a[] = {a1, a2, a3, a4, a3, a2}, b[] = {b1, b2, b3, b3, b2, b1};
};
/// Up to this angle of a step, times the asymmetry of the body, second order is accurate enough.
template <class Real>
inline constexpr Real second_order_angle = 1e-4;
/// The largest angle of a part of a step with fourth order.
template <class Real>
inline constexpr Real fourth_order_angle = 0.15;
/// The parts into which a step of fourth order is divided; no time step is sensible beyond 64.
template <class Real>
[[nodiscard]] Real parts_of_step(Real angle) {
  return std::clamp(std::ceil(angle / fourth_order_angle<Real>), Real{1}, Real{64});
}

/// A free body with angular momentum m in its own frame and principal inverse moments p. Of the
/// kinetic energy, sum p_k m_k^2 / 2, the part p_mid |m|^2 / 2 rotates the body about its angular
/// momentum, which is fixed in the world, and commutes with all other parts; the rest are rotations
/// about the two other axes, at the rates (p_k - p_mid) m_k, each of which conserves m_k. If two
/// moments are equal only one of these remains, and the motion is exact.
template <class Real>
class free_body {
 public:
  free_body(const quaternion<Real>& q, const vector3<Real>& momentum, const vector3<Real>& p)
      : q_(q), m_(momentum), p_(p) {
    if (p_[low_] > p_[middle_]) std::swap(low_, middle_);
    if (p_[middle_] > p_[high_]) std::swap(middle_, high_);
    if (p_[low_] > p_[middle_]) std::swap(low_, middle_);
  }

  /// Angle per unit of time and of |m| that measures the deviation from an exact motion: the energy
  /// error of a symmetric composition of second order is some hundredths of its square.
  [[nodiscard]] Real asymmetry() const {
    return std::sqrt((p_[high_] - p_[middle_]) * (p_[middle_] - p_[low_]));
  }
  void second_order(Real dt) { about(low_, dt / 2), about(high_, dt), about(low_, dt / 2); }
  void fourth_order(Real dt) {
    using of = fourth_order_composition<Real>;
    for (int k = 0; k < 6; ++k) about(low_, of::a[k] * dt), about(high_, of::b[k] * dt);
    about(low_, of::a[0] * dt);
  }
  [[nodiscard]] const quaternion<Real>& orientation() const { return q_; }
  [[nodiscard]] Real middle() const { return p_[middle_]; }

 private:
  void about(int k, Real dt) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const half_angle<Real> h(dt * (p_[k] - p_[middle_]) * m_[k]);
    const Real c = h.cosine * h.cosine - h.sine * h.sine, s = 2 * h.cosine * h.sine;
    const Real mi = m_[i], mj = m_[j];
    m_[i] = c * mi + s * mj;
    m_[j] = c * mj - s * mi;
    auto& v = q_.coeffs();  // x, y, z, w
    const Real qk = v[k], qi = v[i], qj = v[j], w = v[3];
    v[k] = h.cosine * qk + h.sine * w;
    v[i] = h.cosine * qi + h.sine * qj;
    v[j] = h.cosine * qj - h.sine * qi;
    v[3] = h.cosine * w - h.sine * qk;
  }

  quaternion<Real> q_;
  vector3<Real> m_, p_;
  int low_ = 0, middle_ = 1, high_ = 2;
};

/// Free rotation of a body with principal moments `inertia` over `dt`: rotates `q` and returns the
/// new angular velocity (both in the world frame). The Hamiltonian is split (after Dullweber,
/// Leimkuhler, McLachlan 1997; see free_body) and composed symmetrically: the angular momentum in
/// the world is kept to round-off, the energy does not drift, and both errors are of fourth order
/// in dt. If the rotation is so slow, or the body so nearly symmetric, that the energy error of
/// second order is below 1e-9, second order is used; if it is fast the step is divided. The
/// criterion is the same in all steps of a free flight.
template <class Real>
[[nodiscard]] vector3<Real> rotate_freely(quaternion<Real>& q, const vector3<Real>& w,
                                          const vector3<Real>& inertia, Real dt) {
  using vector = vector3<Real>;
  const vector own = inertia.cwiseProduct(q.conjugate() * w), momentum = q * own;
  const Real length = momentum.norm();
  if (!(length > 0)) return w;

  const vector p = inertia.cwiseInverse();
  free_body<Real> body(q, own, p);
  const Real angle = length * dt * body.asymmetry();
  if (angle < second_order_angle<Real>) {
    body.second_order(dt);
  } else {
    const Real parts = parts_of_step(angle);
    for (int k = 0; k < static_cast<int>(parts); ++k) body.fourth_order(dt / parts);
  }
  const half_angle<Real> h(length * dt * body.middle());
  const vector axis = (h.sine / length) * momentum;
  q = (quaternion<Real>(h.cosine, axis[0], axis[1], axis[2]) * body.orientation()).normalized();
  return q * vector((q.conjugate() * momentum).cwiseProduct(p));
}

/// Free rotation as by rotate_freely(), over a time that may be negative.
template <class Real>
[[nodiscard]] vector3<Real> rotate_either_way(quaternion<Real>& q, const vector3<Real>& w,
                                              const vector3<Real>& inertia, Real dt) {
  if (dt >= 0) return rotate_freely(q, w, inertia, dt);
  return -rotate_freely(q, vector3<Real>(-w), inertia, -dt);
}

/// The rotation vector of a free body over `dt` for short times: its angular velocity in their
/// middle times `dt`. The angle is off by at most a sixth of the third power of |w| dt, since
/// |dw/dt| is at most |w|^2 and the second derivative twice |w|^3.
template <class Real>
[[nodiscard]] vector3<Real> turn_midway(const quaternion<Real>& q, const vector3<Real>& w,
                                        const vector3<Real>& inertia, Real dt) {
  using vector = vector3<Real>;
  const vector own = q.conjugate() * w, momentum = inertia.cwiseProduct(own);
  const vector change = momentum.cross(own).cwiseQuotient(inertia);  // Euler's equations
  return dt * (w + (dt / 2) * (q * change));
}

#ifdef TALUS_COMPILED
extern template vec3 rotate_freely(quat&, const vec3&, const vec3&, real);
#endif

}  // namespace talus::detail
