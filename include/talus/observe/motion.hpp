#pragma once
// Sums over all bodies: number, mass, momentum, energy.
#include <array>
#include <cmath>

#include "talus/core/exact_sum.hpp"
#include "talus/parallel/exact_reduction.hpp"
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
  /// The speed of the fastest centre of mass
  double max_speed = 0;
  /// The linear momentum of all movable bodies
  vec3 momentum{0, 0, 0};
  vec3 angular_momentum{0, 0, 0};  ///< about the origin
};

/// Collective: sums over all ranks, exactly: bodies in the same state give the same bits on any
/// ranks.
template <class Scenario>
[[nodiscard, gnu::cold]] motion measure_motion(world<Scenario>& w) {
  w.require_all_ranks("measure_motion");
  std::array<std::uint64_t, 3> counts{};      // bodies, movable, asleep
  std::array<detail::signed_sum, 3> sums;     // mass, kinetic, potential energy
  std::array<detail::vector_sum, 2> momenta;  // linear, angular
  double fastest = 0;
  w.for_each_local([&](const auto& b) {
    ++counts[0];
    if (b.is_fixed()) return;
    const vec3 spin = b.angular_velocity(), inertia = b.inertia();
    vec3 spin_momentum = inertia[0] * spin;
    if constexpr (!std::remove_cvref_t<decltype(b)>::shape_type::isotropic) {
      const quat q = b.orientation();
      spin_momentum = q * vec3(inertia.cwiseProduct(q.conjugate() * spin));
    }
    const vec3 p = b.mass() * b.velocity();
    ++counts[1];
    if constexpr (Scenario::template has_feature<sleeping>) counts[2] += b.is_asleep();
    sums[0] += b.mass();
    sums[1] += 0.5 * (p.dot(b.velocity()) + spin_momentum.dot(spin));
    sums[2] -= b.mass() * w.gravity().dot(b.position());
    momenta[0] += p, momenta[1] += vec3(b.position().cross(p) + spin_momentum);
    fastest = std::max(fastest, b.velocity().norm());
  });
  w.link().reduce(reduction::sum, std::span<std::uint64_t>(counts));
  detail::sum_exactly(w.link(), sums, momenta);
  w.link().reduce(reduction::max, std::span(&fastest, 1));
  motion m;
  m.bodies = counts[0], m.movable = counts[1];
  if constexpr (Scenario::template has_feature<sleeping>) m.asleep = counts[2];
  m.mass = sums[0].value();
  m.kinetic_energy = sums[1].value();
  m.potential_energy = sums[2].value();
  m.max_speed = fastest;
  m.momentum = momenta[0].value();
  m.angular_momentum = momenta[1].value();
  return m;
}

}  // namespace talus
