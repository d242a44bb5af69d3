#pragma once
// PILE(N): a dense frictional pile of spheres in an open box of five planes. A change of any number
// here invalidates earlier figures.
#include <cstddef>
#include <cstdint>

#include "scene.hpp"

namespace bench {

/// Lattice sites along an edge: the smallest k with k^3 >= bodies (in integers: cbrt may round up).
constexpr std::size_t pile_sites(std::size_t bodies) {
  std::size_t k = 1;
  while (k * k * k < bodies) ++k;
  return k;
}

/// Inner side L of the square container.
constexpr double pile_side(std::size_t bodies) {
  return 1.05 * static_cast<double>(pile_sites(bodies));
}

/// Spheres of radius 0.4 to 0.5 on a jittered cubic lattice of spacing 1.05, filled bottom-up.
inline scene pile_scene(std::size_t bodies, std::uint64_t seed = 1) {
  const std::size_t sites = pile_sites(bodies);
  const double side = pile_side(bodies);
  scene s;
  s.name = "pile";
  s.between_balls = s.against_fixed = {.friction = 0.5, .restitution = 0};
  s.gravity = -9.81;
  s.dt = 1.0 / 240;
  s.walls = {
      {{0, 0, 1}, 0}, {{1, 0, 0}, 0}, {{-1, 0, 0}, -side}, {{0, 1, 0}, 0}, {{0, -1, 0}, -side}};
  s.balls.reserve(bodies);
  const auto site = [](std::size_t i, double first) {
    return std::fma(1.05, static_cast<double>(i), first);
  };
  for (std::size_t n = 0; n < bodies; ++n) {
    dice random(seed, n);
    ball b;
    b.radius = random.between(0.4, 0.5);
    b.position = random.between(vec{-0.02, -0.02, -0.02}, vec{0.02, 0.02, 0.02});
    b.position[0] += site(n % sites, 0.525);
    b.position[1] += site(n / sites % sites, 0.525);
    b.position[2] += site(n / (sites * sites), 0.6);
    s.balls.push_back(b);
  }
  return s;
}

}  // namespace bench
