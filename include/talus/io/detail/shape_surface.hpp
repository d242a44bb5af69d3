#pragma once
// The surface of a shape as flat faces, in the frame of its body, for visualization files.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "talus/concepts.hpp"
#include "talus/core/math.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/capsule.hpp"
#include "talus/shape/cylinder.hpp"
#include "talus/shape/support_surface.hpp"

namespace talus::detail {

/// Corners of all faces one after the other, counterclockwise as seen from outside, as indices of
/// points; face k ends before corner `ends[k]`.
struct surface_faces {
  std::vector<vec3> points;
  std::vector<std::uint32_t> corners, ends;

  void clear() { points.clear(), corners.clear(), ends.clear(); }
  template <class Corners>
  void add_face(const Corners& face) {
    corners.insert(corners.end(), face.begin(), face.end());
    ends.push_back(static_cast<std::uint32_t>(corners.size()));
  }
  void add_face(std::initializer_list<std::uint32_t> face) { add_face(std::span(face)); }
};

/// Number of flat sides that approximate a round one.
inline constexpr std::uint32_t sides_of_round = 16;

/// A point of an outline that is rotated about the z axis.
struct outline_point {
  real radius, z;
};

/// The surface of revolution of an outline, from bottom to top: a flat face or a tip at each end.
void add_turned(surface_faces& out, std::span<const outline_point> outline);

// Spheres have no surface, because every viewer has a sphere. Other convex shapes are drawn by
// their support functions; a shape with a better picture has such a function in its namespace.

void add_surface(surface_faces& out, const box& b);
void add_surface(surface_faces& out, const cylinder& c);
void add_surface(surface_faces& out, const capsule& c);
/// Anything bounded by flat faces.
template <class Shape>
requires requires(const Shape& s) { s.mesh().normals; }
void add_surface(surface_faces& out, const Shape& s) {
  const auto& mesh = s.mesh();
  out.points.assign(mesh.vertices.begin(), mesh.vertices.end());
  for (std::size_t f = 0; f < mesh.faces(); ++f) out.add_face(mesh.face(f));
}
/// A surface of triangles.
template <class Shape>
requires requires(const Shape& s) { s.tree().triangles; }
void add_surface(surface_faces& out, const Shape& s) {
  const auto& tree = s.tree();
  out.points.assign(tree.vertices.begin(), tree.vertices.end());
  for (const auto& triangle : tree.triangles) out.add_face(triangle);
}

/// Any other convex shape.
template <concepts::convex_shape Shape>
requires(!Shape::isotropic && !requires(const Shape& s) {
  s.mesh().normals;
}) void add_surface(surface_faces& out, const Shape& s) {
  const support_surface drawn = surface_of_support(s);
  out.points = drawn.points;
  for (const auto& triangle : drawn.triangles) out.add_face(triangle);
}

/// Shapes whose surface can be written.
template <class Shape>
concept has_surface = requires(surface_faces& out, const Shape& s) {
  add_surface(out, s);
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/shape_surface_definitions.hpp"
#endif
