#pragma once
// The vector operations that decompositions need, written out: every program compiles them, and
// Eigen's expressions are slow to compile.
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"

namespace talus::detail {

[[nodiscard]] inline vec3 cross(const vec3& a, const vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// p + factor * v.
[[nodiscard]] inline vec3 plus(const vec3& p, real factor, const vec3& v) {
  return {p[0] + factor * v[0], p[1] + factor * v[1], p[2] + factor * v[2]};
}
/// The largest absolute value of a component.
[[nodiscard]] inline real largest(const vec3& v) {
  return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
}

}  // namespace talus::detail
