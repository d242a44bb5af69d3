#pragma once
// The half of space below a plane: a floor or a wall. Infinite, so it has no mass and no centre.
#include <cmath>
#include <limits>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"

namespace talus {

/// The half-space n.x <= offset is solid; n is the normalised normal. Both are in the frame of the
/// world: a plane ignores the pose of its body, and moving the body changes the plane itself.
struct plane {
  vec3 normal{0, 0, 1};  ///< points out of the solid; any length but zero
  real offset = 0;       ///< distance of the surface from the origin along the normal

  static constexpr bool finite = false;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "plane";

  /// Throws invalid_argument unless the normal has a direction and both values are finite.
  void validate() const {
    if (!detail::finite(normal) || (normal[0] == 0 && normal[1] == 0 && normal[2] == 0))
      detail::fail<std::invalid_argument>(
          "the normal of a plane must be finite and not zero, but is {}; give a direction",
          detail::text(normal));
    if (!std::isfinite(offset))
      detail::fail<std::invalid_argument>(
          "the offset of a plane must be finite, but is {}; give a distance from the origin",
          offset);
  }

  /// The normalised normal; unchanged to the bit if its length is already one.
  [[nodiscard]] vec3 unit_normal() const {
    constexpr real round_off = 4 * std::numeric_limits<real>::epsilon();
    return std::abs(normal.squaredNorm() - 1) <= round_off ? normal : unit(normal);
  }
  /// Signed distance of a point from the surface, negative in the solid.
  [[nodiscard]] real distance(const vec3& point) const { return unit_normal().dot(point) - offset; }

  /// Moves the plane.
  void translate(const vec3& by) { offset += unit_normal().dot(by); }
  /// Rotates it by a unit quaternion about a point.
  void rotate(const quat& by, const vec3& about) {
    const real above = distance(about);
    normal = rotated(by, unit_normal());
    offset = normal.dot(about) - above;
  }

  friend bool operator==(const plane&, const plane&) = default;
};

}  // namespace talus
