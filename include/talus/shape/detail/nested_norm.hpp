#pragma once
// The norm (|x|^p + |y|^p)^(1/p), and the same norm of its value and z with a second exponent. A
// superellipsoid is a unit ball of such a norm, and the dual norm, which has this form too, is its
// support function.
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"
#include "talus/core/quick_functions.hpp"
#include "talus/shape/surface_level.hpp"

namespace talus::detail {

/// The exponent p of a norm, as p - 1 and 1 - 1/p.
struct norm_exponent {
  real less_one = 1, over = real(0.5);

  [[nodiscard]] static norm_exponent of(real n) { return {n - 1, 1 - 1 / n}; }
  /// The exponent of the dual norm, n / (n - 1).
  [[nodiscard]] static norm_exponent dual(real n) { return {1 / (n - 1), 1 / n}; }
  /// The exponent 2 n / (n - 2) of the largest Euclidean norm on the unit ball of the exponent
  /// n > 2.
  [[nodiscard]] static norm_exponent reach(real n) {
    return {(n + 2) / (n - 2), (n + 2) / (2 * n)};
  }
  [[nodiscard]] bool two() const { return less_one == 1; }
};

/// A norm of two numbers with its derivatives.
struct planar_norm {
  real value = 0, along_x = 0, along_y = 0;
  real larger = 1;  ///< of the two numbers
  real bend = 0;    ///< the second derivative is bend v v^T with v = (-y, x) / larger

  planar_norm(real x, real y, const norm_exponent& p) {
    const real ax = std::abs(x), ay = std::abs(y), large = std::max(ax, ay);
    if (!(large > 0)) return;
    const real t = std::min(ax, ay) / large, s = quick_pow(t, p.less_one), w = 1 + t * s;
    const real f = p.two() ? 1 / std::sqrt(w) : quick_pow(w, -p.over);
    larger = large, value = large * w * f;
    along_x = std::copysign(ax >= ay ? f : s * f, x);
    along_y = std::copysign(ax >= ay ? s * f : f, y);
    // The (p - 2)th power of t. It has no bound for p < 2: 1e30 stands for infinity.
    const real rise = t > real(1e-300) ? s / t : p.two() ? 1 : p.less_one > 1 ? 0 : real(1e30);
    bend = p.less_one * f * f * rise / value;
  }
};

/// The nested norm of a vector with its gradient: of x and y with one exponent, of their norm and z
/// with another.
struct nested_norm {
  real value = 0;
  vec3 gradient{0, 0, 0};
  bending curvature;  ///< the second derivative

  nested_norm(const vec3& v, const norm_exponent& across, const norm_exponent& along) {
    const planar_norm flat(v[0], v[1], across), whole(flat.value, v[2], along);
    value = whole.value;
    gradient = vec3(whole.along_x * flat.along_x, whole.along_x * flat.along_y, whole.along_y);
    curvature.factor[0] = whole.along_x * flat.bend;
    curvature.along[0] = vec3(-v[1] / flat.larger, v[0] / flat.larger, 0);
    curvature.factor[1] = whole.bend;
    curvature.along[1] = vec3(-v[2] * flat.along_x / whole.larger,
                              -v[2] * flat.along_y / whole.larger, flat.value / whole.larger);
  }
};

/// A vector whose nested norm has second derivatives: on the z axis they depend on the direction
/// from which it is approached, here between x and y.
[[nodiscard]] inline vec3 off_the_axis(const vec3& v) {
  const real least = real(1e-100) * std::abs(v[2]);
  return std::max(std::abs(v[0]), std::abs(v[1])) > least ? v : vec3(least, least, v[2]);
}

}  // namespace talus::detail
