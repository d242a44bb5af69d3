#pragma once
// Component by component: operations of tests on vectors.
#include <cmath>

#include "talus/core/math.hpp"

namespace talus {

inline bool at_most(const vec3& a, const vec3& b) {
  return a[0] <= b[0] && a[1] <= b[1] && a[2] <= b[2];
}
inline bool below(const vec3& a, const vec3& b) {
  return a[0] < b[0] && a[1] < b[1] && a[2] < b[2];
}
inline real product_of(const vec3& a) { return a[0] * a[1] * a[2]; }
inline vec3 rounded(const vec3& a) {
  return {std::round(a[0]), std::round(a[1]), std::round(a[2])};
}

}  // namespace talus
