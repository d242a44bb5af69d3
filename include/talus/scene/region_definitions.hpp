#pragma once
// The definitions of region.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/scene/region.hpp"

namespace talus {

TALUS_INLINE real box_region::value(const vec3& p) const {
  return std::min(detail::least_of(vec3(p - lower)), detail::least_of(vec3(upper - p)));
}

TALUS_INLINE real vertical_cylinder::value(const vec3& p) const {
  const real side = radius - portable::hypot(p[0] - centre[0], p[1] - centre[1]);
  return std::min(side, std::min(p[2] - lower, upper - p[2]));
}

TALUS_INLINE bool vertical_cylinder::contains(const vec3& p) const {
  const real x = p[0] - centre[0], y = p[1] - centre[1];
  return p[2] >= lower && p[2] <= upper && std::fma(x, x, y * y) <= radius * radius;
}

TALUS_INLINE detail::region_extent vertical_cylinder::extent() const {
  return {{centre[0] - radius, centre[1] - radius, lower},
          {centre[0] + radius, centre[1] + radius, upper},
          true};
}

TALUS_INLINE detail::region_extent ball_region::extent() const {
  return {centre - detail::thrice<real>(radius), centre + detail::thrice<real>(radius), false};
}

}  // namespace talus

namespace talus::detail {

TALUS_INLINE void extent_finder::open(bool all_of) {
  path_.push_back({all_of, {}});
  if (!all_of) {
    std::swap(path_.back().extent.lower, path_.back().extent.upper);  // of nothing yet
  }
}

TALUS_INLINE void extent_finder::close() {
  const region_extent e = path_.back().extent;
  path_.pop_back();
  add(e);
}

TALUS_INLINE void extent_finder::add(const region_extent& e) {
  auto& [all_of, sum] = path_.back();
  sum.lower = all_of ? detail::upper_of(sum.lower, e.lower) : detail::lower_of(sum.lower, e.lower);
  sum.upper = all_of ? detail::lower_of(sum.upper, e.upper) : detail::upper_of(sum.upper, e.upper);
  sum.prism = sum.prism && e.prism;
}

}  // namespace talus::detail
