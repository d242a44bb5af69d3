#pragma once
// Functions shared by decompositions about an axis: a frame, and clamping of points at infinity.
#include <algorithm>
#include <cmath>
#include <limits>

#include "talus/core/error.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/geometry/half_space.hpp"
#include "talus/parallel/detail/plain_vectors.hpp"

namespace talus::detail {

/// The point, with the largest finite numbers instead of infinite ones.
[[nodiscard]] inline vec3 bounded(const vec3& p) {
  constexpr real most = std::numeric_limits<real>::max();
  return {std::clamp(p[0], -most, most), std::clamp(p[1], -most, most),
          std::clamp(p[2], -most, most)};
}

/// With the same bits in every inlining.
[[nodiscard]] inline real exact_dot(const vec3& a, const vec3& b) {
  return rounded(a[0] * b[0]) + rounded(a[1] * b[1]) + rounded(a[2] * b[2]);
}

/// Cosine and sine; exact at quarter turns.
struct turn {
  real cosine, sine;
  explicit turn(real angle) : cosine(portable::cos(angle)), sine(portable::sin(angle)) {
    if (std::abs(cosine) < 1e-15) cosine = 0, sine = sine > 0 ? 1 : -1;
    if (std::abs(sine) < 1e-15) sine = 0, cosine = cosine > 0 ? 1 : -1;
  }
};

/// Two unit vectors across an axis, `second` a quarter turn after `first`.
struct axis_frame {
  vec3 axis, first, second;

  /// Makes `start` perpendicular to the axis. Throws invalid_argument for an axis or a start that
  /// is not a direction, and for a start along the axis; `what` names the decomposition.
  axis_frame(const char* what, const vec3& axis_given, const vec3& start)
      : axis(direction(what, "axis", axis_given)) {
    const vec3 along = direction(what, "start", start);
    const vec3 across = plus(along, -dot(along, axis), axis);
    if (largest(across) < 1e-6)
      fail<std::invalid_argument>(
          "the start of the {} is along its axis {}, so that it is no direction across it: give "
          ".start another direction than {}",
          what, text(axis_given), text(start));
    first = unit(across);
    second = cross(axis, first);
    for (int k = 0; k < 3; ++k) first[k] += 0.0, second[k] += 0.0;  // -0 becomes 0
  }

  /// cosine * first + sine * second.
  [[nodiscard]] vec3 towards(real cosine, real sine) const {
    return plus({cosine * first[0], cosine * first[1], cosine * first[2]}, sine, second);
  }
  [[nodiscard]] vec3 towards(const turn& t) const { return towards(t.cosine, t.sine); }

  static vec3 direction(const char* what, const char* name, const vec3& v) {
    if (!finite(v) || !(largest(v) > 0))
      fail<std::invalid_argument>(
          "the .{} of the {} must be a direction, finite and not zero, but is {}", name, what,
          text(v));
    return unit(v);
  }
};

/// The size given by a type, or by a value if the type has dynamic; `open` if neither gives one.
/// Throws invalid_argument if both are given and differ.
inline int chosen_size(const char* what, const char* field, int given, int asked, int open,
                       int least) {
  if (asked != open && asked < least)
    fail<std::invalid_argument>("a {} has {} or more .{}, but {} is asked for", what, least, field,
                                asked);
  if (given == -1) return asked;
  if (asked != open && asked != given)
    fail<std::invalid_argument>(
        "the type of the {} says {} for its {}, but .{} is {}: leave it out, or use {}<dynamic>",
        what, given, field, field, asked, what);
  return given;
}

}  // namespace talus::detail
