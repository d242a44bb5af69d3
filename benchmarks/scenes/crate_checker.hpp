#pragma once
// The judge of boxes: how deep they overlap each other and the walls, from final positions alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "checker.hpp"
#include "scene.hpp"

namespace bench {

inline std::array<vec, 3> axes_of(const crate& c) {
  const auto [w, x, y, z] = c.orientation;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
           {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
           {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}}};
}

inline double norm(const vec& v) { return std::sqrt(dot(v, v)); }
inline vec cross(const vec& a, const vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Extent of a box from its centre along a unit vector.
inline double half_width(const crate& c, const std::array<vec, 3>& axes, const vec& n) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += 0.5 * c.size[k] * std::abs(dot(axes[k], n));
  return sum;
}

/// Depth of an overlap is the shortest translation that ends it (Gottschalk, Lin, Manocha 1996:
/// the fifteen axes suffice); positive for a pair apart, then a lower bound of the distance.
inline double gap(const crate& a, const crate& b) {
  const auto u = axes_of(a), v = axes_of(b);
  const vec d = minus(b.centre, a.centre);
  double widest = -INFINITY;
  const auto along = [&](vec n) {
    const double length = norm(n);
    if (length < 1e-6) return;  // parallel edges: no axis of their own
    for (double& x : n) x /= length;
    widest = std::max(widest, std::abs(dot(d, n)) - half_width(a, u, n) - half_width(b, v, n));
  };
  for (const vec& n : u) along(n);
  for (const vec& n : v) along(n);
  for (const vec& m : u)
    for (const vec& n : v) along(cross(m, n));
  return widest;
}

inline double gap(const crate& c, const wall& w) {
  return dot(w.normal, c.centre) - w.offset - half_width(c, axes_of(c), w.normal);
}

/// Overlaps over the pairs with negative gap, in units of length.
struct overlaps {
  double mean = 0, max = 0;
  std::size_t pairs = 0, not_finite = 0;
};

/// Looks at all pairs whose bounding spheres meet, found with the cells of checker.hpp.
inline overlaps check(std::span<const crate> crates, std::span<const wall> walls) {
  overlaps found;
  const auto judge = [&](double g) {
    if (!(g < 0)) return;
    ++found.pairs;
    found.mean -= g;
    found.max = std::max(found.max, -g);
  };
  std::vector<ball> around;
  for (const crate& c : crates) {
    around.push_back({.position = c.centre, .radius = 0.5 * norm(c.size)});
    if (!detail::finite(around.back())) {
      ++found.not_finite;
      continue;
    }
    for (const wall& w : walls) judge(gap(c, w));
  }
  detail::near_pairs(around, 0, [&](std::size_t i, std::size_t j) {
    if (gap(around[i], around[j]) < 0) judge(gap(crates[i], crates[j]));
  });
  if (found.pairs > 0) found.mean /= static_cast<double>(found.pairs);
  return found;
}

}  // namespace bench
