#pragma once
// BOXPILE(N): a pile of boxes that fall, turned at random, into an open box of five planes. A
// change of any number here invalidates earlier figures.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "pile_scene.hpp"
#include "scene.hpp"

namespace bench {

/// PILE's lattice of 1.05 is as wide here as boxes of any orientation need.
inline constexpr double box_pile_scale = 1.8 / 1.05;

/// Inner side of the square container.
constexpr double box_pile_side(std::size_t bodies) { return box_pile_scale * pile_side(bodies); }

/// Edges uniform in [0.6, 1.0], orientations uniform.
inline scene box_pile_scene(std::size_t bodies, std::uint64_t seed = 1) {
  const std::size_t sites = pile_sites(bodies);
  const double side = box_pile_side(bodies);
  scene s;
  s.name = "boxpile";
  s.between_balls = s.against_fixed = {.friction = 0.5, .restitution = 0};
  s.gravity = -9.81;
  s.dt = 1.0 / 240;
  s.walls = {
      {{0, 0, 1}, 0}, {{1, 0, 0}, 0}, {{-1, 0, 0}, -side}, {{0, 1, 0}, 0}, {{0, -1, 0}, -side}};
  s.crates.reserve(bodies);
  const auto site = [](std::size_t i, double first) {
    return box_pile_scale * std::fma(1.05, static_cast<double>(i), first);
  };
  const double shake = 0.02 * box_pile_scale;
  for (std::size_t n = 0; n < bodies; ++n) {
    dice random(seed, n);
    crate c;
    c.size = random.between(vec{0.6, 0.6, 0.6}, vec{1, 1, 1});
    c.centre = random.between(vec{-shake, -shake, -shake}, vec{shake, shake, shake});
    c.centre[0] += site(n % sites, 0.525);
    c.centre[1] += site(n / sites % sites, 0.525);
    c.centre[2] += site(n / (sites * sites), 0.6);
    // Shoemake 1992: uniform over all rotations.
    const double u = random.between(0, 1), a = random.between(0, 2 * std::numbers::pi),
                 b = random.between(0, 2 * std::numbers::pi);
    c.orientation = {std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
                     std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b)};
    s.crates.push_back(c);
  }
  return s;
}

/// As long as the highest box falls, and two seconds.
inline std::size_t box_pile_settling(const scene& s) {
  double top = 0;
  for (const crate& c : s.crates) top = std::max(top, c.centre[2]);
  return static_cast<std::size_t>(std::ceil((std::sqrt(2 * top / -s.gravity) + 2) / s.dt));
}

}  // namespace bench
