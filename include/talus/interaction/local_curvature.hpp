#pragma once
// The radius of Hertz's theory at the contact of surfaces with two curvatures each.
#include <algorithm>
#include <cmath>
#include <concepts>

#include "talus/core/math.hpp"
#include "talus/core/quick_functions.hpp"

namespace talus::detail {

/// Shapes that have their radii of curvature where they touch: `bend(direction)` is the derivative
/// of their support function along a unit direction, and `largest_curvature_radius()` bounds the
/// radii.
template <class Shape>
concept has_curvatures = requires(const Shape& s, const vec3& direction) {
  { s.bend(direction) } -> std::convertible_to<mat3>;
  { s.largest_curvature_radius() } -> std::convertible_to<real>;
};

/// The radius of the sphere that presses into a plane with the same force at the same overlap as
/// two surfaces whose relative curvatures are `small` and `large`: equations 4.26 to 4.31 of
/// Johnson (Contact Mechanics, 4.2), to 1e-10 for ratios up to 1e12. With the axes of the ellipse
/// of contact in the ratio k and m = 1 - k^2, the complete elliptic integrals are K and E = K (1 -
/// m d); the ratio of the curvatures is (1 - d) / (k^2 d), and the radius pi^2 d / (2 K^2 small).
[[nodiscard]] inline real hertz_radius(real small, real large) {
  const real ratio = large / small, root = quick_cbrt(ratio);
  real k = 1 / (root * root), radius = 0;
  for (int step = 0; step < 12; ++step) {
    // By the means a and b of Gauss, which meet at pi / (2 K). The differences of their squares,
    // over m^2, add up to `sum`: d = 1/2 + m sum.
    const real m = (1 - k) * (1 + k);
    real a = (1 + k) / 2, b = std::sqrt(k), square = 1 / (16 * a * a), sum = square, weight = 1;
    while (a - b > real(1e-8) * a) {
      const real next = (a + b) / 2;
      square *= square * m * m / (16 * next * next);
      b = std::sqrt(a * b), a = next;
      weight *= 2;
      sum += weight * square;
    }
    const real mean = (a + b) / 2, d = real(0.5) + m * sum;
    radius = 2 * mean * mean * d / small;
    // A step of Newton in the logarithm of k. Its slope is between 1.5 and 2; the logarithm of r
    // and the exponential are replaced by fractions, which bound the step.
    const real r = ratio * k * k * d / (1 - d);
    const real slope = 2 - (d * d - 2 * sum) / (d * (1 - d));
    const real move = 2 * (r - 1) / ((r + 1) * slope);
    if (std::abs(move) < real(1e-10)) break;
    k = std::min(real(1), k * (2 - move) / (2 + move));
  }
  return radius;
}

/// The sum of the curvatures of two surfaces along two tangents of their contact.
class contact_curvature {
 public:
  explicit contact_curvature(const vec3& normal)
      : normal_(normal),
        t_(normal.cross(vec3::Unit(std::abs(normal[0]) < 0.6 ? 0 : 1)).normalized()),
        u_(normal.cross(t_)) {}

  /// Adds a posed body that touches with the point furthest along the normal, or against it. A
  /// shape without curvatures has `otherwise` in all directions.
  template <class Shape>
  void add(const Shape& s, const pose& at, real side, real otherwise) {
    if constexpr (has_curvatures<Shape>) {
      const quat back = at.orientation.conjugate();
      const vec3 t = back * t_, u = back * u_;
      const mat3 m = s.bend(back * vec3(side * normal_));
      const vec3 mt = m * t, mu = m * u;
      const real tt = t.dot(mt), tu = t.dot(mu), uu = u.dot(mu), square = tt * uu - tu * tu;
      tt_ += uu / square, tu_ -= tu / square, uu_ += tt / square;
    } else {
      (void)s, (void)at, (void)side;
      tt_ += otherwise, uu_ += otherwise;
    }
  }
  /// The radius of the sphere that presses into a plane with the same force at the same overlap.
  /// (Beyond a ratio of 1e12 of the curvatures, the smaller one is a rounding error.)
  [[nodiscard]] real radius() const {
    const real mean = (tt_ + uu_) / 2;
    const real half = std::sqrt((tt_ - uu_) * (tt_ - uu_) / 4 + tu_ * tu_);
    const real large = mean + half;
    return hertz_radius(std::max((tt_ * uu_ - tu_ * tu_) / large, real(1e-12) * large), large);
  }

 private:
  vec3 normal_, t_, u_;
  real tt_ = 0, tu_ = 0, uu_ = 0;
};

}  // namespace talus::detail
