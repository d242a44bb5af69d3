#pragma once
// All points within a radius of a segment of the z axis: a cylinder with a hemisphere on each end.
#include <cmath>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/convex_form.hpp"

namespace talus {

/// A cylinder with a hemisphere on each end, about its centre; its axis is the z axis of its frame.
struct capsule {
  real radius = 1;  ///< length, above zero
  real length = 1;  ///< of the segment, without the caps; above zero

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "capsule";
  static constexpr const char* numbers[] = {"radius", "length"};

  /// Throws invalid_argument unless radius and length are positive and between 1e-120 and 1e120.
  void validate() const {
    detail::require_size(radius, "the radius of a capsule");
    detail::require_size(length, "the length of a capsule");
  }

  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const { return real(0.5) * length + radius; }
  /// Volume.
  [[nodiscard]] real volume() const { return pi * radius * radius * (length + 4 * radius / 3); }
  /// Principal moments per unit mass, from those of the cylinder and of the two hemispheres, whose
  /// centres of mass lie 3/8 r beyond the ends of the segment.
  [[nodiscard]] vec3 inertia() const {
    const real r = radius, l = length;
    const real balls = 4 * r / (3 * l + 4 * r), middle = 1 - balls;  // parts of the mass
    const real along = r * r * (middle / 2 + real(0.4) * balls);
    const real across =
        middle * (l * l / 12 + r * r / 4) + balls * (real(0.4) * r * r + l * l / 4 + 3 * l * r / 8);
    return {across, across, along};
  }
  /// Furthest point along `direction`; across the axis, on the side of the positive end.
  [[nodiscard]] vec3 support(const vec3& direction) const {
    vec3 p = radius * unit(direction);
    p[2] += direction[2] < 0 ? -length / 2 : length / 2;
    return p;
  }
  /// Distance of the furthest point from the point p.
  [[nodiscard]] real reach_from(const vec3& p) const {
    return portable::hypot(p[0], p[1], std::abs(p[2]) + length / 2) + radius;
  }
  /// The part of the line p + t d inside it.
  [[nodiscard]] talus::chord chord(const vec3& p, const vec3& d) const {
    talus::chord all = detail::chord_of_cylinder(p, d, radius, length / 2);
    for (const real end : {-length / 2, length / 2}) {
      const talus::chord cap = detail::chord_of_ball(p - vec3(0, 0, end), d, radius);
      if (cap.empty()) continue;
      all =
          all.empty() ? cap : talus::chord{std::min(all.from, cap.from), std::max(all.to, cap.to)};
    }
    return all;
  }
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    const vec3 end = rotated(at.orientation, vec3(0, 0, length / 2));
    return {std::abs(end[0]) + radius, std::abs(end[1]) + radius, std::abs(end[2]) + radius};
  }
  /// The form of the shape, with its faces and edges, for the general contact search.
  [[nodiscard]] segment_form form() const { return {length / 2, radius}; }

  friend bool operator==(const capsule&, const capsule&) = default;
};

}  // namespace talus
