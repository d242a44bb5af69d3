#pragma once
// Fixed surfaces that lie flush beside or over each other: which contacts with one of them belong
// to the surface of all together. A contact is real if its normal is one of the union of the solids
// at its point: for a convex solid that contains the point, if no point of the solid is further
// along the normal.
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>

#include "talus/core/math.hpp"
#include "talus/shape/box.hpp"

namespace talus::detail {

/// Surfaces count as flush up to a step or a gap of this part of the sum of their bounding radii.
inline constexpr real flush_part = 1e-7;

template <class Shape>
concept is_block = std::same_as<Shape, box>;
template <class Shape>
concept is_hull = requires(const Shape& s) {
  s.mesh().normals;
  s.mesh().offsets;
};
template <class Shape>
concept is_half_space = requires(const Shape& s) {
  s.unit_normal();
  s.offset;
};
template <class Shape>
concept is_triangulated = requires(const Shape& s) {
  s.tree().triangles;
};
/// Shapes with flat faces and edges that may lie flush with others.
template <class Shape>
inline constexpr bool has_flat_faces = is_block<Shape> || is_hull<Shape> || is_triangulated<Shape>;
template <class Shape>
inline constexpr bool is_solid_beside = has_flat_faces<Shape> || is_half_space<Shape>;

// Convex solids in a frame of their own. each_face(f) calls f(normal, offset) until it returns
// false, and returns whether all returned true; support(n) is the largest n.x.

struct flat_block {
  vec3 half;
  template <class F>
  bool each_face(F&& f) const {
    for (int k = 0; k < 3; ++k)
      for (const real sign : {real(1), real(-1)}) {
        vec3 normal(0, 0, 0);
        normal[k] = sign;
        if (!f(normal, half[k])) return false;
      }
    return true;
  }
  [[nodiscard]] real support(const vec3& n) const {
    return std::abs(n[0]) * half[0] + std::abs(n[1]) * half[1] + std::abs(n[2]) * half[2];
  }
};
template <class Mesh>
struct flat_hull {
  const Mesh& mesh;
  template <class F>
  bool each_face(F&& f) const {
    for (std::size_t k = 0; k < mesh.normals.size(); ++k)
      if (!f(mesh.normals[k], mesh.offsets[k])) return false;
    return true;
  }
  [[nodiscard]] real support(const vec3& n) const { return n.dot(mesh.vertices[mesh.furthest(n)]); }
};
struct flat_half_space {
  vec3 normal;
  real offset;
  template <class F>
  bool each_face(F&& f) const {
    return f(normal, offset);
  }
  [[nodiscard]] real support(const vec3& n) const {
    const bool along = normal.dot(n) > 0 && normal.cross(n).norm() <= real(1e-6);
    return along ? offset : std::numeric_limits<real>::infinity();
  }
};
/// A triangle, and what is below it down to a depth.
struct flat_prism {
  std::array<vec3, 3> corners;
  vec3 normal;  ///< upwards, unit length
  real depth;
  template <class F>
  bool each_face(F&& f) const {
    const real top = normal.dot(corners[0]);
    if (!f(normal, top) || !f(vec3(-normal), depth - top)) return false;
    const vec3 around = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const real sign = around.dot(normal) < 0 ? -1 : 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const vec3 out = sign * (corners[(k + 1) % 3] - corners[k]).cross(normal).normalized();
      if (!f(out, out.dot(corners[k]))) return false;
    }
    return true;
  }
  [[nodiscard]] real support(const vec3& n) const {
    return std::max({n.dot(corners[0]), n.dot(corners[1]), n.dot(corners[2])}) +
           std::max(real(0), -depth * n.dot(normal));
  }
};

/// How a solid bears on a contact at the point p with the normal n: it does not contain the point,
/// or its surface has that normal there, or it covers the contact.
enum class beside { apart, agrees, covers };
template <class Solid>
[[nodiscard]] beside stands_beside(const Solid& solid, const vec3& p, const vec3& n,
                                   real tolerance) {
  if (!solid.each_face([&](const vec3& m, real offset) { return m.dot(p) - offset <= tolerance; }))
    return beside::apart;
  return solid.support(n) - n.dot(p) <= tolerance ? beside::agrees : beside::covers;
}
/// Whether a point is on the face of a solid with the normal n, or in the plane of that face, at
/// most `reach` beside the solid.
template <class Solid>
[[nodiscard]] bool is_level_with(const Solid& solid, const vec3& p, const vec3& n, real tolerance,
                                 real reach) {
  return solid.each_face([&](const vec3& m, real offset) {
    return m.dot(p) - offset <= tolerance + reach * m.cross(n).norm();
  }) && solid.support(n) - n.dot(p) <= tolerance;
}
/// Whether the point is over the faces of a solid that have about this normal, or under them.
template <class Solid>
[[nodiscard]] bool lies_over(const Solid& solid, const vec3& p, const vec3& n) {
  return solid.each_face([&](const vec3& m, real offset) {
    return m.cross(n).norm() <= real(1e-3) || m.dot(p) - offset <= 0;
  });
}
/// Whether the way from one point to another leads through the solid, deeper than the tolerance.
template <class Solid>
[[nodiscard]] bool leads_through(const Solid& solid, const vec3& from, const vec3& to,
                                 real tolerance) {
  real first = 0, last = 1;  // the part of the way that is below all faces so far
  return solid.each_face([&](const vec3& m, real offset) {
    const real start = m.dot(from) - offset + tolerance, end = m.dot(to) - offset + tolerance;
    if (start > 0 && end > 0) return false;
    if (start > 0) first = std::max(first, start / (start - end));
    if (end > 0) last = std::min(last, start / (start - end));
    return first < last;
  });
}
/// Calls f(way, q) for the points q beside p, at the distance `way` in the plane with the normal n,
/// that are just outside the solid. (A prism has no outside below: it ends there for no reason.)
template <class Solid, class F>
void each_way_out(const Solid& solid, const vec3& p, const vec3& n, real tolerance, F&& f) {
  solid.each_face([&](const vec3& m, real offset) {
    if constexpr (requires { solid.depth; })
      if (m.dot(solid.normal) < real(-0.5)) return true;
    const vec3 along = m - m.dot(n) * n;
    const real slope = along.norm();
    if (slope < real(0.1)) return true;
    const real way = (std::max(offset - m.dot(p), real(0)) + 2 * tolerance) / slope;
    f(way, vec3(p + (way / slope) * along));
    return true;
  });
}

}  // namespace talus::detail
