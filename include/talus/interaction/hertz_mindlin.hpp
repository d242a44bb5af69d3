#pragma once
// Elastic spheres: Hertz along the normal, Mindlin's stiffness across it.
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/interaction/contact_kinematics.hpp"
#include "talus/interaction/normal_spring.hpp"

namespace talus {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Interaction law: elastic spheres (Hertz 1882), force with the power 3/2 of the overlap; across
/// it the stiffness of Mindlin (1949) at no slip; a dashpot that makes restitution independent of
/// speed (Tsuji, Tanaka, Ishida 1992). Ellipsoids and other shapes
/// with `bend(direction)` have the curvatures of the place where they touch; another shape that is
/// not a sphere counts as one of its volume.
struct hertz_mindlin final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "hertz_mindlin";
  static constexpr bool central = true;

  /// The parameters of a pair of materials. Multiplied by the radius sqrt(R d) of the circle of
  /// contact, with effective radius R and overlap d, they are stiffnesses.
  template <class Number>
  struct parameters_of {
    Number modulus{};     ///< 4/3 E*
    Number tangential{};  ///< 8 G*
    Number damping{};     ///< damping ratio, not negative
    friend bool operator==(const parameters_of&, const parameters_of&) = default;
  };
  using parameters = parameters_of<real>;
  template <class Number>
  using memory_of = no_memory;
  using memory = no_memory;

  /// Throws invalid_argument for a material without Young's modulus.
  static void require_material(const material& m) {
    if (!(m.youngs_modulus > 0))
      detail::fail<std::invalid_argument>(
          "a material of a scenario with hertz_mindlin needs a positive Young's modulus, but has "
          "{}: set .youngs_modulus",
          m.youngs_modulus);
  }
  /// The field that makes a material rigid, or null if it is not rigid.
  [[nodiscard]] static const char* rigid_by(const material& m) {
    return m.youngs_modulus == rigid ? ".youngs_modulus" : nullptr;
  }
  [[nodiscard]] static parameters combine(const material& a, const material& b,
                                          const pair_material& both) {
    const auto shear = [](const material& m) {
      return 2 * (2 - m.poisson_ratio) * (1 + m.poisson_ratio) / m.youngs_modulus;
    };
    const auto normal = [](const material& m) {
      return (1 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus;
    };
    return {4.0 / 3 / (normal(a) + normal(b)), 8 / (shear(a) + shear(b)),
            detail::damping_of_restitution(both.restitution)};
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline growing_bearing_of<Number> bears(
      const contact_kinematics_of<Number>& c,
      const std::type_identity_t<parameters_of<Number>>& p) {
    const Number radius = detail::square_root(Number(c.radius * -c.gap));
    return {{Number{}, p.modulus * radius, p.tangential * radius, p.damping}, radius, p.tangential};
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline bearing_force<growing_bearing_of<Number>> force(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<parameters_of<Number>>& p,
      real, memory&) {
    constexpr real critical = 2.2360679774997896964;  // sqrt(5), see damping_of_restitution()
    return detail::normal_force(c, bears(c, p), critical, p.damping);
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline stored_energy_of<Number> stored(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<parameters_of<Number>>& p,
      const memory&) {
    return {.normal = real(0.4) * bears(c, p).stiffness * c.gap * c.gap};
  }
  /// Rayleigh waves bound the step instead: see longest_step_of_body().
  [[nodiscard]] static real longest_step(const parameters&, real) {
    return std::numeric_limits<real>::infinity();
  }
  /// Time of a Rayleigh wave along a sphere: pi R sqrt(rho / G) / (0.1631 nu + 0.8766) (Thornton,
  /// Randall 1988).
  [[nodiscard]] static real longest_step_of_body(const material& m, real radius) {
    const real shear = m.youngs_modulus / (2 * (1 + m.poisson_ratio));
    return pi * radius * std::sqrt(m.density / shear) / (0.1631 * m.poisson_ratio + 0.8766);
  }
  /// 2.94 d / v with the largest overlap d = (15 m v^2 / (16 E* sqrt(R)))^(2/5) (Johnson, Contact
  /// Mechanics, 11.3), times the factor by which damping shortens a linear contact: a Hertz contact
  /// is shortened less, except for 0.5 % at a damping ratio of 0.1.
  [[nodiscard]] static real duration(const parameters& p, const head_on_impact& hit) {
    const real modulus = real(0.75) * p.modulus;
    const real deepest = portable::pow(
        15 * hit.mass * hit.speed * hit.speed / (16 * modulus * std::sqrt(hit.radius)), real(0.4));
    return real(2.9432655) * real(0.995) * detail::damped_duration(p.damping) * deepest / hit.speed;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus
