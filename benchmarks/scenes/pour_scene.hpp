#pragma once
// POUR(N, a, b): spheres of many sizes fall into a box, strike each other and settle. A change of
// any number here invalidates earlier figures.
#include <cmath>
#include <cstdint>
#include <numbers>

#include "scene.hpp"

namespace bench {

/// Radii from `smallest` to `largest`, uniform, or lognormal with a deviation of 1/2.
inline scene pour_scene(std::uint64_t bodies, double smallest, double largest, bool lognormal,
                        std::uint64_t seed) {
  scene s;
  s.name = "POUR";
  s.density = 2500;
  s.gravity = -9.81;
  s.dt = 1.0 / 240;
  s.between_balls = s.against_fixed = {.friction = 0.5, .restitution = 0.2};
  const double side = 2 * largest * std::cbrt(static_cast<double>(bodies) / 4);
  const double spacing = 2.02 * largest;
  s.walls = {
      {{0, 0, 1}, 0}, {{1, 0, 0}, 0}, {{-1, 0, 0}, -side}, {{0, 1, 0}, 0}, {{0, -1, 0}, -side}};
  const auto row = static_cast<std::uint64_t>(side / spacing);
  for (std::uint64_t k = 0; k < bodies; ++k) {
    dice random(seed, k);
    double radius = random.between(smallest, largest);
    if (lognormal) {
      do {
        const double normal = std::sqrt(-2 * std::log(1 - random.between(0, 1))) *
                              std::cos(2 * std::numbers::pi * random.between(0, 1));
        radius = std::sqrt(smallest * largest) * std::exp(0.5 * normal);
      } while (radius < smallest || radius > largest);
    }
    const auto at = [&](std::uint64_t i) { return spacing * (static_cast<double>(i) + 0.5); };
    s.balls.push_back({.position = {at(k % row), at(k / row % row), at(k / row / row)},
                       .radius = radius,
                       .velocity = {random.between(-0.5, 0.5), random.between(-0.5, 0.5), 0}});
  }
  return s;
}

}  // namespace bench
