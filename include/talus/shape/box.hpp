#pragma once
// A rectangular block with edges along the axes of the body frame and its centre at the origin.
#include <cmath>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/convex_form.hpp"

namespace talus {

/// A cuboid about its centre, with edges along the axes of its frame.
struct box {
  vec3 size{1, 1, 1};  ///< full edge lengths, above zero

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "box";
  static constexpr const char* numbers[] = {"x edge", "y edge", "z edge"};

  /// Throws invalid_argument unless all three edges are positive and between 1e-120 and 1e120.
  void validate() const {
    detail::require_size(size[0], "the x edge of a box");
    detail::require_size(size[1], "the y edge of a box");
    detail::require_size(size[2], "the z edge of a box");
  }

  /// Half its edges.
  [[nodiscard]] vec3 half() const { return {size[0] / 2, size[1] / 2, size[2] / 2}; }
  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const { return real(0.5) * size.norm(); }
  /// Volume.
  [[nodiscard]] real volume() const { return size[0] * size[1] * size[2]; }
  /// Principal moments per unit mass: (b² + c²) / 12 about the axis of edge a, and so on.
  [[nodiscard]] vec3 inertia() const {
    const real x = size[0] * size[0] / 12, y = size[1] * size[1] / 12, z = size[2] * size[2] / 12;
    return {y + z, x + z, x + y};
  }
  /// Furthest corner along `direction`; where a component is zero, the corner on the positive side.
  [[nodiscard]] vec3 support(const vec3& direction) const {
    const vec3 h = half();
    return {direction[0] < 0 ? -h[0] : h[0], direction[1] < 0 ? -h[1] : h[1],
            direction[2] < 0 ? -h[2] : h[2]};
  }
  /// Distance of the furthest point from the point p.
  [[nodiscard]] real reach_from(const vec3& p) const {
    const real x = std::abs(p[0]) + size[0] / 2, y = std::abs(p[1]) + size[1] / 2,
               z = std::abs(p[2]) + size[2] / 2;
    return std::sqrt(x * x + y * y + z * z);
  }
  /// The part of the line p + t d inside it.
  [[nodiscard]] talus::chord chord(const vec3& p, const vec3& d) const {
    talus::chord c;
    for (int k = 0; k < 3; ++k)
      for (const real sign : {-1., 1.})
        c = detail::shared(c, detail::chord_below(sign * p[k], sign * d[k], size[k] / 2));
    return c;
  }
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    const mat3 axes = at.orientation.toRotationMatrix();
    const vec3 h = half();
    const auto along = [&](int i) {
      return std::abs(axes(i, 0)) * h[0] + std::abs(axes(i, 1)) * h[1] +
             std::abs(axes(i, 2)) * h[2];
    };
    return {along(0), along(1), along(2)};
  }

  /// The form of the shape, with its faces and edges, for the general contact search.
  [[nodiscard]] block_form form() const { return {half()}; }

  friend bool operator==(const box&, const box&) = default;
};

}  // namespace talus
