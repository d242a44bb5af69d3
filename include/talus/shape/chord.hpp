#pragma once
// Where a line is inside a convex shape.
#include <algorithm>
#include <cmath>
#include <limits>

#include "talus/core/math.hpp"

namespace talus {

/// The points p + t d of a line with `from` < t < `to`; none unless `from` < `to`.
struct chord {
  real from = -std::numeric_limits<real>::infinity();
  real to = std::numeric_limits<real>::infinity();

  /// Whether the line misses the shape.
  [[nodiscard]] bool empty() const { return !(from < to); }
};

namespace detail {

inline constexpr chord no_chord{1, 0};

/// The points that two chords share.
[[nodiscard]] inline chord shared(const chord& a, const chord& b) {
  return {std::max(a.from, b.from), std::min(a.to, b.to)};
}
/// The chord of the points with x <= top, where x = at + rise t.
[[nodiscard]] inline chord chord_below(real at, real rise, real top) {
  if (rise == 0) return at <= top ? chord{} : no_chord;
  const real t = (top - at) / rise;
  return rise > 0 ? chord{.to = t} : chord{.from = t};
}
/// The chord of the points with x² <= r², where x² = a t² + 2 b t + c.
[[nodiscard]] inline chord chord_within(real a, real b, real c, real r) {
  const real rest = c - r * r;
  if (a == 0) return rest <= 0 ? chord{} : no_chord;
  const real square = b * b - a * rest;
  if (!(square > 0)) return no_chord;
  const real half = std::sqrt(square);
  return {(-b - half) / a, (-b + half) / a};
}
[[nodiscard]] inline chord chord_of_ball(const vec3& p, const vec3& d, real r) {
  return chord_within(d.dot(d), p.dot(d), p.dot(p), r);
}
/// The chord of a cylinder about the z axis.
[[nodiscard]] inline chord chord_of_cylinder(const vec3& p, const vec3& d, real r, real half) {
  const chord round = chord_within(d[0] * d[0] + d[1] * d[1], p[0] * d[0] + p[1] * d[1],
                                   p[0] * p[0] + p[1] * p[1], r);
  return shared(round, shared(chord_below(p[2], d[2], half), chord_below(-p[2], -d[2], half)));
}

}  // namespace detail
}  // namespace talus
