#pragma once
// A straight circular cylinder about the z axis with its centre at the origin.
#include <cmath>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/convex_form.hpp"

namespace talus {

/// A cylinder about its centre; its axis is the z axis of its frame.
struct cylinder {
  real radius = 1;  ///< length, above zero
  real length = 1;  ///< from one flat face to the other, above zero

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "cylinder";
  static constexpr const char* numbers[] = {"radius", "length"};

  /// Throws invalid_argument unless radius and length are positive and between 1e-120 and 1e120.
  void validate() const {
    detail::require_size(radius, "the radius of a cylinder");
    detail::require_size(length, "the length of a cylinder");
  }

  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const { return portable::hypot(radius, length / 2); }
  /// Volume.
  [[nodiscard]] real volume() const { return pi * radius * radius * length; }
  /// Principal moments per unit mass: r²/4 + l²/12 across the axis, r²/2 about it.
  [[nodiscard]] vec3 inertia() const {
    const real across = radius * radius / 4 + length * length / 12;
    return {across, across, radius * radius / 2};
  }
  /// Furthest point along `direction`, on an edge circle; if it is not unique, on the positive
  /// side.
  [[nodiscard]] vec3 support(const vec3& direction) const {
    const real x = direction[0], y = direction[1];
    const real largest = std::max(std::abs(x), std::abs(y));
    const real z = direction[2] < 0 ? -length / 2 : length / 2;
    if (!(largest > 0)) return {radius, 0, z};
    const real u = x / largest, v = y / largest, scale = radius / std::sqrt(u * u + v * v);
    return {scale * u, scale * v, z};
  }
  /// Distance of the furthest point from the point p.
  [[nodiscard]] real reach_from(const vec3& p) const {
    return portable::hypot(portable::hypot(p[0], p[1]) + radius, std::abs(p[2]) + length / 2);
  }
  /// The part of the line p + t d inside it.
  [[nodiscard]] talus::chord chord(const vec3& p, const vec3& d) const {
    return detail::chord_of_cylinder(p, d, radius, length / 2);
  }
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    const vec3 axis = rotated(at.orientation, vec3(0, 0, 1));
    const auto along = [&](int i, int j, int k) {
      return std::abs(axis[i]) * length / 2 + portable::hypot(axis[j], axis[k]) * radius;
    };
    return {along(0, 1, 2), along(1, 2, 0), along(2, 0, 1)};
  }
  /// The form of the shape, with its faces and edges, for the general contact search.
  [[nodiscard]] drum_form form() const { return {radius, length / 2}; }

  friend bool operator==(const cylinder&, const cylinder&) = default;
};

}  // namespace talus
