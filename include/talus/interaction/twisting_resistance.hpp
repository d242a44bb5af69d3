#pragma once
// Twisting resistance of soft contacts.
#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

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

  /// The parameters of a pair of materials.
  template <class Number>
  struct parameters_of {
    /// Lever arm of the moment over the effective radius; 0.001 to 0.1.
    Number twisting_friction{};
    friend bool operator==(const parameters_of&, const parameters_of&) = default;
  };
  using parameters = parameters_of<real>;
  /// The memory of a contact from step to step.
  template <class Number>
  struct memory_of {
    Number turn{};  ///< elastic angle of twisting, of a relative to b about the normal

    /// The columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      f("twisting", m.turn);
    }
  };
  using memory = memory_of<real>;

  /// Throws invalid_argument for a coefficient without meaning.
  static void require_parameters(const parameters& p) {
    if (!(p.twisting_friction >= 0) || !std::isfinite(p.twisting_friction))
      detail::fail<std::invalid_argument>(
          "twisting_resistance has .twisting_friction = {}: give a finite number that is not "
          "negative, the lever arm over the effective radius",
          p.twisting_friction);
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline interaction_force_of<Number> force(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<bearing_of<Number>>& b,
      const std::type_identity_t<parameters_of<Number>>& p, real dt,
      std::type_identity_t<memory_of<Number>>& memory) {
    using namespace detail;
    using vector = vectors_of<Number>;
    interaction_force_of<Number> f;
    const auto twists_freely = p.twisting_friction == real(0);
    if (all_lanes(twists_freely)) return f;
    const Number arm = p.twisting_friction * c.radius, k = stiffness(c, b, p);
    const Number rate = dot(c.normal, c.spin), limit = arm * b.pressing;
    Number turn = memory.turn + dt * rate;
    const Number trial = turn;
    // For solid spheres the moment of inertia about the normal is 2/7 of that of rolling.
    const Number damping =
        2 * twisting_damping * square_root(Number(real(2.0 / 7) * c.rolling_inertia * k));
    const Number moment =
        smaller(larger(Number(-k * turn - damping * rate), Number(-limit)), limit);
    const auto back = turn < real(0);
    const Number most = limit / k;
    turn = choose(k * choose(back, Number(-turn), turn) > limit, choose(back, Number(-most), most),
                  turn);
    const vector zero = every_lane_of<Number>(0, 0, 0);
    memory.turn = choose(twists_freely, memory.turn, turn);
    f.moment = choose(twists_freely, zero, vector(moment * c.normal));
    f.lost = choose(twists_freely, Number{}, Number(k * turn * (trial - turn)));
    f.conserved_moment = choose(twists_freely, zero, vector(Number(-k * turn) * c.normal));
    return f;
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline Number stored(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<bearing_of<Number>>& b,
      const std::type_identity_t<parameters_of<Number>>& p,
      const std::type_identity_t<memory_of<Number>>& memory) {
    return real(0.5) * stiffness(c, b, p) * memory.turn * memory.turn;
  }

 private:
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline Number stiffness(
      const contact_kinematics_of<Number>& c, const bearing_of<Number>& b,
      const parameters_of<Number>& p) {
    const Number arm = p.twisting_friction * c.radius;
    return b.tangential * arm * arm;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus
