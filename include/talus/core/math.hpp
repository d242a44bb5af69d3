#pragma once
// Scalars, vectors and rotations of the whole library.
#include <algorithm>
#include <cmath>

#include "talus/core/matrix3.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/core/quaternion.hpp"
#include "talus/core/vector3.hpp"

namespace talus {

/// Scalar of positions, shapes and all user-facing values. Lengths, masses and times are in any
/// consistent system of units; talus has no built-in units.
using real = double;

using vec3 = vector3<real>;
using mat3 = matrix3<real>;

using quat = quaternion<real>;

inline constexpr real pi = 3.141592653589793238462643383279502884;

/// `v` rotated by `q`, a unit quaternion.
[[nodiscard]] inline vec3 rotated(const quat& q, const vec3& v) {
  const real x = q.x(), y = q.y(), z = q.z(), w = q.w();
  const real a = 2 * (y * v[2] - z * v[1]), b = 2 * (z * v[0] - x * v[2]),
             c = 2 * (x * v[1] - y * v[0]);
  return {v[0] + w * a + (y * c - z * b), v[1] + w * b + (z * a - x * c),
          v[2] + w * c + (x * b - y * a)};
}

/// Position of the centre of mass and orientation of a body.
struct pose {
  vec3 position{0, 0, 0};
  quat orientation{1, 0, 0, 0};

  /// World coordinates of a point given in the frame of the body.
  [[nodiscard]] vec3 to_world(const vec3& local) const {
    return position + rotated(orientation, local);
  }
  /// Body coordinates of a point of the world.
  [[nodiscard]] vec3 to_body(const vec3& world) const {
    return rotated(quat(orientation.w(), -orientation.x(), -orientation.y(), -orientation.z()),
                   world - position);
  }
};

/// `v` normalised, for any length; the zero vector is unchanged.
[[nodiscard]] inline vec3 unit(const vec3& v) {
  const real largest = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
  if (!(largest > 0)) return v;
  const real x = v[0] / largest, y = v[1] / largest, z = v[2] / largest;
  const real length = std::sqrt(x * x + (y * y + z * z)) * largest;
  return {v[0] / length, v[1] / length, v[2] / length};
}

/// Rotation by `angle` (radians) about `axis` (any length but zero).
[[nodiscard]] inline quat rotation(const vec3& axis, real angle) {
  const auto half = portable::sincos(angle / 2);
  const real length = axis.norm(), s = half.sine;
  return {half.cosine, s * (axis[0] / length), s * (axis[1] / length), s * (axis[2] / length)};
}

}  // namespace talus
