#pragma once
// The area of a wall: of the face that the other planes, and a periodic box, leave of it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/shape/plane.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The part of a plane for which `along`.x >= `from`, where x counts in the plane.
struct half_of_plane {
  real a, b;  ///< a unit vector
  real from;
};

/// The area of the points of all halves: 0 if there are none, infinite if they are not bounded. Its
/// sides are the parts of the lines on which it ends; each adds a triangle with the origin.
[[nodiscard, gnu::cold]] inline real area_within(const std::vector<half_of_plane>& halves) {
  constexpr real infinity = std::numeric_limits<real>::infinity(), parallel = 1e-12;
  if (halves.empty()) return infinity;
  real twice = 0;
  for (std::size_t i = 0; i < halves.size(); ++i) {
    const half_of_plane& side = halves[i];  // its points: from (a, b) + t (-b, a)
    real first = -infinity, last = infinity;
    for (std::size_t j = 0; j < halves.size() && first < last; ++j) {
      if (j == i) continue;
      const half_of_plane& other = halves[j];
      const real grows = other.b * side.a - other.a * side.b;
      const real lacks = other.from - side.from * (side.a * other.a + side.b * other.b);
      if (std::abs(grows) > parallel)
        grows > 0 ? first = std::max(first, lacks / grows) : last = std::min(last, lacks / grows);
      else if (lacks > 0 || (lacks == 0 && j < i))  // beyond the other, or the same line again
        first = last;
    }
    if (!(first < last)) continue;
    twice -= side.from * (last - first);
    if (!std::isfinite(first) || !std::isfinite(last)) return infinity;
  }
  return twice / 2;
}

/// The area of plane `wall` among the global ones.
template <class Scenario>
[[nodiscard, gnu::cold]] real area_of_plane(const world_state<Scenario>& s, std::size_t wall) {
  const auto& planes = s.template of<plane>().global.shape;
  const vec3 normal = planes[wall].unit_normal(), at = planes[wall].offset * normal;
  const vec3 u = unit(std::abs(normal[0]) < real(0.6) ? vec3(normal.cross(vec3(1, 0, 0)))
                                                      : vec3(normal.cross(vec3(0, 1, 0))));
  const vec3 v = normal.cross(u);
  std::vector<half_of_plane> halves;
  const auto cut = [&](const vec3& n, real offset) {
    const real a = n.dot(u), b = n.dot(v), length = std::sqrt(a * a + b * b);
    if (length > real(1e-9))
      halves.push_back({a / length, b / length, (offset - n.dot(at)) / length});
  };
  for (std::size_t k = 0; k < planes.size(); ++k)
    if (k != wall) cut(planes[k].unit_normal(), planes[k].offset);
  if constexpr (world_state<Scenario>::periodic) {
    const auto& box = s.own.box();
    for (int k = 0; k < 3; ++k) {
      if (!(box.period()[k] > 0)) continue;
      vec3 along(0, 0, 0);
      along[k] = 1;
      cut(along, box.lower()[k]), cut(-along, -box.upper()[k]);
    }
  }
  return area_within(halves);
}

}  // namespace talus::detail
