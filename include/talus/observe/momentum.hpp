#pragma once
// Momentum in against momentum out, and the support of the weight.
#include <array>
#include <cmath>

#include "talus/core/exact_sum.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The balance of linear momentum of the last step, all bodies that can move together.
struct momentum_account {
  vec3 before{0, 0, 0}, after{0, 0, 0};  ///< momentum of the bodies
  vec3 gravity{0, 0, 0};                 ///< given by gravity
  vec3 forces{0, 0, 0};                  ///< given by forces of the user
  vec3 ground{0, 0, 0};                  ///< given by contacts with global and fixed bodies
  vec3 damping{0, 0, 0};                 ///< change by damping (loss)
  double mass = 0;
  double size = 0;  ///< sum of the absolute momenta of the bodies

  /// The difference that the entries leave: only round-off, for any number of ranks.
  [[nodiscard]] vec3 closure() const {
    return after - before - gravity - forces - ground - damping;
  }
  /// |closure| over the impulse of the weight in the step; without gravity over `size`.
  [[nodiscard]] double error() const {
    const double scale = gravity.norm() > 0 ? gravity.norm() : size;
    return scale > 0 ? closure().norm() / scale : 0;
  }
  /// Load on global and fixed bodies, over the weight of all bodies that can move: 1 at rest. Needs
  /// gravity, else 0.
  [[nodiscard]] double borne_weight() const {
    const double square = gravity.squaredNorm();
    return square > 0 ? -ground.dot(gravity) / square : 0;
  }
};

/// Collective: sums the balance over all ranks. Needs features<momentum_balance>.
template <class Scenario>
[[nodiscard]] momentum_account measure_momentum(world<Scenario>& w) {
  momentum_account m;
  if constexpr (detail::require_feature<Scenario, momentum_balance>()) {
    w.require_all_ranks("measure_momentum");
    detail::momentum_record r = detail::view_of(w).monitors.momentum;
    detail::sum_exactly(w.link(), r.before, r.after, r.gravity, r.forces, r.ground, r.damping,
                        r.mass, r.size);
    m.before = r.before.value(), m.after = r.after.value(), m.gravity = r.gravity.value();
    m.forces = r.forces.value(), m.ground = r.ground.value(), m.damping = r.damping.value();
    m.mass = r.mass.value(), m.size = r.size.value();
  }
  return m;
}

}  // namespace talus
