#pragma once
// The linear spring-dashpot law (Cundall, Strack 1979).
#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"
#include "talus/interaction/normal_spring.hpp"

namespace talus {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Interaction law: force proportional to the overlap, and a dashpot that makes two spheres rebound
/// with the coefficient of restitution of their materials at any speed (Schwager, Poeschel 2007); 0
/// stands for 0.005. The force never pulls.
struct linear_spring_dashpot final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "linear_spring_dashpot";
  static constexpr bool central = true;

  /// The parameters of a pair of materials.
  template <class Number>
  struct parameters_of {
    Number stiffness{};   ///< force per overlap, along the normal
    Number tangential{};  ///< force per displacement, across it
    Number damping{};     ///< damping ratio, not negative
    friend bool operator==(const parameters_of&, const parameters_of&) = default;
  };
  using parameters = parameters_of<real>;
  template <class Number>
  using memory_of = no_memory;
  using memory = no_memory;

  /// Throws invalid_argument for a material without a stiffness.
  static void require_material(const material& m) {
    if (!(m.stiffness > 0))
      detail::fail<std::invalid_argument>(
          "a material of a scenario with linear_spring_dashpot needs a positive stiffness, but has "
          "{}: set .stiffness",
          m.stiffness);
  }
  /// The field that makes a material rigid, or null if it is not rigid.
  [[nodiscard]] static const char* rigid_by(const material& m) {
    return m.stiffness == rigid ? ".stiffness" : nullptr;
  }
  /// Springs in series, equal periods of the tangential and the normal spring (for solid spheres),
  /// and the damping of the restitution.
  [[nodiscard]] static parameters combine(const material& a, const material& b,
                                          const pair_material& both) {
    const real k = in_series(a.stiffness, b.stiffness);
    return {k, 2.0 / 7 * k, detail::damping_of_restitution(both.restitution)};
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline bearing_of<Number> bears(
      const contact_kinematics_of<Number>&, const std::type_identity_t<parameters_of<Number>>& p) {
    return {Number{}, p.stiffness, p.tangential, p.damping};
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline bearing_force<bearing_of<Number>> force(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<parameters_of<Number>>& p,
      real, memory&) {
    return detail::normal_force(c, bears(c, p), 2, p.damping);
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline stored_energy_of<Number> stored(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<parameters_of<Number>>& p,
      const memory&) {
    return {.normal = real(0.5) * p.stiffness * c.gap * c.gap};
  }
  [[nodiscard]] static real longest_step(const parameters& p, real mass, real stiffer = 1) {
    return detail::longest_step_of_spring(p.stiffness, mass, p.damping, stiffer);
  }
  /// The time from the first touch until the force is zero.
  [[nodiscard]] static real duration(const parameters& p, const head_on_impact& hit) {
    return pi * detail::damped_duration(p.damping) * std::sqrt(hit.mass / p.stiffness);
  }

 private:
  /// Each is that of two equal bodies; one of the two may be `rigid`.
  [[nodiscard]] static real in_series(real a, real b) {
    if (std::isinf(a)) return 2 * b;
    if (std::isinf(b)) return 2 * a;
    return 2 * a * b / (a + b);
  }
};

#pragma GCC diagnostic pop

}  // namespace talus
