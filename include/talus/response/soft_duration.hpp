#pragma once
// How long soft contacts last, and the time steps that they allow.
#include <algorithm>
#include <cmath>
#include <limits>

#include "talus/body/material.hpp"
#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/response/soft_pair.hpp"

namespace talus::detail {

/// Longest stable step for two bodies of this mass: 2 (sqrt(1 + z^2) - z) / w with w^2 = 2 k / m
/// and the damping ratio z, from the amplification of the semi-implicit Euler method with the
/// dashpot's force at the beginning of the step; without damping also that of Verlet.
[[nodiscard]] inline real longest_step_of_spring(real stiffness, real mass, real ratio) {
  const real z = std::min(real{1}, ratio);  // the step itself bounds what is beyond
  return 2 * (std::sqrt(1 + z * z) - z) / std::sqrt(2 * stiffness / mass);
}

/// Time that a Rayleigh wave takes along a sphere: pi R sqrt(rho / G) / (0.1631 nu + 0.8766)
/// (Thornton, Randall 1988).
[[nodiscard]] inline real rayleigh_time(real radius, const material& m) {
  const real shear = m.youngs_modulus / (2 * (1 + m.poisson_ratio));
  return pi * radius * std::sqrt(m.density / shear) / (0.1631 * m.poisson_ratio + 0.8766);
}

/// Two bodies that meet head on: of reduced mass, effective radius, and relative speed.
struct soft_impact {
  real mass = 0, radius = 0, speed = 0;
};

/// The time from the first touch until the force is zero. Linear: 2 acos(z) / (w0 sqrt(1 - z^2)),
/// or 2 acosh(z) / (w0 sqrt(z^2 - 1)) where it is overdamped.
/// Hertz: 2.94 d / v with the largest overlap d = (15 m v^2 / (16 E* sqrt(R)))^(2/5) (Johnson,
/// Contact Mechanics, 11.3), and times the part by which damping shortens a linear contact: Hertz'
/// is shortened less, but for 0.5 % at a damping ratio of 0.1.
template <class Law>
[[nodiscard]] real contact_duration(const soft_pair& pair, const soft_impact& hit) {
  const real z = pair.damping;
  const real square = 1 - z * z;
  const real angle = square > 0 ? portable::acos(z) : portable::acosh(std::max(real{1}, z));
  const real part =
      std::abs(square) < real(1e-12) ? 2 / pi : 2 * angle / std::sqrt(std::abs(square)) / pi;
  if constexpr (Law::hertz) {
    const real modulus = real(0.75) * pair.stiffness;
    const real deepest = portable::pow(
        15 * hit.mass * hit.speed * hit.speed / (16 * modulus * std::sqrt(hit.radius)), real(0.4));
    return real(2.9432655) * real(0.995) * part * deepest / hit.speed;
  } else {
    return pi * part * std::sqrt(hit.mass / pair.stiffness);
  }
}

/// Steps that a contact takes at least at a fifth of the critical time step.
inline constexpr real steps_of_contact = 20;
/// Some more, so that one more or less at the ends of a contact leaves as many.
inline constexpr real steps_in_critical = (steps_of_contact + 1) / 5;

/// Whether an impact is one of its own: faster than what gravity makes of a contact while it
/// lasts, as it does where bodies come to rest on each other.
[[nodiscard]] inline bool is_impact(real speed, real duration, real gravity) {
  return speed > gravity * duration;
}

}  // namespace talus::detail
