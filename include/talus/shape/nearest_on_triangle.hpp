#pragma once
// The point of a triangle that is nearest to another one.
#include "talus/core/math.hpp"

namespace talus::detail {

/// A point of a triangle: inside, on the edge from corner k to the next (edge = k), or at a corner.
struct triangle_point {
  vec3 at;
  int edge = -1, corner = -1;
};

/// The point nearest to `p` (Ericson 2005, Real-Time Collision Detection, 5.1.5).
[[nodiscard]] inline triangle_point nearest_on_triangle(const vec3& p, const vec3& a, const vec3& b,
                                                        const vec3& c) {
  const vec3 ab = b - a, ac = c - a, ap = p - a;
  const real d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {a, -1, 0};
  const vec3 bp = p - b;
  const real d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {b, -1, 1};
  const real vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, 0, -1};
  const vec3 cp = p - c;
  const real d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {c, -1, 2};
  const real vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, 2, -1};
  const real va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6)
    return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), 1, -1};
  const real sum = va + vb + vc;
  return {a + vb / sum * ab + vc / sum * ac, -1, -1};
}

}  // namespace talus::detail
