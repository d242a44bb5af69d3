#pragma once
// Where a joint lies on its two bodies, and the rows that follow from it. All position errors are
// linear or bilinear in the points and axes that the bodies carry, so that the rows in the mean of
// two configurations give the exact difference of their errors.
#include <algorithm>
#include <cmath>

#include "talus/body/jointed_body.hpp"
#include "talus/constraint/frame_around.hpp"
#include "talus/constraint/joint_line.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// A frame fixed in each of two bodies: its origin, and its axes as a rotation from the frame of
/// the body.
struct joint_frames {
  vec3 on_a{0, 0, 0}, on_b{0, 0, 0};
  quat turn_a{1, 0, 0, 0}, turn_b{1, 0, 0, 0};
};

/// The rotation with these axes as columns: a right-handed orthonormal frame.
[[nodiscard]] inline quat rotation_of_axes(const vec3& x, const vec3& y, const vec3& z) {
  const real w = 1 + x[0] + y[1] + z[2], i = 1 + x[0] - y[1] - z[2], j = 1 - x[0] + y[1] - z[2],
             k = 1 - x[0] - y[1] + z[2];
  const real most = std::max({w, i, j, k});
  if (most == w) return quat(w, y[2] - z[1], z[0] - x[2], x[1] - y[0]).normalized();
  if (most == i) return quat(y[2] - z[1], i, y[0] + x[1], z[0] + x[2]).normalized();
  if (most == j) return quat(z[0] - x[2], y[0] + x[1], j, z[1] + y[2]).normalized();
  return quat(x[1] - y[0], z[0] + x[2], z[1] + y[2], k).normalized();
}
/// A rotation whose third axis has the direction of `axis`.
[[nodiscard]] inline quat rotation_to(const vec3& axis) {
  const mat3 rows = frame_around<real>(unit(axis));
  return rotation_of_axes(rows.row(1), rows.row(0).cross(rows.row(1)), rows.row(0));
}
/// A rotation whose third axis has the direction of `axis`, and whose first axis lies in the plane
/// of `axis` and `first`.
[[nodiscard]] inline quat rotation_to(const vec3& axis, const vec3& first) {
  const vec3 z = unit(axis), y = unit(z.cross(first));
  return rotation_of_axes(y.cross(z), y, z);
}

/// The frames of a joint that lies at `at` with the rotation `turn`, in the world.
[[nodiscard]] inline joint_frames frames_at(const vec3& at, const quat& turn, const pose& a,
                                            const pose& b) {
  return {a.to_body(at), b.to_body(at), a.orientation.conjugate() * turn,
          b.orientation.conjugate() * turn};
}

/// The frames of a joint in the world for one configuration of the bodies, or the mean of two
/// configurations.
struct joint_geometry {
  vec3 arm_a{0, 0, 0}, arm_b{0, 0, 0};  ///< from the centres of mass to the points
  vec3 gap{0, 0, 0};                    ///< from the point of b to that of a
  mat3 axes_a = mat3::Identity(), axes_b = mat3::Identity();  ///< columns
};
[[nodiscard]] inline joint_geometry geometry_of(const joint_frames& x, const pose& a,
                                                const pose& b) {
  joint_geometry g;
  g.arm_a = rotated(a.orientation, x.on_a);
  g.arm_b = rotated(b.orientation, x.on_b);
  g.gap = (a.position - b.position) + (g.arm_a - g.arm_b);
  g.axes_a = (a.orientation * x.turn_a).toRotationMatrix();
  g.axes_b = (b.orientation * x.turn_b).toRotationMatrix();
  return g;
}
[[nodiscard]] inline joint_geometry mean_of(const joint_geometry& x, const joint_geometry& y) {
  joint_geometry g;
  g.arm_a = real(0.5) * (x.arm_a + y.arm_a);
  g.arm_b = real(0.5) * (x.arm_b + y.arm_b);
  g.gap = real(0.5) * (x.gap + y.gap);
  g.axes_a = real(0.5) * (x.axes_a + y.axes_a);
  g.axes_b = real(0.5) * (x.axes_b + y.axes_b);
  return g;
}

/// Row k of a joint that holds its two points together: along axis k of the world.
[[nodiscard]] inline joint_line line_of_point(const joint_geometry& g, int k) {
  const vec3 e = vec3::Unit(k);
  joint_line x;
  x.force = e, x.moment_a = g.arm_a.cross(e), x.moment_b = g.arm_b.cross(e);
  x.error = g.gap[k];
  return x;
}
/// The way of the point of b from that of a along an axis of a.
[[nodiscard]] inline joint_line line_along(const joint_geometry& g, int axis) {
  const vec3 n = g.axes_a.col(axis);
  joint_line x;
  x.force = -n, x.moment_a = -(g.arm_a - g.gap).cross(n), x.moment_b = -g.arm_b.cross(n);
  x.error = -n.dot(g.gap);
  return x;
}
/// The cosine of the angle between an axis of a and one of b.
[[nodiscard]] inline joint_line line_of_cosine(const joint_geometry& g, int of_a, int of_b) {
  const vec3 n = g.axes_a.col(of_a), m = g.axes_b.col(of_b);
  joint_line x;
  x.moment_a = x.moment_b = n.cross(m);
  x.error = n.dot(m);
  return x;
}
/// The distance of the two points, which is to be `length`: the rate of half of its square over the
/// length.
[[nodiscard]] inline joint_line line_of_distance(const joint_geometry& g, real length) {
  joint_line x;
  x.force = (1 / length) * g.gap;
  x.moment_a = g.arm_a.cross(x.force), x.moment_b = g.arm_b.cross(x.force);
  x.error = (g.gap.squaredNorm() - length * length) / (2 * length);
  return x;
}
/// By how much the distance of the two points exceeds `length`. Without a distance there is no
/// direction, and nothing acts.
[[nodiscard]] inline joint_line line_of_elongation(const joint_geometry& g, real length) {
  joint_line x;
  x.force = unit(g.gap);
  x.moment_a = g.arm_a.cross(x.force), x.moment_b = g.arm_b.cross(x.force);
  x.error = g.gap.norm() - length;
  return x;
}
/// The rotation of b relative to a about an axis.
[[nodiscard]] inline joint_line line_of_turn(const vec3& axis) {
  joint_line x;
  x.moment_a = x.moment_b = -axis;
  return x;
}

}  // namespace talus::detail
