#pragma once
// Where a straight way meets a surface, and the boxes that it passes. For queries.
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/triangle_tree.hpp"

namespace talus::detail {

inline constexpr real endless = std::numeric_limits<real>::infinity();

/// The place where a ray or a moving shape meets a body, or the point of a body nearest to another.
struct surface_hit {
  real distance = endless;  ///< from the start; `endless`: none
  vec3 point{0, 0, 0};      ///< on the surface of the body
  vec3 normal{0, 0, 0};     ///< out of the body, unit length
  bool inside = false;      ///< the start is in the body: distance 0, the point is the start

  [[nodiscard]] bool found() const { return distance < endless; }
};
/// The way begins in the body.
[[nodiscard]] inline surface_hit hit_at_start(const vec3& from, const vec3& direction) {
  return {0, from, -direction, true};
}

/// The part of the line p + t d in a box, which may be flat; none if `from` > `to`.
[[nodiscard]] inline chord chord_of_bounds(const vec3& lower, const vec3& upper, const vec3& p,
                                           const vec3& d) {
  chord c;
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0) {
      if (!(p[k] >= lower[k] && p[k] <= upper[k])) return no_chord;
      continue;
    }
    const real a = (lower[k] - p[k]) / d[k], b = (upper[k] - p[k]) / d[k];
    c.from = std::max(c.from, std::min(a, b)), c.to = std::min(c.to, std::max(a, b));
  }
  return c;
}
/// The part of the line p + t d, d of unit length, within `radius` of the origin.
[[nodiscard]] inline chord chord_near_origin(const vec3& p, const vec3& d, real radius) {
  const real middle = -p.dot(d);
  const real square = radius * radius - vec3(p + middle * d).squaredNorm();
  if (!(square >= 0)) return no_chord;
  const real half = std::sqrt(square);
  return {middle - half, middle + half};
}
/// The squared distance of a point from a box.
[[nodiscard]] inline real square_to_bounds(const vec3& lower, const vec3& upper, const vec3& p) {
  const vec3 zero(0, 0, 0);
  return ((lower - p).cwiseMax(zero) + (p - upper).cwiseMax(zero)).squaredNorm();
}

/// Calls f(number) for the triangles whose boxes, widened by `reach`, the line p + t d meets at a t
/// from 0 to `length`; f returns the length from then on.
template <class F>
void each_triangle_along(const triangle_tree& m, const vec3& p, const vec3& d, real length,
                         const vec3& reach, F&& f) {
  const real round_off = real(1e-12) * (m.bounding_radius + p.norm());
  const vec3 wide = reach + vec3(round_off, round_off, round_off);
  std::array<std::uint32_t, 64> waiting;  // as triangle_tree::each_within
  std::size_t size = 0;
  waiting[size++] = 0;
  while (size > 0) {
    const std::uint32_t at = waiting[--size];
    const auto& n = m.nodes[at];
    const chord c = chord_of_bounds(n.lower - wide, n.upper + wide, p, d);
    if (!(c.from <= c.to && c.to >= 0 && c.from <= length)) continue;
    if (n.count == 0) {
      waiting[size++] = n.first;
      waiting[size++] = at + 1;
      continue;
    }
    for (std::uint32_t k = n.first; k < n.first + n.count; ++k) length = f(m.order[k]);
  }
}
/// Calls f(number) for the triangles whose boxes may be nearer to p than `distance`; f returns the
/// distance from then on.
template <class F>
void each_triangle_near(const triangle_tree& m, const vec3& p, real distance, F&& f) {
  std::array<std::uint32_t, 64> waiting;
  std::size_t size = 0;
  waiting[size++] = 0;
  const auto away = [&](std::uint32_t at) {
    return square_to_bounds(m.nodes[at].lower, m.nodes[at].upper, p);
  };
  while (size > 0) {
    const std::uint32_t at = waiting[--size];
    if (!(away(at) <= distance * distance)) continue;
    const auto& n = m.nodes[at];
    if (n.count == 0) {
      const bool first_is_nearer = away(n.first) < away(at + 1);
      waiting[size++] = first_is_nearer ? at + 1 : n.first;
      waiting[size++] = first_is_nearer ? n.first : at + 1;
      continue;
    }
    for (std::uint32_t k = n.first; k < n.first + n.count; ++k) distance = f(m.order[k]);
  }
}

}  // namespace talus::detail
