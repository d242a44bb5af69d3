#pragma once
// Scenes of one body or a stack, each with an exact answer: HEAVY, PYRAMID, SPIN, INCLINE, ROLL and
// a bouncing ball. A change of any number here invalidates earlier figures.
#include <cmath>
#include <cstddef>
#include <numbers>

#include "scene.hpp"

namespace bench {

inline constexpr double gravity = 9.81;

/// An empty scene with a floor that falls by `angle` along +x.
inline scene floor_scene(const char* name, double friction, double angle = 0) {
  scene s;
  s.name = name;
  s.between_balls = s.against_fixed = {.friction = friction, .restitution = 0};
  s.gravity = -gravity;
  s.dt = 1.0 / 240;
  s.walls = {{{std::sin(angle), 0, std::cos(angle)}, 0}};
  return s;
}

/// Ten unit boxes stacked, the top one `ratio` times as dense as the others.
inline scene heavy_scene(double ratio) {
  scene s = floor_scene("heavy", 0.5);
  for (int k = 0; k < 10; ++k)
    s.crates.push_back({.centre = {0, 0, k + 0.5}, .density = k == 9 ? ratio : 1});
  return s;
}

/// Unit boxes, `base` in the lowest row, each of the others half upon two.
inline scene pyramid_scene(std::size_t base) {
  scene s = floor_scene("pyramid", 0.6);
  for (std::size_t row = 0; row < base; ++row)
    for (std::size_t i = 0; i + row < base; ++i)
      s.crates.push_back({.centre = {static_cast<double>(i) + 0.5 * static_cast<double>(row), 0,
                                     static_cast<double>(row) + 0.5}});
  return s;
}

/// A free box that spins about nearly its intermediate axis.
inline scene spin_scene() {
  scene s;
  s.name = "spin";
  s.dt = 1.0 / 240;
  s.crates = {{.centre = {0, 0, 0}, .size = {1, 2, 0.3}, .spin = {5, 5e-3, 0}}};
  return s;
}

/// A unit box on a plane of 30 degrees.
inline scene incline_scene(double friction) {
  const double angle = std::numbers::pi / 6;
  scene s = floor_scene("incline", friction, angle);
  s.crates = {{.centre = {0.5 * std::sin(angle), 0, 0.5 * std::cos(angle)},
               .orientation = {std::cos(angle / 2), 0, std::sin(angle / 2), 0}}};
  return s;
}

/// A sphere set down sliding.
inline scene roll_scene() {
  scene s = floor_scene("roll", 0.3);
  s.balls = {{.position = {0, 0, 0.5}, .radius = 0.5, .velocity = {5, 0, 0}}};
  return s;
}

/// A sphere dropped from height 1 above its resting place.
inline scene bounce_scene(double restitution) {
  scene s = floor_scene("bounce", 0);
  s.between_balls.restitution = s.against_fixed.restitution = restitution;
  s.balls = {{.position = {0, 0, 1.5}, .radius = 0.5}};
  return s;
}

/// Exact height of that sphere above its resting place.
inline double bounce_height(double t, double restitution) {
  double speed = std::sqrt(2 * gravity);  // at the first impact
  if (t < speed / gravity) return 1 - 0.5 * gravity * t * t;
  t -= speed / gravity;
  for (int k = 0; k < 1000; ++k) {
    speed *= restitution;
    const double flight = 2 * speed / gravity;
    if (t < flight) return speed * t - 0.5 * gravity * t * t;
    t -= flight;
  }
  return 0;
}

}  // namespace bench
