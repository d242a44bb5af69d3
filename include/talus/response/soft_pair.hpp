#pragma once
// What two materials make of a soft contact: stiffnesses and damping.
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Properties of the soft contacts of a pair of materials. Lengths under the roots of Hertz' theory
/// are still to be put in: K = stiffness, or stiffness * a with the radius a = sqrt(R d) of the
/// circle of touch, of effective radius R and overlap d; likewise across the normal.
struct soft_pair {
  real stiffness = 0;   ///< linear: k; Hertz: 4/3 E*
  real tangential = 0;  ///< linear: 2/7 k; Mindlin: 8 G*
  real damping = 0;     ///< damping ratio of the normal spring, in [0, 1]
  real tension = 0;     ///< share of the dashpot's pull that acts, in [0, 1]; 0: never pulls
  real friction = 0, dynamic_friction = 0, rolling_friction = 0;
};

/// The least restitution of a spring and dashpot that never pulls and is not overdamped: exp(-2).
inline constexpr real least_repulsive_restitution = 0.13533528323661269189;

/// Restitution of a linear spring and dashpot of damping ratio z that never pulls: contact ends
/// when the force is zero, after the time 2 acos(z) / (w0 sqrt(1 - z^2)), with e = exp(-2 z acos(z)
/// / sqrt(1 - z^2)). (The closed form of Schwager, Poeschel 2007, "Coefficient of restitution and
/// linear-dashpot model revisited", with w0 = sqrt(k/m).) Least value, at critical damping:
/// exp(-2).
[[nodiscard]] inline real restitution_of_damping(real ratio) {
  if (ratio >= 1) return least_repulsive_restitution;
  return std::exp(-2 * ratio * std::acos(ratio) / std::sqrt(1 - ratio * ratio));
}

/// The root of a function that falls from low to high.
template <class F>
[[nodiscard]] real root_of_falling(real low, real high, F&& f) {
  for (int k = 0; k < 60; ++k) {
    const real middle = (low + high) / 2;
    (f(middle) > 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// The damping ratio of a coefficient of restitution; 1, critical damping, for all e under exp(-2).
/// It serves Hertz' spring as well if its dashpot is c d^(1/4): with y = d^(5/4) its motion becomes
/// that of a linear one, v dv/dy = -(4/5 k y + 4/5 c v) / m (after Antypov, Elliott 2011, "On an
/// analytical solution for the damped Hertzian spring"), of damping ratio c / sqrt(5 k m).
[[nodiscard]] inline real damping_of_restitution(real e) {
  if (e >= 1) return 0;
  if (e <= least_repulsive_restitution) return 1;
  return root_of_falling(0, 1, [&](real z) { return restitution_of_damping(z) - e; });
}

/// The share t of the dashpot's pull that gives a coefficient of restitution under exp(-2) at
/// critical damping; 0 for all others. The force is zero at the overlap 2 v exp(-2) / w0 and the
/// speed v exp(-2). From there it is t times that of the spring and dashpot, until the overlap is
/// zero: with t = sin^2(phi/2) the linear equation of motion gives e = exp(-2 - phi tan(phi/2)).
/// A restitution of 0 takes the whole pull, t = 1. The substitution of damping_of_restitution()
/// carries it over to Hertz' spring.
[[nodiscard]] inline real tension_of_restitution(real e) {
  if (e >= least_repulsive_restitution) return 0;
  if (e <= 0) return 1;
  const real half = root_of_falling(
      0, pi / 2, [&](real phi) { return std::exp(-2 - 2 * phi * std::tan(phi)) - e; });
  return std::sin(half) * std::sin(half);
}

/// Springs in series; `k` is that of two equal bodies, and may be `rigid` for one of the two.
[[nodiscard]] inline real series_stiffness(real a, real b) {
  if (std::isinf(a)) return 2 * b;
  if (std::isinf(b)) return 2 * a;
  return 2 * a * b / (a + b);
}

/// Whether bodies of a material do not yield at all in contacts of this law.
template <class Law>
[[nodiscard]] bool is_rigid(const material& m) {
  return (Law::hertz ? m.youngs_modulus : m.stiffness) == rigid;
}

/// Throws invalid_argument for a body that moves and does not yield: two of them would push each
/// other with forces without bound.
template <class Law, class Shape>
void require_yielding(const material& m) {
  if (is_rigid<Law>(m))
    fail<std::invalid_argument>(
        "a {} that moves cannot be of a rigid material: give that material a finite {}, or add "
        "the body in world.global(...) or with .fixed = true",
        Shape::name, Law::hertz ? ".youngs_modulus" : ".stiffness");
}

/// Throws invalid_argument if a material lacks what the springs need.
template <class Law>
void require_springs(const material& m) {
  if constexpr (Law::hertz) {
    if (!(m.youngs_modulus > 0))
      fail<std::invalid_argument>(
          "a material of a scenario with hertz_mindlin needs a positive Young's modulus, but has "
          "{}: set .youngs_modulus",
          m.youngs_modulus);
  } else {
    if (!(m.stiffness > 0))
      fail<std::invalid_argument>(
          "a material of a scenario with linear_spring_dashpot needs a positive stiffness, but has "
          "{}: set .stiffness",
          m.stiffness);
  }
}

template <class Law>
[[nodiscard]] soft_pair soft_pair_of(const material& a, const material& b,
                                     const pair_material& both) {
  soft_pair p;
  if constexpr (Law::hertz) {
    const auto shear = [](const material& m) {
      return 2 * (2 - m.poisson_ratio) * (1 + m.poisson_ratio) / m.youngs_modulus;
    };
    const auto normal = [](const material& m) {
      return (1 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus;
    };
    p.stiffness = 4.0 / 3 / (normal(a) + normal(b));
    p.tangential = 8 / (shear(a) + shear(b));
  } else {
    p.stiffness = series_stiffness(a.stiffness, b.stiffness);
    p.tangential = 2.0 / 7 * p.stiffness;  // the period of the normal spring, for solid spheres
  }
  p.damping = damping_of_restitution(both.restitution);
  p.tension = tension_of_restitution(both.restitution);
  p.friction = both.friction;
  p.dynamic_friction = both.dynamic_friction;
  p.rolling_friction = 0.5 * (a.rolling_friction + b.rolling_friction);
  return p;
}

/// The pairs of a table of materials, derived anew only where that has changed.
template <class Law>
class soft_pairs {
 public:
  void follow(const material_table& materials) {
    if (revision_ == materials.revision()) return;
    revision_ = materials.revision();
    size_ = materials.size();
    pairs_.resize(size_ * size_);
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t j = 0; j < size_; ++j) {
        const auto a = static_cast<material_id>(i), b = static_cast<material_id>(j);
        pairs_[i * size_ + j] = soft_pair_of<Law>(materials[a], materials[b], materials.pair(a, b));
      }
  }
  [[nodiscard]] const soft_pair& pair(material_id a, material_id b) const {
    return pairs_[static_cast<std::size_t>(a) * size_ + static_cast<std::size_t>(b)];
  }
  [[nodiscard]] std::size_t bytes() const { return pairs_.capacity() * sizeof(soft_pair); }

 private:
  plain_vector<soft_pair> pairs_;
  std::size_t size_ = 0;
  std::uint64_t revision_ = 0;  ///< of an empty table
};

}  // namespace talus::detail
