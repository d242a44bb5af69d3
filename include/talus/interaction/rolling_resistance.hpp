#pragma once
// Rolling resistance of soft contacts.
#include <cmath>
#include <stdexcept>

#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"
#include "talus/interaction/tangential_spring.hpp"

namespace talus {

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

  /// Of a pair of materials.
  struct parameters {
    real rolling_friction = 0;  ///< lever arm of the moment over the effective radius
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  /// The memory of a contact from step to step.
  struct memory {
    vec3 turn{0, 0, 0};  ///< elastic angle of rolling, of a relative to b

    /// The columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      f("rolling", m.turn);
    }
  };

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
  [[nodiscard, gnu::always_inline]] static inline interaction_force force(
      const contact_kinematics& c, const bearing& b, const parameters& p, real dt, memory& memory) {
    interaction_force f;
    if (p.rolling_friction == 0) return f;
    const real arm = p.rolling_friction * c.radius, k = stiffness(c, b, p);
    const vec3 rate = c.spin - c.normal.dot(c.spin) * c.normal;
    vec3 turn = detail::carried_along(memory.turn, c.normal, c.mean_spin * dt) + dt * rate;
    const vec3 trial = turn;
    const real limit = arm * b.pressing, bent = k * turn.norm();
    f.moment = -k * turn - (2 * rolling_damping * std::sqrt(c.rolling_inertia * k)) * rate;
    const real square = f.moment.squaredNorm();
    if (square > limit * limit) f.moment *= limit / std::sqrt(square);
    if (bent > limit) turn *= limit / bent;
    memory.turn = turn;
    f.lost = k * turn.dot(trial - turn);
    f.conserved_moment = -k * turn;
    return f;
  }
  [[nodiscard, gnu::always_inline]] static inline real stored(const contact_kinematics& c,
                                                              const bearing& b, const parameters& p,
                                                              const memory& memory) {
    return real(0.5) * stiffness(c, b, p) * memory.turn.squaredNorm();
  }

 private:
  [[nodiscard]] static real stiffness(const contact_kinematics& c, const bearing& b,
                                      const parameters& p) {
    const real arm = p.rolling_friction * c.radius;
    return 2.25 * b.stiffness * arm * arm;
  }
};

}  // namespace talus
