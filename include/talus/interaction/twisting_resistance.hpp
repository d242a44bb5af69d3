#pragma once
// Twisting resistance of soft contacts.
#include <cmath>
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus {

/// Resistance: a moment against twisting, the relative rotation about the normal, from a spring of
/// rotation of stiffness k_t (mu_t R)^2 that yields at mu_t R |f_n|, with the stiffness k_t of
/// friction (torsion of Luding 2008, "Cohesive, frictional powders", section 2.7, with a lever arm
/// mu_t R; `twisting sds` of LAMMPS).
struct twisting_resistance final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "twisting_resistance";
  static constexpr bool exerts_force = false;
  /// The damping of the spring as a fraction of critical damping, as of rolling_resistance.
  static constexpr real twisting_damping = 0.3;

  /// Of a pair of materials.
  struct parameters {
    /// Lever arm of the moment over the effective radius; 0.001 to 0.1.
    real twisting_friction = 0;
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  /// The memory of a contact from step to step.
  struct memory {
    real turn = 0;  ///< elastic angle of twisting, of a relative to b about the normal

    /// The columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      f("twisting", m.turn);
    }
  };

  /// Throws invalid_argument for a coefficient without meaning.
  static void require_parameters(const parameters& p) {
    if (!(p.twisting_friction >= 0) || !std::isfinite(p.twisting_friction))
      detail::fail<std::invalid_argument>(
          "twisting_resistance has .twisting_friction = {}: give a finite number that is not "
          "negative, the lever arm over the effective radius",
          p.twisting_friction);
  }
  [[nodiscard, gnu::always_inline]] static inline interaction_force force(
      const contact_kinematics& c, const bearing& b, const parameters& p, real dt, memory& memory) {
    interaction_force f;
    if (p.twisting_friction == 0) return f;
    const real arm = p.twisting_friction * c.radius, k = stiffness(c, b, p);
    const real rate = c.normal.dot(c.spin), limit = arm * b.pressing;
    real turn = memory.turn + dt * rate;
    const real trial = turn;
    // Of solid spheres the moment of inertia about the normal is 2/7 of that of rolling.
    const real damping = 2 * twisting_damping * std::sqrt(real(2.0 / 7) * c.rolling_inertia * k);
    const real moment = std::fmin(limit, std::fmax(-limit, -k * turn - damping * rate));
    if (k * std::abs(turn) > limit) turn = std::copysign(limit / k, turn);
    memory.turn = turn;
    f.moment = moment * c.normal;
    f.lost = k * turn * (trial - turn);
    f.conserved_moment = (-k * turn) * c.normal;
    return f;
  }
  [[nodiscard, gnu::always_inline]] static inline real stored(const contact_kinematics& c,
                                                              const bearing& b, const parameters& p,
                                                              const memory& memory) {
    return real(0.5) * stiffness(c, b, p) * memory.turn * memory.turn;
  }

 private:
  [[nodiscard]] static real stiffness(const contact_kinematics& c, const bearing& b,
                                      const parameters& p) {
    const real arm = p.twisting_friction * c.radius;
    return b.tangential * arm * arm;
  }
};

}  // namespace talus
