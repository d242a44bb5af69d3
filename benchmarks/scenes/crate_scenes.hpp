#pragma once
// BOXPILE(N): as PILE with boxes of any orientation. A change of any number here invalidates
// earlier figures.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pile_scene.hpp"
#include "scene.hpp"

namespace bench {

/// Boxes with edges of 0.6 to 1 on a jittered cubic lattice of spacing 1.8, filled bottom-up.
inline scene boxpile_scene(std::size_t bodies, std::uint64_t seed = 1) {
  const double scale = 1.8 / 1.05;
  const std::size_t sites = pile_sites(bodies);
  scene s = pile_scene(bodies, seed);  // places and walls, to be scaled
  s.name = "boxpile";
  for (wall& w : s.walls) w.offset *= scale;
  for (std::size_t n = 0; n < bodies; ++n) {
    dice random(seed, n + (std::size_t{1} << 40));
    crate c;
    const auto jitter = random.between(vec{-0.02, -0.02, -0.02}, vec{0.02, 0.02, 0.02});
    const std::size_t at[3] = {n % sites, n / sites % sites, n / (sites * sites)};
    for (std::size_t k = 0; k < 3; ++k)
      c.centre[k] = std::fma(1.8, static_cast<double>(at[k]) + 0.5, jitter[k]);
    c.centre[2] += 0.1;  // no corner below the floor
    c.size = random.between(vec{0.6, 0.6, 0.6}, vec{1, 1, 1});
    // Uniform among all orientations: a point in the unit ball of four dimensions, by rejection.
    double norm = 0;
    while (norm < 0.01 || norm > 1) {
      norm = 0;
      for (double& q : c.orientation) q = random.between(-1, 1), norm += q * q;
    }
    for (double& q : c.orientation) q /= std::sqrt(norm);
    s.crates.push_back(c);
  }
  s.balls.clear();
  return s;
}

}  // namespace bench
