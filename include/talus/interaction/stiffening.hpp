#pragma once
// How much stiffer a body is on several contact points than on one.
#include <algorithm>

#include "talus/concepts.hpp"
#include "talus/contact/contact_geometry.hpp"
#include "talus/core/math.hpp"
#include "talus/shape/convex_form.hpp"

namespace talus::detail {

/// The largest number of corners of a face of a shape that is no surface; 1 of a sphere.
template <class Shape>
[[nodiscard]] int most_corners_of_face(const Shape& s) {
  if constexpr (Shape::isotropic) {
    return 1;
  } else if constexpr (requires { s.each_part([](const auto&, const pose&) {}); }) {
    int most = 0;
    s.each_part(
        [&](const auto& part, const pose&) { most = std::max(most, most_corners_of_face(part)); });
    return most;
  } else if constexpr (concepts::convex_shape<Shape>) {
    return std::min(form_of(s).corners(), most_corners);
  } else {
    return 4;
  }
}
/// The largest number of contact points of a shape on a plane or on faces with so many corners: two
/// faces meet in a polygon that may have the sides of both.
template <class Shape>
[[nodiscard]] int most_contact_points(const Shape& s, int of_others) {
  if constexpr (requires { s.each_part([](const auto&, const pose&) {}); }) {
    int sum = 0;
    s.each_part(
        [&](const auto& part, const pose&) { sum += most_contact_points(part, of_others); });
    return sum;
  } else {
    const int own = most_corners_of_face(s);
    return own <= 2 || of_others <= 2 ? own : std::min(own + of_others, most_corners);
  }
}

/// A bound of the square of the highest frequency of a body on that many springs, along and across
/// the normal, over that of its mass on one spring: n (1 + max (h_j^2 + h_k^2) / I_i), with half
/// extents h and moments of inertia I of unit mass about the principal axes. It is 16 for any box
/// on a plane, of which translation alone is 4. A sphere, which one spring bears, has 1.
template <class Shape>
[[nodiscard]] real stiffening(const Shape& s, int of_others) {
  if constexpr (Shape::isotropic) return 1;
  const vec3 half = s.half_extents(pose{}), inertia = s.inertia();
  real turning = 0;
  for (int i = 0; i < 3; ++i) {
    const real arms = half.squaredNorm() - half[i] * half[i];
    if (inertia[i] > 0) turning = std::max(turning, arms / inertia[i]);
  }
  return most_contact_points(s, of_others) * (1 + turning);
}

}  // namespace talus::detail
