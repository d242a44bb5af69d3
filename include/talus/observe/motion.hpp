#pragma once
// Sums over all bodies: number, mass, momentum, energy.
#include <array>
#include <cmath>

#include "talus/world/world.hpp"

namespace talus {

/// Motion of all bodies that are not global. Fixed bodies count, with no velocity.
struct motion {
  /// all of them, fixed ones included
  std::uint64_t bodies = 0;
  /// those that can move
  std::uint64_t movable = 0;
  std::uint64_t asleep = 0;     ///< of the movable ones; see world::sleeping
  double mass = 0;              ///< of the movable ones
  double kinetic_energy = 0;    ///< of translation and rotation
  double potential_energy = 0;  ///< -m g . x, with respect to the origin
  /// of the fastest centre of mass
  double max_speed = 0;
  /// linear, of all movable bodies
  vec3 momentum{0, 0, 0};
  vec3 angular_momentum{0, 0, 0};  ///< about the origin
};

/// Collective: sums over all ranks, in the order of the ranks.
template <class Scenario>
[[nodiscard, gnu::cold]] motion measure_motion(world<Scenario>& w) {
  w.require_all_ranks("measure_motion");
  constexpr bool sleeps = Scenario::template has_feature<sleeping>;
  std::array<double, sleeps ? 12 : 11> sums{};
  double fastest = 0;
  w.for_each_local([&](const auto& b) {
    sums[0] += 1;
    if (b.is_fixed()) return;
    const vec3 spin = b.angular_velocity(), inertia = b.inertia();
    vec3 spin_momentum = inertia[0] * spin;
    if constexpr (!std::remove_cvref_t<decltype(b)>::shape_type::isotropic) {
      const quat q = b.orientation();
      spin_momentum = q * vec3(inertia.cwiseProduct(q.conjugate() * spin));
    }
    const vec3 p = b.mass() * b.velocity();
    const vec3 l = b.position().cross(p) + spin_momentum;
    sums[1] += 1;
    if constexpr (sleeps) sums[11] += b.is_asleep();
    sums[2] += b.mass();
    sums[3] += 0.5 * (p.dot(b.velocity()) + spin_momentum.dot(spin));
    sums[4] -= b.mass() * w.gravity().dot(b.position());
    for (int k = 0; k < 3; ++k) sums[5 + k] += p[k], sums[8 + k] += l[k];
    fastest = std::max(fastest, b.velocity().norm());
  });
  w.link().reduce(reduction::sum, sums);
  w.link().reduce(reduction::max, std::span(&fastest, 1));
  motion m;
  m.bodies = static_cast<std::uint64_t>(sums[0]);
  m.movable = static_cast<std::uint64_t>(sums[1]);
  if constexpr (sleeps) m.asleep = static_cast<std::uint64_t>(sums[11]);
  m.mass = sums[2];
  m.kinetic_energy = sums[3];
  m.potential_energy = sums[4];
  m.max_speed = fastest;
  m.momentum = {sums[5], sums[6], sums[7]};
  m.angular_momentum = {sums[8], sums[9], sums[10]};
  return m;
}

}  // namespace talus
