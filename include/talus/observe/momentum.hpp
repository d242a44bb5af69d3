#pragma once
// Momentum in against momentum out, and the support of the weight.
#include <array>
#include <cmath>

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
    const auto& r = detail::view_of(w).monitors.momentum;
    std::array<double, 20> sums{};
    const auto parts = std::array{r.before.value(), r.after.value(),  r.gravity.value(),
                                  r.forces.value(), r.ground.value(), r.damping.value()};
    for (std::size_t n = 0; n < parts.size(); ++n)
      for (std::size_t k = 0; k < 3; ++k) sums[3 * n + k] = parts[n][static_cast<int>(k)];
    sums[18] = r.mass, sums[19] = r.size;
    w.link().reduce(reduction::sum, sums);
    const auto part = [&](std::size_t n) {
      return vec3(sums[3 * n], sums[3 * n + 1], sums[3 * n + 2]);
    };
    m.before = part(0), m.after = part(1), m.gravity = part(2);
    m.forces = part(3), m.ground = part(4), m.damping = part(5);
    m.mass = sums[18], m.size = sums[19];
  }
  return m;
}

}  // namespace talus
