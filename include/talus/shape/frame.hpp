#pragma once
// The pose of a shape's own coordinates in the frame of its body. The two agree for a sphere or a
// box. A polyhedron or a union is given in coordinates of the user's choice, but the frame of its
// body lies at the centre of mass, along the principal axes.
#include "talus/core/math.hpp"

namespace talus {

namespace detail {

/// The pose `inner`, given in a frame that itself lies at `outer`.
[[nodiscard]] inline pose combined(const pose& outer, const pose& inner) {
  const quat &a = outer.orientation, &b = inner.orientation;
  return {outer.to_world(inner.position),
          quat(a.w() * b.w() - a.x() * b.x() - a.y() * b.y() - a.z() * b.z(),
               a.w() * b.x() + a.x() * b.w() + a.y() * b.z() - a.z() * b.y(),
               a.w() * b.y() + a.y() * b.w() + a.z() * b.x() - a.x() * b.z(),
               a.w() * b.z() + a.z() * b.w() + a.x() * b.y() - a.y() * b.x())};
}
/// The pose of the world in the frame that lies at `p`.
[[nodiscard]] inline pose inverse(const pose& p) {
  const quat back(p.orientation.w(), -p.orientation.x(), -p.orientation.y(), -p.orientation.z());
  return {rotated(back, vec3(-p.position[0], -p.position[1], -p.position[2])), back};
}
/// The product of two rotations.
[[nodiscard]] inline quat after(const quat& second, const quat& first) {
  return combined({{0, 0, 0}, second}, {{0, 0, 0}, first}).orientation;
}

}  // namespace detail

/// The frame of the body (centre of mass, principal axes) in the coordinates in which the shape was
/// given: `frame()` of the shape, or the identity if it has none.
template <class Shape>
[[nodiscard]] pose body_frame(const Shape& s) {
  if constexpr (requires { s.frame(); })
    return s.frame();
  else
    return {};
}

/// The pose of a body for which the coordinates in which its shape was given lie at `at`:
/// `const pose p = placed(wedge); body{.shape = wedge, .position = p.position, .orientation =
/// p.orientation}` puts every vertex at its given coordinates.
template <class Shape>
[[nodiscard]] pose placed(const Shape& s, const pose& at = {}) {
  return detail::combined(at, body_frame(s));
}

/// The inverse: the pose of the coordinates in which the shape was given, for a body at `body`.
template <class Shape>
[[nodiscard]] pose given_frame(const Shape& s, const pose& body) {
  return detail::combined(body, detail::inverse(body_frame(s)));
}

}  // namespace talus
