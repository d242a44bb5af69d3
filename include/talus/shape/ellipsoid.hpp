#pragma once
// An ellipsoid with three semi-axes, and its contacts: with planes in closed form, with spheres and
// ellipsoids by the normal that separates them best.
#include <cmath>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/convex_form.hpp"

namespace talus {

/// An ellipsoid about its centre, with semi-axes along those of its frame.
struct ellipsoid {
  vec3 radii{1, 1, 1};  ///< semi-axes, lengths above zero

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "ellipsoid";
  static constexpr const char* numbers[] = {"x radius", "y radius", "z radius"};

  /// Throws invalid_argument unless all three radii are positive and between 1e-120 and 1e120.
  void validate() const {
    detail::require_size(radii[0], "the x radius of an ellipsoid");
    detail::require_size(radii[1], "the y radius of an ellipsoid");
    detail::require_size(radii[2], "the z radius of an ellipsoid");
  }

  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const { return radii.maxCoeff(); }
  /// Radius of the largest ball about the centre that is inside.
  [[nodiscard]] real inner_radius() const { return radii.minCoeff(); }
  /// At the ends of the longest axis.
  [[nodiscard]] real smallest_curvature_radius() const {
    return radii.minCoeff() * (radii.minCoeff() / radii.maxCoeff());
  }
  /// At the ends of the shortest axis.
  [[nodiscard]] real largest_curvature_radius() const {
    return radii.maxCoeff() * (radii.maxCoeff() / radii.minCoeff());
  }
  /// Volume.
  [[nodiscard]] real volume() const { return 4 * pi / 3 * radii[0] * radii[1] * radii[2]; }
  /// Principal moments per unit mass: (b² + c²) / 5 about the axis of radius a, and so on.
  [[nodiscard]] vec3 inertia() const {
    const real x = radii[0] * radii[0] / 5, y = radii[1] * radii[1] / 5,
               z = radii[2] * radii[2] / 5;
    return {y + z, x + z, x + y};
  }
  /// Furthest point along `direction` (any length; the centre for a zero direction).
  [[nodiscard]] vec3 support(const vec3& direction) const {
    const vec3 d = unit(direction);
    const vec3 stretched(radii[0] * d[0], radii[1] * d[1], radii[2] * d[2]);
    const real length = stretched.norm();
    if (!(length > 0)) return {0, 0, 0};
    return {radii[0] * stretched[0] / length, radii[1] * stretched[1] / length,
            radii[2] * stretched[2] / length};
  }
  /// The part of the line p + t d inside it.
  [[nodiscard]] talus::chord chord(const vec3& p, const vec3& d) const {
    const auto over_radii = [&](const vec3& x) {
      return vec3(x[0] / radii[0], x[1] / radii[1], x[2] / radii[2]);
    };
    return detail::chord_of_ball(over_radii(p), over_radii(d), 1);
  }
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    const mat3 axes = at.orientation.toRotationMatrix();
    const auto along = [&](int i) {
      const real x = axes(i, 0) * radii[0], y = axes(i, 1) * radii[1], z = axes(i, 2) * radii[2];
      return std::sqrt(x * x + y * y + z * z);
    };
    return {along(0), along(1), along(2)};
  }
  /// How the furthest point moves if a unit direction turns: the derivative of `support`, a
  /// symmetric matrix, whose eigenvalues across the direction are the two radii of curvature.
  [[nodiscard]] mat3 bend(const vec3& direction) const {
    const vec3 p = support(direction);
    const real reach = direction.dot(p);
    mat3 m;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        m(i, j) = ((i == j ? radii[i] * radii[i] : real(0)) - p[i] * p[j]) / reach;
    return m;
  }

  /// The norm of which it is the unit ball.
  [[nodiscard]] surface_level level(const vec3& p) const {
    const vec3 scaled = p.cwiseQuotient(radii);
    const real value = scaled.norm();
    const vec3 out = scaled / value;
    const vec3 t = out.cross(vec3::Unit(std::abs(out[0]) < real(0.6) ? 0 : 1)).normalized();
    return {value,
            out.cwiseQuotient(radii),
            {{1 / value, 1 / value}, {t.cwiseQuotient(radii), out.cross(t).cwiseQuotient(radii)}}};
  }

  friend bool operator==(const ellipsoid&, const ellipsoid&) = default;
};

}  // namespace talus
