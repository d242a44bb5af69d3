#pragma once
// The one judge of every engine: gaps in closed form from final positions alone, found with a cell
// list of its own. Nothing an engine reports about its contacts enters.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "scene.hpp"

namespace bench {

/// What a ball of a loaded pair pushes against.
enum class partner { ball, wall, block, boulder };

/// A pair that an engine says carries an impulse: ball number, then number among its partner's
/// kind.
struct loaded_pair {
  std::size_t ball = 0;
  partner kind = partner::ball;
  std::size_t other = 0;
};

/// Lengths are over the mean radius of all balls; a pair overlaps when its gap is negative.
struct findings {
  double mean_radius = 0;             ///< of the balls with finite positions, in units of the scene
  std::size_t not_finite = 0;         ///< balls with NaN or infinite position, left out below
  std::size_t behind_walls = 0;       ///< balls whose centre is on the solid side of a wall
  std::size_t overlapping_pairs = 0;  ///< gap < 0
  std::size_t touching_pairs = 0;     ///< gap <= touch * mean radius
  double penetration_mean = 0;        ///< over the overlapping pairs
  double penetration_max = 0;
  double gap_mean_touching = 0;  ///< mean |gap| over the touching pairs
};

inline double dot(const vec& a, const vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline vec minus(const vec& a, const vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// Signed distance of two surfaces.
inline double gap(const ball& a, const ball& b) {
  const vec d = minus(a.position, b.position);
  return std::sqrt(dot(d, d)) - a.radius - b.radius;
}

inline double gap(const ball& a, const wall& w) {
  return dot(w.normal, a.position) - w.offset - a.radius;
}

/// Outside: distance to the nearest point of the box. Centre inside: minus the way out through the
/// nearest face.
inline double gap(const ball& a, const block& b) {
  const vec d = minus(a.position, b.centre);
  const auto [w, x, y, z] = b.orientation;
  const vec axes[3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                       {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                       {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
  double outside_squared = 0, inside = -INFINITY;
  for (std::size_t k = 0; k < 3; ++k) {
    const double beyond = std::abs(dot(axes[k], d)) - 0.5 * b.size[k];
    if (beyond > 0) outside_squared += beyond * beyond;
    inside = std::max(inside, beyond);
  }
  return (outside_squared > 0 ? std::sqrt(outside_squared) : inside) - a.radius;
}

namespace detail {

inline bool finite(const ball& b) {
  return std::isfinite(b.position[0]) && std::isfinite(b.position[1]) &&
         std::isfinite(b.position[2]);
}

/// Calls f(i, j) once for every two finite balls that share a cell or sit in neighbouring cells; a
/// cell is as wide as the largest possible touching distance.
template <class F>
void near_pairs(std::span<const ball> balls, double touch, F&& f) {
  using cell =
      std::array<double, 3>;  // whole numbers; bodies gone far astray share the outermost cells
  double largest = 0;
  for (const ball& b : balls) largest = std::max(largest, b.radius);
  const double width = 2 * largest + touch;
  std::vector<std::pair<cell, std::size_t>> cells;
  cells.reserve(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    if (!finite(balls[i])) continue;
    cell c{};
    for (std::size_t k = 0; k < 3; ++k)
      c[k] = std::clamp(std::floor(balls[i].position[k] / width), -0x1p50, 0x1p50);
    cells.emplace_back(c, i);
  }
  std::sort(cells.begin(), cells.end());
  for (auto me = cells.begin(); me != cells.end(); ++me) {
    for (auto it = me + 1; it != cells.end() && it->first == me->first; ++it)
      f(me->second, it->second);
    for (int row = 0; row < 5; ++row) {  // half of the 26 neighbours, as runs along the last axis
      static constexpr int runs[5][4] = {
          {0, 0, 1, 1}, {0, 1, -1, 1}, {1, -1, -1, 1}, {1, 0, -1, 1}, {1, 1, -1, 1}};
      const cell first{me->first[0] + runs[row][0], me->first[1] + runs[row][1],
                       me->first[2] + runs[row][2]};
      const double last = me->first[2] + runs[row][3];
      auto it = std::lower_bound(me, cells.end(), first,
                                 [](const auto& entry, const cell& c) { return entry.first < c; });
      for (; it != cells.end() && it->first[0] == first[0] && it->first[1] == first[1] &&
             it->first[2] <= last;
           ++it)
        f(me->second, it->second);
    }
  }
}

}  // namespace detail

/// Judges final positions. `touch`, over the mean radius, only decides what counts as touching.
inline findings check(std::span<const ball> balls, std::span<const wall> walls,
                      std::span<const block> blocks, std::span<const ball> boulders = {},
                      double touch = 1e-3) {
  findings f;
  std::size_t counted = 0;
  for (const ball& b : balls) {
    if (!detail::finite(b)) {
      ++f.not_finite;
      continue;
    }
    ++counted;
    f.mean_radius += b.radius;
  }
  if (counted == 0) return f;
  f.mean_radius /= static_cast<double>(counted);

  const auto judge = [&](double g) {
    g /= f.mean_radius;
    if (g > touch) return;
    ++f.touching_pairs;
    f.gap_mean_touching += std::abs(g);
    if (g >= 0) return;
    ++f.overlapping_pairs;
    f.penetration_mean -= g;
    f.penetration_max = std::max(f.penetration_max, -g);
  };
  detail::near_pairs(balls, touch * f.mean_radius,
                     [&](std::size_t i, std::size_t j) { judge(gap(balls[i], balls[j])); });
  for (const ball& b : balls) {
    if (!detail::finite(b)) continue;
    bool behind = false;
    for (const wall& w : walls) {
      const double g = gap(b, w);
      judge(g);
      behind = behind || g < -b.radius;
    }
    for (const block& s : blocks) judge(gap(b, s));
    for (const ball& s : boulders) {
      const double g = gap(b, s);
      judge(g);
      behind = behind || g < -b.radius;
    }
    f.behind_walls += behind;
  }
  if (f.overlapping_pairs > 0) f.penetration_mean /= static_cast<double>(f.overlapping_pairs);
  if (f.touching_pairs > 0) f.gap_mean_touching /= static_cast<double>(f.touching_pairs);
  return f;
}

/// Mean |gap| over the pairs that carry an impulse, over the mean radius; 0 without pairs.
inline double gap_mean_loaded(std::span<const ball> balls, std::span<const wall> walls,
                              std::span<const block> blocks, std::span<const loaded_pair> pairs,
                              std::span<const ball> boulders = {}) {
  double radii = 0, sum = 0;
  for (const ball& b : balls) radii += b.radius;
  for (const auto& [i, kind, j] : pairs) {
    sum += std::abs(kind == partner::ball    ? gap(balls[i], balls[j])
                    : kind == partner::wall  ? gap(balls[i], walls[j])
                    : kind == partner::block ? gap(balls[i], blocks[j])
                                             : gap(balls[i], boulders[j]));
  }
  return pairs.empty() ? 0.0
                       : sum / static_cast<double>(pairs.size()) /
                             (radii / static_cast<double>(balls.size()));
}

}  // namespace bench
