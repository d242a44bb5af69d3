#pragma once
// WELL: spheres falling into a ring of fixed bricks, the main scenario of the pe tutorial (section
// 5 there), without damping as comparisons ask. A change here invalidates earlier figures.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "scene.hpp"

namespace bench {

inline constexpr double well_radius = 30;  ///< R, inner radius of the ring
inline constexpr int well_bricks = 40;     ///< B, bricks of a level
inline constexpr int well_levels = 5;      ///< H

/// Edge lengths of a brick: as long as the chord of its share of the circle, half as deep.
inline vec well_brick() {
  const double angle = 2 * std::numbers::pi / well_bricks;
  const double x = std::sqrt(2 * well_radius * well_radius * (1 - std::cos(angle)));
  return {x, 0.5 * x, 0.4 * x};
}

/// Spheres of radius 0.6 to 1.2 on a lattice of 2.4 within 0.9 R, from three heights of the well
/// up. Pair coefficients are geometric means of spheres (friction 0.25, restitution 0.2) and
/// granite (0.1, 0.5), which every engine here can be given exactly.
inline scene well_scene(std::size_t bodies = 3000, std::uint64_t seed = 1) {
  scene s;
  s.name = "well";
  s.between_balls = {.friction = 0.25, .restitution = 0.2};
  s.against_fixed = {.friction = std::sqrt(0.25 * 0.1), .restitution = std::sqrt(0.2 * 0.5)};
  s.gravity = -2;
  s.dt = 0.005;
  s.walls = {{{0, 0, 1}, 0}};

  const vec brick = well_brick();
  const double turn = 2 * std::numbers::pi / well_bricks;
  const double reach = well_radius + 0.5 * brick[1];
  for (int level = 0; level < well_levels; ++level) {
    for (int i = 0; i < well_bricks; ++i) {
      const double angle = turn * (i + (level % 2 == 0 ? 0.5 : 1.0));
      s.blocks.push_back(
          {.centre = {-reach * std::sin(angle), reach * std::cos(angle), (level + 0.5) * brick[2]},
           .size = brick,
           .orientation = {std::cos(0.5 * angle), 0, 0, std::sin(0.5 * angle)}});
    }
  }

  const double spacing = 2.4;
  const int sites = static_cast<int>(std::ceil(1.8 * well_radius / spacing));
  const auto at = [&](int i) { return spacing * (i - 0.5 * (sites - 1)); };
  const double bottom = 3 * brick[2] * well_levels;
  for (int k = 0; s.balls.size() < bodies; ++k) {
    for (int j = 0; j < sites; ++j) {
      for (int i = 0; i < sites && s.balls.size() < bodies; ++i) {
        if (at(i) * at(i) + at(j) * at(j) > 0.81 * well_radius * well_radius) continue;
        dice random(seed, s.balls.size());
        ball b;
        b.position = {at(i), at(j), std::fma(spacing, k, bottom)};
        b.radius = random.between(0.6, 1.2);
        b.velocity = random.between(vec{-1, -1, -0.2}, vec{1, 1, 0.2});
        b.spin = random.between(vec{-0.1, -0.1, -0.1}, vec{0.1, 0.1, 0.1});
        s.balls.push_back(b);
      }
    }
  }
  return s;
}

}  // namespace bench
