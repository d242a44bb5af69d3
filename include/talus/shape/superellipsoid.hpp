#pragma once
// A superellipsoid, or superquadric: between an ellipsoid, a cylinder and a box.
#include <cmath>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/portable_beta.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/convex_form.hpp"
#include "talus/shape/detail/nested_norm.hpp"

namespace talus {

/// The points with (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 <= 1, for the radii a, b and c. With
/// both exponents 2 it is an ellipsoid; larger ones make it blockier: n2 its section across the z
/// axis, n1 those through it. The exponents lie between 2 and 8: below 2 it has sharp edges, below
/// 1 it is not convex, and above 8 its edges are so narrow that a box or a cylinder is the better
/// shape.
struct superellipsoid {
  vec3 radii{1, 1, 1};  ///< semi-axes, lengths above zero
  real n1 = 2;          ///< exponent of the sections through the z axis, between 2 and 8
  real n2 = 2;          ///< exponent of the section across the z axis, between 2 and 8

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "superellipsoid";
  static constexpr const char* numbers[] = {"x radius", "y radius", "z radius", "n1", "n2"};

  /// Throws invalid_argument unless all radii are positive and between 1e-120 and 1e120, and both
  /// exponents between 2 and 8.
  void validate() const {
    detail::require_size(radii[0], "the x radius of a superellipsoid");
    detail::require_size(radii[1], "the y radius of a superellipsoid");
    detail::require_size(radii[2], "the z radius of a superellipsoid");
    if (!(n1 >= 2 && n1 <= 8) || !(n2 >= 2 && n2 <= 8))
      detail::fail<std::invalid_argument>(
          "the exponents n1 and n2 of a superellipsoid lie between 2, an ellipsoid, and 8, nearly "
          "a "
          "box, but are {} and {}: below 2 it has sharp edges; with more than 8 use a box or a "
          "cylinder. (The exponents e of other conventions are 2 / n.)",
          n1, n2);
  }

  /// Distance of its furthest point from the centre.
  [[nodiscard]] real bounding_radius() const {
    return furthest(furthest(radii[0], radii[1], n2), radii[2], n1);
  }
  /// Radius of the largest ball about the centre that is inside.
  [[nodiscard]] real inner_radius() const { return radii.minCoeff(); }
  /// Volume, by beta functions.
  [[nodiscard]] real volume() const {
    using portable::beta;
    return radii[0] * radii[1] * radii[2] * 8 / (n1 * n2) * beta(1 / n2, 1 + 1 / n2) *
           beta(1 / n1, 1 + 2 / n1);
  }
  /// Principal moments per unit mass, by beta functions.
  [[nodiscard]] vec3 inertia() const {
    using portable::beta;
    const real u = 1 / n1, v = 1 / n2, whole = beta(u, 1 + 2 * u);
    const real across = beta(3 * v, 1 + v) / beta(v, 1 + v) * beta(u, 1 + 4 * u) / whole;
    const real x = radii[0] * radii[0] * across, y = radii[1] * radii[1] * across,
               z = radii[2] * radii[2] * beta(3 * u, 1 + 2 * u) / whole;
    return {y + z, x + z, x + y};
  }
  /// Furthest point along `direction` (any length; the centre for a zero direction).
  [[nodiscard]] vec3 support(const vec3& direction) const {
    return dual(unit(direction)).gradient.cwiseProduct(radii);
  }
  /// The part of the line p + t d inside it, by at most 60 steps of Newton's method from each side,
  /// which cannot go beyond an end: the norm is convex.
  [[nodiscard]] talus::chord chord(const vec3& p, const vec3& d) const {
    const talus::chord ball = detail::chord_of_ball(p, d, bounding_radius() * real(1 + 1e-9));
    if (ball.empty()) return detail::no_chord;
    const auto reaches_end = [&](real& t, real side) {
      for (int k = 0; k < 60; ++k) {
        const surface_level at = level(p + t * d);
        const real above = at.value - 1, rise = side * at.gradient.dot(d);
        if (!(rise > 0)) return false;  // beyond the point of the line that is nearest
        // Where the surface is nearly along the line, round-off of the norm makes long steps.
        if (above <= real(1e-15)) return true;
        const real step = above / rise;
        t -= side * step;
        if (!(step > real(1e-14) * (ball.to - ball.from))) return true;
      }
      return level(p + t * d).value <= 1 + real(1e-12);
    };
    talus::chord inside = ball;
    return reaches_end(inside.from, -1) && reaches_end(inside.to, 1) ? inside : detail::no_chord;
  }
  [[nodiscard]] vec3 half_extents(const pose& at) const {
    const mat3 axes = at.orientation.toRotationMatrix();
    const auto along = [&](int i) { return dual(vec3(axes(i, 0), axes(i, 1), axes(i, 2))).value; };
    return {along(0), along(1), along(2)};
  }
  /// A bound of the radii of curvature that bend() gives.
  [[nodiscard]] real largest_curvature_radius() const { return 10 * bounding_radius(); }
  /// How the furthest point moves if a unit direction turns: the derivative of `support`, a
  /// symmetric matrix, whose eigenvalues across the direction are the two radii of curvature. Where
  /// the surface is flat, on its axes, these have no bound: they count as 10 times the bounding
  /// radius at most.
  [[nodiscard]] mat3 bend(const vec3& direction) const {
    return bending_along(direction).within(unit(direction), 10 * bounding_radius());
  }
  /// The derivative of `support` by a unit direction, without the bound of bend().
  [[nodiscard]] detail::bending bending_along(const vec3& direction) const {
    detail::bending b = dual(detail::off_the_axis(direction)).curvature;
    for (vec3& v : b.along) v = v.cwiseProduct(radii);
    return b;
  }
  /// The norm of which it is the unit ball.
  [[nodiscard]] surface_level level(const vec3& p) const {
    const detail::nested_norm n(detail::off_the_axis(p.cwiseQuotient(radii)),
                                detail::norm_exponent::of(n2), detail::norm_exponent::of(n1));
    surface_level l{n.value, n.gradient.cwiseQuotient(radii), n.curvature};
    for (vec3& v : l.curvature.along) v = v.cwiseQuotient(radii);
    return l;
  }

  friend bool operator==(const superellipsoid&, const superellipsoid&) = default;

 private:
  [[nodiscard]] detail::nested_norm dual(const vec3& d) const {
    return {d.cwiseProduct(radii), detail::norm_exponent::dual(n2),
            detail::norm_exponent::dual(n1)};
  }
  [[nodiscard]] static real furthest(real a, real b, real n) {
    if (!(n > 2)) return std::max(a, b);
    return detail::planar_norm(a, b, detail::norm_exponent::reach(n)).value;
  }
};

}  // namespace talus
