#pragma once
// GAS(N): a dilute gas of hard spheres, so that nearly all the work is finding out who meets whom.
// A change of any number here invalidates earlier figures.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pile_scene.hpp"
#include "scene.hpp"

namespace bench {

/// Spheres of radius 0.4 to 0.5 on a jittered cubic lattice of spacing 3, which is 1.4 % of the
/// volume, in a cube; no friction, no gravity, nothing lost in a collision. A mean body moves a
/// tenth of its radius in a step.
inline scene gas_scene(std::size_t bodies, std::uint64_t seed = 1) {
  const std::size_t sites = pile_sites(bodies);
  const double spacing = 3, side = spacing * static_cast<double>(sites);
  scene s;
  s.name = "gas";
  s.between_balls = s.against_fixed = {.friction = 0, .restitution = 1};
  s.dt = 1.0 / 240;
  s.walls = {{{0, 0, 1}, 0},      {{0, 0, -1}, -side}, {{1, 0, 0}, 0},
             {{-1, 0, 0}, -side}, {{0, 1, 0}, 0},      {{0, -1, 0}, -side}};
  for (std::size_t n = 0; n < bodies; ++n) {
    dice random(seed, n);
    ball b;
    b.radius = random.between(0.4, 0.5);
    b.position = random.between(vec{-0.5, -0.5, -0.5}, vec{0.5, 0.5, 0.5});
    const std::size_t at[3] = {n % sites, n / sites % sites, n / (sites * sites)};
    for (std::size_t k = 0; k < 3; ++k)
      b.position[k] += spacing * (static_cast<double>(at[k]) + 0.5);
    b.velocity = random.between(vec{-12, -12, -12}, vec{12, 12, 12});
    s.balls.push_back(b);
  }
  return s;
}

}  // namespace bench
