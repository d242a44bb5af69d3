#pragma once
// Rolling resistance of soft contacts.
#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"
#include "talus/interaction/tangential_spring.hpp"

namespace talus {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Resistance: a moment against rolling (not twisting), from an elastic spring of rotation of
/// stiffness 2.25 K (mu_r R)^2 that yields at mu_r R |f_n| (elastic-plastic spring-dashpot, model C
/// of Ai, Chen, Rotter, Ooi 2011; there the dashpot is not limited until the spring yields, here
/// spring and dashpot yield together).
struct rolling_resistance final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "rolling_resistance";
  static constexpr bool exerts_force = false;
  /// The damping of the spring as a fraction of critical damping (Ai et al. 2011 use 0.3).
  static constexpr real rolling_damping = 0.3;

  /// The parameters of a pair of materials.
  template <class Number>
  struct parameters_of {
    Number rolling_friction{};  ///< lever arm of the moment over the effective radius
    friend bool operator==(const parameters_of&, const parameters_of&) = default;
  };
  using parameters = parameters_of<real>;
  /// The memory of a contact from step to step.
  template <class Number>
  struct memory_of {
    /// Elastic angle of rolling, of a relative to b.
    detail::vectors_of<Number> turn = detail::every_lane_of<Number>(0, 0, 0);

    /// The columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      f("rolling", m.turn);
    }
  };
  using memory = memory_of<real>;

  /// Throws invalid_argument for a coefficient without meaning.
  static void require_parameters(const parameters& p) {
    if (!(p.rolling_friction >= 0) || !std::isfinite(p.rolling_friction))
      detail::fail<std::invalid_argument>(
          "rolling_resistance has .rolling_friction = {}: give a finite number that is not "
          "negative, the lever arm over the effective radius",
          p.rolling_friction);
  }
  /// The mean of both.
  [[nodiscard]] static parameters combine(const material& a, const material& b,
                                          const pair_material&) {
    return {0.5 * (a.rolling_friction + b.rolling_friction)};
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline interaction_force_of<Number> force(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<bearing_of<Number>>& b,
      const std::type_identity_t<parameters_of<Number>>& p, real dt,
      std::type_identity_t<memory_of<Number>>& memory) {
    using namespace detail;
    using vector = vectors_of<Number>;
    interaction_force_of<Number> f;
    const auto rolls_freely = p.rolling_friction == real(0);
    if (all_lanes(rolls_freely)) return f;
    const Number arm = p.rolling_friction * c.radius, k = stiffness(c, b, p);
    const vector rate = c.spin - dot(c.normal, c.spin) * c.normal;
    vector turn = carried_along(memory.turn, c.normal, c.mean_spin * dt);
    turn += every_lane<Number>(dt) * rate;
    const vector trial = turn;
    const Number limit = arm * b.pressing, bent = k * square_root(dot(turn, turn));
    vector moment =
        -k * turn - Number(2 * rolling_damping * square_root(Number(c.rolling_inertia * k))) * rate;
    const Number square = dot(moment, moment);
    moment = choose(square > limit * limit, vector(Number(limit / square_root(square)) * moment),
                    moment);
    turn = choose(bent > limit, vector(Number(limit / bent) * turn), turn);
    const vector zero = every_lane_of<Number>(0, 0, 0);
    memory.turn = choose(rolls_freely, memory.turn, turn);
    f.moment = choose(rolls_freely, zero, moment);
    f.lost = choose(rolls_freely, Number{}, Number(k * dot(turn, vector(trial - turn))));
    f.conserved_moment = choose(rolls_freely, zero, vector(-k * turn));
    return f;
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline Number stored(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<bearing_of<Number>>& b,
      const std::type_identity_t<parameters_of<Number>>& p,
      const std::type_identity_t<memory_of<Number>>& memory) {
    return real(0.5) * stiffness(c, b, p) * detail::dot(memory.turn, memory.turn);
  }

 private:
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline Number stiffness(
      const contact_kinematics_of<Number>& c, const bearing_of<Number>& b,
      const parameters_of<Number>& p) {
    const Number arm = p.rolling_friction * c.radius;
    return real(2.25) * b.stiffness * arm * arm;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus
