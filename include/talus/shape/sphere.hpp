#pragma once
// A ball about the centre of mass. Neither this file nor its pair functions read the orientation.
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/convex_form.hpp"

namespace talus {

/// A ball about its centre.
struct sphere {
  real radius = 1;  ///< length, above zero

  static constexpr bool finite = true;
  static constexpr bool isotropic = true;
  static constexpr const char* name = "sphere";
  static constexpr const char* numbers[] = {"radius"};

  /// Throws invalid_argument unless the radius is positive and between 1e-120 and 1e120.
  void validate() const { detail::require_size(radius, "the radius of a sphere"); }

  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const { return radius; }
  /// Volume.
  [[nodiscard]] real volume() const { return 4 * pi / 3 * radius * radius * radius; }
  /// Principal moments per unit mass: 2/5 r² each.
  [[nodiscard]] vec3 inertia() const { return detail::thrice<real>(real(0.4) * radius * radius); }
  /// Furthest point along `direction` (any length; the centre for a zero direction).
  [[nodiscard]] vec3 support(const vec3& direction) const { return radius * unit(direction); }
  /// The part of the line p + t d inside it.
  [[nodiscard]] talus::chord chord(const vec3& p, const vec3& d) const {
    return detail::chord_of_ball(p, d, radius);
  }
  [[nodiscard]] vec3 half_extents(const pose&) const { return detail::thrice<real>(radius); }
  /// The form of the shape, with its faces and edges, for the general contact search.
  [[nodiscard]] ball_form form() const { return {radius}; }

  friend bool operator==(const sphere&, const sphere&) = default;
};

}  // namespace talus
