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

/// Spheres of radius 0.4 to 0.5 on a jittered cubic lattice of spacing 1.05, filled bottom-up: a
/// bed of `columns` by `rows` sites between walls.
inline scene bed_scene(std::size_t columns, std::size_t rows, std::size_t bodies,
                       std::uint64_t seed = 1) {
  const double wide = 1.05 * static_cast<double>(columns), deep = 1.05 * static_cast<double>(rows);
  scene s;
  s.name = "pile";
  s.between_balls = s.against_fixed = {.friction = 0.5, .restitution = 0};
  s.gravity = -9.81;
  s.dt = 1.0 / 240;
  s.walls = {
      {{0, 0, 1}, 0}, {{1, 0, 0}, 0}, {{-1, 0, 0}, -wide}, {{0, 1, 0}, 0}, {{0, -1, 0}, -deep}};
  s.balls.reserve(bodies);
  const auto site = [](std::size_t i, double first) {
    return std::fma(1.05, static_cast<double>(i), first);
  };
  for (std::size_t n = 0; n < bodies; ++n) {
    dice random(seed, n);
    ball b;
    b.radius = random.between(0.4, 0.5);
    b.position = random.between(vec{-0.02, -0.02, -0.02}, vec{0.02, 0.02, 0.02});
    b.position[0] += site(n % columns, 0.525);
    b.position[1] += site(n / columns % rows, 0.525);
    b.position[2] += site(n / (columns * rows), 0.6);
    s.balls.push_back(b);
  }
  return s;
}

/// The bed as wide as deep.
inline scene pile_scene(std::size_t bodies, std::uint64_t seed = 1) {
  const std::size_t sites = pile_sites(bodies);
  return bed_scene(sites, sites, bodies, seed);
}

/// `tiles` by `tiles` copies of a pile that may have settled, side by side in one box: every other
/// copy is mirrored, so that bodies at a wall touch their images there. Bodies come in the order of
/// the lattice of the whole bed.
inline scene tiled(const scene& pile, std::size_t tiles) {
  const std::size_t sites = pile_sites(pile.balls.size());
  const double side = pile_side(pile.balls.size());
  scene s = pile;
  s.balls.clear();
  s.balls.reserve(tiles * tiles * pile.balls.size());
  for (wall& w : s.walls)
    if (w.offset != 0) w.offset *= static_cast<double>(tiles);
  for (std::size_t first = 0; first < pile.balls.size(); first += sites * sites)
    for (std::size_t row = 0; row < tiles * sites; ++row)
      for (std::size_t column = 0; column < tiles * sites; ++column) {
        const std::size_t tile[] = {column / sites, row / sites};
        std::size_t at[] = {column % sites, row % sites};
        for (std::size_t k = 0; k < 2; ++k)
          if (tile[k] % 2 == 1) at[k] = sites - 1 - at[k];
        const std::size_t n = first + at[1] * sites + at[0];
        if (n >= pile.balls.size()) continue;
        ball b = pile.balls[n];
        for (std::size_t k = 0; k < 2; ++k) {
          const auto before = static_cast<double>(tile[k]);
          if (tile[k] % 2 == 1) {  // the spin is an axial vector
            b.position[k] = side - b.position[k], b.velocity[k] = -b.velocity[k];
            for (std::size_t c = 0; c < 3; ++c) b.spin[c] = c == k ? b.spin[c] : -b.spin[c];
          }
          b.position[k] += before * side;
        }
        s.balls.push_back(b);
      }
  return s;
}

/// The same pile in a vessel of spheres `ratio` times as large as its bodies: one instead of the
/// floor and one instead of each wall, each touching from outside the plane that it replaces. As
/// they are nearly plane, the bodies have as many contacts as between planes.
inline scene vessel_scene(std::size_t bodies, double ratio, std::uint64_t seed = 1) {
  scene s = pile_scene(bodies, seed);
  s.name = "vessel";
  const double radius = 0.45 * ratio, side = pile_side(bodies);
  const vec middle{0.5 * side, 0.5 * side, 0.4 * side};  // of the pile at rest, about
  for (const wall& w : s.walls) {
    double above = -w.offset;  // of the middle over the plane
    for (std::size_t k = 0; k < 3; ++k) above += w.normal[k] * middle[k];
    ball b{.position = middle, .radius = radius};
    for (std::size_t k = 0; k < 3; ++k) b.position[k] -= (above + radius) * w.normal[k];
    s.boulders.push_back(b);
  }
  s.walls.clear();
  return s;
}

}  // namespace bench
