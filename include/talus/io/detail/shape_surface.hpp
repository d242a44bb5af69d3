#pragma once
// The surface of a shape as flat faces, in the frame of its body, for visualization files.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/capsule.hpp"
#include "talus/shape/cylinder.hpp"

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
inline void add_turned(surface_faces& out, std::span<const outline_point> outline) {
  constexpr std::uint32_t n = sides_of_round;
  const auto ring = [&](std::uint32_t k) { return k * n; };
  const auto rings = static_cast<std::uint32_t>(outline.size());
  for (const outline_point& p : outline)
    for (std::uint32_t side = 0; side < n; ++side) {
      const real angle = 2 * pi * side / n;
      out.points.emplace_back(p.radius * std::cos(angle), p.radius * std::sin(angle), p.z);
    }
  std::vector<std::uint32_t> below, above;
  for (std::uint32_t side = 0; side < n; ++side) {
    below.push_back(n - 1 - side);
    above.push_back(ring(rings - 1) + side);
  }
  out.add_face(below);
  for (std::uint32_t k = 0; k + 1 < rings; ++k)
    for (std::uint32_t side = 0; side < n; ++side) {
      const std::uint32_t next = (side + 1) % n;
      out.add_face({ring(k) + side, ring(k) + next, ring(k + 1) + next, ring(k + 1) + side});
    }
  out.add_face(above);
}

// One function per shape; spheres have none, because every viewer has a sphere. A user-defined
// shape is drawn if its namespace contains such a function.

inline void add_surface(surface_faces& out, const box& b) {
  const vec3 half = real(0.5) * b.size;
  for (int corner = 0; corner < 8; ++corner)
    out.points.emplace_back((corner & 1) != 0 ? half[0] : -half[0],
                            (corner & 2) != 0 ? half[1] : -half[1],
                            (corner & 4) != 0 ? half[2] : -half[2]);
  out.add_face({0, 2, 3, 1});
  out.add_face({4, 5, 7, 6});
  out.add_face({0, 1, 5, 4});
  out.add_face({2, 6, 7, 3});
  out.add_face({0, 4, 6, 2});
  out.add_face({1, 3, 7, 5});
}
inline void add_surface(surface_faces& out, const cylinder& c) {
  const outline_point outline[] = {{c.radius, -c.length / 2}, {c.radius, c.length / 2}};
  add_turned(out, outline);
}
inline void add_surface(surface_faces& out, const capsule& c) {
  constexpr int steps = 4;  // from the equator of a cap almost to its pole, which is a small face
  std::vector<outline_point> outline;
  for (const int end : {-1, 1})
    for (int k = 0; k <= steps; ++k) {
      const real angle = pi / 2 * (end < 0 ? steps - k : k) / (steps + real(0.5));
      outline.push_back({c.radius * std::cos(angle),
                         static_cast<real>(end) * (c.length / 2 + c.radius * std::sin(angle))});
    }
  add_turned(out, outline);
}
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

/// Shapes whose surface can be written.
template <class Shape>
concept has_surface = requires(surface_faces& out, const Shape& s) {
  add_surface(out, s);
};

}  // namespace talus::detail
