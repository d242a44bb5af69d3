#pragma once
// The picture of a convex shape from its support function alone: triangles between the furthest
// points along directions that are spread over the sphere.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "talus/core/math.hpp"

namespace talus::detail {

/// A surface of triangles, counterclockwise as seen from outside.
struct support_surface {
  std::vector<vec3> points, normals;  ///< of each corner
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The surface of the shape whose furthest point along a direction is support(shape, direction).
/// The directions are those of an octahedron whose edges are divided into `parts`, so that the
/// extreme points along the axes belong to the surface.
[[nodiscard, gnu::cold]] inline support_surface surface_of_support(
    const void* shape, vec3 (*support)(const void*, const vec3&), int parts) {
  support_surface s;
  real size = 0;
  const auto add_point = [&](const vec3& direction) {
    s.normals.push_back(direction.normalized());
    s.points.push_back(support(shape, s.normals.back()));
    size = std::max(size, s.points.back().norm());
  };
  // Each eighth of the sphere has its own rows of points: those on its borders are there twice.
  for (unsigned eighth = 0; eighth < 8; ++eighth) {
    const auto sign = [&](unsigned bit) { return (eighth >> bit & 1u) != 0 ? real(-1) : real(1); };
    const bool turned = sign(0) * sign(1) * sign(2) < 0;
    std::uint32_t row = static_cast<std::uint32_t>(s.points.size());
    for (int i = 0; i <= parts; ++i)
      for (int j = 0; j <= i; ++j)
        add_point({sign(0) * (i - j), sign(1) * j, sign(2) * (parts - i)});
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      s.triangles.push_back(turned ? std::array{a, c, b} : std::array{a, b, c});
    };
    for (int i = 0; i < parts; ++i) {
      const auto width = static_cast<std::uint32_t>(i + 1), below = row + width;
      for (std::uint32_t j = 0; j < width; ++j) {
        add(row + j, below + j, below + j + 1);
        if (j + 1 < width) add(row + j, below + j + 1, row + j + 1);
      }
      row = below;
    }
  }
  // Where a shape has an edge or a corner, several directions have one point.
  std::erase_if(s.triangles, [&](const std::array<std::uint32_t, 3>& t) {
    const vec3 ab = s.points[t[1]] - s.points[t[0]], ac = s.points[t[2]] - s.points[t[0]];
    return !(ab.cross(ac).norm() > real(1e-9) * size * size);
  });
  return s;
}
template <class Shape>
[[nodiscard]] support_surface surface_of_support(const Shape& s, int parts = 6) {
  const auto support = [](const void* shape, const vec3& direction) -> vec3 {
    return static_cast<const Shape*>(shape)->support(direction);
  };
  return surface_of_support(&s, support, parts);
}

}  // namespace talus::detail
