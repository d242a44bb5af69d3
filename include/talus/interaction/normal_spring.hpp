#pragma once
// Springs and dashpots along the normal: the damping for a coefficient of restitution, springs in
// series, and the duration of an impact.
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus::detail {

/// The restitution used for 0. A force that never pulls approaches 0 but does not reach it.
inline constexpr real least_restitution = 0.005;

/// Restitution of a linear spring and dashpot of damping ratio z that never pulls: contact ends
/// when the force is zero, after the time 2 acos(z) / (w0 sqrt(1 - z^2)), with e = exp(-2 z acos(z)
/// / sqrt(1 - z^2)). (The closed form of Schwager, Poeschel 2007, "Coefficient of restitution and
/// linear-dashpot model revisited", with w0 = sqrt(k/m).) If overdamped, z > 1, acosh(z) and
/// sqrt(z^2 - 1) replace these; critical damping has exp(-2).
[[nodiscard]] inline real restitution_of_damping(real ratio) {
  const real square = 1 - ratio * ratio;
  if (std::abs(square) < real(1e-12)) return portable::exp(real(-2));
  const real angle = square > 0 ? portable::acos(ratio) : portable::acosh(ratio);
  return portable::exp(-2 * ratio * angle / std::sqrt(std::abs(square)));
}

/// The damping ratio for a coefficient of restitution; for 0 that of least_restitution. It is also
/// valid for Hertz' spring if its dashpot is c d^(1/4): with y = d^(5/4) its motion becomes that of
/// a linear one, v dv/dy = -(4/5 k y + 4/5 c v) / m (after Antypov, Elliott 2011, "On an analytical
/// solution for the damped Hertzian spring"), of damping ratio c / sqrt(5 k m).
[[nodiscard]] inline real damping_of_restitution(real e) {
  if (e >= 1) return 0;
  if (!(e > 0)) e = least_restitution;
  real low = 0, high = 1;
  while (restitution_of_damping(high) > e && high < real(1e9)) low = high, high *= 2;
  for (int k = 0; k < 60; ++k) {
    const real middle = (low + high) / 2;
    (restitution_of_damping(middle) > e ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// The largest part of the approach that an overdamped dashpot removes in a step: a step that does
/// not resolve it stays stable. (At a fifth of the critical time step it is resolved.)
inline constexpr real most_damping = 0.5;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Spring and dashpot along the normal; the sum never pulls. `critical` is the dashpot's constant
/// over sqrt(m K) at critical damping.
template <class Number, class Bearing>
[[nodiscard, gnu::always_inline]] inline bearing_force<Bearing> normal_force(
    const contact_kinematics_of<Number>& c, const Bearing& b, real critical, const Number& ratio) {
  Number damping = critical * ratio * square_root(Number(c.mass * b.stiffness));
  if (c.step > 0 && any_lane(ratio > real(1)))
    damping =
        choose(ratio > real(1), smaller(Number(most_damping * c.mass / c.step), damping), damping);
  bearing_force<Bearing> f;
  static_cast<Bearing&>(f) = b;
  const Number spring = b.stiffness * -c.gap;
  f.pressing = larger(Number(spring - damping * dot(c.normal, c.velocity)), Number{});
  f.force = f.pressing * c.normal;
  f.conserved = spring * c.normal;
  return f;
}

#pragma GCC diagnostic pop

/// Duration of a contact of this damping ratio over half a period of the undamped spring: 2 acos(z)
/// / (pi sqrt(1 - z^2)), or 2 acosh(z) / (pi sqrt(z^2 - 1)) if it is overdamped.
[[nodiscard]] inline real damped_duration(real ratio) {
  const real square = 1 - ratio * ratio;
  const real angle = square > 0 ? portable::acos(ratio) : portable::acosh(std::max(real{1}, ratio));
  return std::abs(square) < real(1e-12) ? 2 / pi : 2 * angle / std::sqrt(std::abs(square)) / pi;
}

/// Longest stable step for two bodies of this mass: 2 (sqrt(1 + z^2) - z) / w with w^2 = 2 k / m
/// and the damping ratio z, from the amplification of the semi-implicit Euler method with the
/// dashpot's force at the beginning of the step; without damping also that of Verlet. Several such
/// contacts make bodies `stiffer` by this factor, in which both k and the dashpot grow.
[[nodiscard]] inline real longest_step_of_spring(real stiffness, real mass, real ratio,
                                                 real stiffer) {
  const real z = std::sqrt(stiffer) * std::min(real{1}, ratio);  // a step limits larger values
  return 2 / ((std::sqrt(1 + z * z) + z) * std::sqrt(2 * stiffer * stiffness / mass));
}

}  // namespace talus::detail
