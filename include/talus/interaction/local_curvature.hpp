#pragma once
// The radius of Hertz's theory at the contact of surfaces with two curvatures each.
#include <algorithm>
#include <cmath>
#include <concepts>

#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"

namespace talus::detail {

/// Shapes that have their radii of curvature where they touch: `bend(direction)` is the derivative
/// of their support function along a unit direction.
template <class Shape>
concept has_curvatures = requires(const Shape& s, const vec3& direction) {
  { s.bend(direction) } -> std::convertible_to<mat3>;
};

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
  /// The radius of the sphere that presses into a plane with the same force at the same overlap:
  /// the geometric mean of the two relative radii over the cube of F2 of Johnson (Contact
  /// Mechanics, 4.2), by the fit of Greenwood (1997), good to 0.3 % of the force for ratios of the
  /// radii up to 20.
  [[nodiscard]] real radius() const {
    const real mean = (tt_ + uu_) / 2;
    const real half = std::sqrt((tt_ - uu_) * (tt_ - uu_) / 4 + tu_ * tu_);
    const real small = std::max(mean - half, real(1e-12) * mean), large = mean + half;
    const real spread = portable::pow(large / small, real(0.0684)) - 1;
    const real f = 1 - (spread > 0 ? portable::pow(spread, real(1.531)) : real(0));
    return 1 / (std::sqrt(small * large) * f * f * f);
  }

 private:
  vec3 normal_, t_, u_;
  real tt_ = 0, tu_ = 0, uu_ = 0;
};

}  // namespace talus::detail
