#pragma once
// What two materials make of a soft contact: stiffnesses and damping.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "talus/body/material.hpp"
#include "talus/body/pair_table.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/portable_trigonometry.hpp"

namespace talus::detail {

/// Properties of the soft contacts of a pair of materials. Lengths under the roots of Hertz' theory
/// are still to be put in: K = stiffness, or stiffness * a with the radius a = sqrt(R d) of the
/// circle of touch, of effective radius R and overlap d; likewise across the normal.
struct soft_pair {
  real stiffness = 0;   ///< linear: k; Hertz: 4/3 E*
  real tangential = 0;  ///< linear: 2/7 k; Mindlin: 8 G*
  real damping = 0;     ///< damping ratio of the normal spring, >= 0
  real friction = 0, dynamic_friction = 0, rolling_friction = 0;
};

/// What a restitution of 0 stands for. A force that never pulls comes near to 0 and never there.
inline constexpr real least_restitution = 0.005;

/// Restitution of a linear spring and dashpot of damping ratio z that never pulls: contact ends
/// when the force is zero, after the time 2 acos(z) / (w0 sqrt(1 - z^2)), with e = exp(-2 z acos(z)
/// / sqrt(1 - z^2)). (The closed form of Schwager, Poeschel 2007, "Coefficient of restitution and
/// linear-dashpot model revisited", with w0 = sqrt(k/m).) Overdamped, z > 1, acosh(z) and
/// sqrt(z^2 - 1) take their places; critical damping has exp(-2).
[[nodiscard]] inline real restitution_of_damping(real ratio) {
  const real square = 1 - ratio * ratio;
  if (std::abs(square) < real(1e-12)) return portable::exp(real(-2));
  const real angle = square > 0 ? portable::acos(ratio) : portable::acosh(ratio);
  return portable::exp(-2 * ratio * angle / std::sqrt(std::abs(square)));
}

/// The damping ratio of a coefficient of restitution; for 0 that of least_restitution. It serves
/// Hertz' spring as well if its dashpot is c d^(1/4): with y = d^(5/4) its motion becomes that of a
/// linear one, v dv/dy = -(4/5 k y + 4/5 c v) / m (after Antypov, Elliott 2011, "On an analytical
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
  p.friction = both.friction;
  p.dynamic_friction = both.dynamic_friction;
  p.rolling_friction = 0.5 * (a.rolling_friction + b.rolling_friction);
  return p;
}

/// The pairs of a table of materials, derived anew only where that has changed: of few materials
/// all pairs, of many those that meet.
template <class Law>
class soft_pairs {
  static constexpr std::size_t few = 64;

 public:
  void follow(const material_table& materials) {
    materials_ = &materials;
    if (revision_ == materials.revision()) return;
    revision_ = materials.revision();
    met_.clear();
    size_ = materials.size() <= few ? materials.size() : 0;
    pairs_.resize(size_ * size_);
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t j = 0; j < size_; ++j)
        pairs_[i * size_ + j] = derived(static_cast<material_id>(i), static_cast<material_id>(j));
  }
  /// Valid until the next call.
  [[nodiscard]] const soft_pair& pair(material_id a, material_id b) {
    if (size_ != 0)
      return pairs_[static_cast<std::size_t>(a) * size_ + static_cast<std::size_t>(b)];
    return of_many(a, b);
  }
  [[nodiscard]] std::size_t bytes() const {
    return pairs_.capacity() * sizeof(soft_pair) + met_.bytes();
  }

 private:
  [[nodiscard]] soft_pair derived(material_id a, material_id b) const {
    return soft_pair_of<Law>((*materials_)[a], (*materials_)[b], materials_->pair(a, b));
  }
  [[nodiscard, gnu::noinline]] const soft_pair& of_many(material_id a, material_id b) {
    const auto i = static_cast<std::uint32_t>(a), j = static_cast<std::uint32_t>(b);
    if (const soft_pair* known = met_.find(i, j)) return *known;
    met_.set(i, j, derived(std::min(a, b), std::max(a, b)));
    return *met_.find(i, j);
  }

  const material_table* materials_ = nullptr;
  plain_vector<soft_pair> pairs_;
  pair_table<soft_pair> met_;   ///< where there are more than a few materials
  std::size_t size_ = 0;        ///< of `pairs_`; 0 where there are more
  std::uint64_t revision_ = 0;  ///< of an empty table
};

}  // namespace talus::detail
