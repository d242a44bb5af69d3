#pragma once
// Mass properties that a description of a body may leave out.
#include "talus/core/math.hpp"

namespace talus {

/// A number that may be left out: `.mass = 2`.
class given_number {
 public:
  given_number() = default;
  given_number(real value) : value_(value), given_(true) {}
  /// Whether there is a value.
  explicit operator bool() const { return given_; }
  /// The value; 0 if there is none.
  [[nodiscard]] real value() const { return value_; }

 private:
  real value_ = 0;
  bool given_ = false;
};

/// A point that may be left out: `.centre = {0, 0, -0.3}`.
class given_point {
 public:
  given_point() = default;
  given_point(const vec3& value) : value_(value), given_(true) {}
  given_point(real x, real y, real z) : given_point(vec3(x, y, z)) {}
  /// Whether there is a value.
  explicit operator bool() const { return given_; }
  /// The value; the origin if there is none.
  [[nodiscard]] const vec3& value() const { return value_; }

 private:
  vec3 value_{0, 0, 0};
  bool given_ = false;
};

/// Moments of inertia that may be left out: `.inertia = 0.4` about all axes alike, `.inertia =
/// {1, 2, 2}` about the axes x, y and z, or a symmetric mat3.
class given_inertia {
 public:
  given_inertia() = default;
  given_inertia(real moment) : given_inertia(moment, moment, moment) {}
  given_inertia(real x, real y, real z) : given_inertia(vec3(x, y, z)) {}
  given_inertia(const vec3& moments) : given_inertia(detail::diagonal_matrix(moments)) {}
  given_inertia(const mat3& tensor) : value_(tensor), given_(true) {}
  /// Whether there is a value.
  explicit operator bool() const { return given_; }
  /// The tensor; 0 if there is none.
  [[nodiscard]] const mat3& value() const { return value_; }

 private:
  mat3 value_ = mat3::Zero();
  bool given_ = false;
};

}  // namespace talus
