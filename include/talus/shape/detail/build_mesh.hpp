#pragma once
// From points to the mesh of their hull, in the frame of the centre of mass and the principal axes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/shape/detail/convex_hull.hpp"
#include "talus/shape/polyhedron_mesh.hpp"
#include "talus/shape/principal_axes.hpp"

namespace talus::detail {

/// Moments of the solid inside closed faces, about the point `base`: a sum over tetrahedra. The
/// covariance of one with its tip at the origin is det/120 (s s^T + a a^T + b b^T + c c^T), s = a +
/// b + c (Blow, Binstock 2004).
template <class Real>
[[nodiscard]] mass_moments<Real> moments_of_solid(const plain_vector<vector3<Real>>& points,
                                                  const hull_faces& faces,
                                                  const vector3<Real>& base) {
  mass_moments<Real> sum;
  for (const auto& face : faces)
    for (std::size_t k = 1; k + 1 < face.size(); ++k) {
      const vector3<Real> a = points[face[0]] - base, b = points[face[k]] - base,
                          c = points[face[k + 1]] - base, s = a + b + c;
      const Real det = a.dot(b.cross(c));
      sum.mass += det / 6;
      sum.first += det / 24 * s;
      sum.second += det / 120 * (outer(s, s) + outer(a, a) + outer(b, b) + outer(c, c));
    }
  return sum;
}

/// Faces, edges and sizes of a mesh whose vertices are there.
template <class Real>
void complete_mesh(polyhedron_mesh& mesh, const hull_faces& faces) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edge_of;
  std::vector<plain_vector<std::uint32_t>> around(mesh.vertices.size());
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    const auto& face = faces[f];
    if (face.size() > polyhedron_mesh::max_corners)
      fail<std::invalid_argument>(
          "a face of a convex_polyhedron has {} corners, but at most {} are possible: give fewer "
          "vertices",
          face.size(), polyhedron_mesh::max_corners);
    mesh.face_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
    vector3<Real> area = vector3<Real>::Zero();
    for (std::size_t k = 1; k + 1 < face.size(); ++k)
      area += (mesh.vertices[face[k]] - mesh.vertices[face[0]])
                  .cross(mesh.vertices[face[k + 1]] - mesh.vertices[face[0]]);
    const vector3<Real> normal = unit(area);
    Real offset = 0;
    for (std::size_t k = 0; k < face.size(); ++k) {
      const auto from = face[k], to = face[(k + 1) % face.size()];
      offset += normal.dot(mesh.vertices[from]) / Real(face.size());
      mesh.corners.push_back(from);
      around[from].push_back(f);
      const auto known = edge_of.find({to, from});
      if (known != edge_of.end()) {
        mesh.edges[known->second].right = f;
        mesh.corner_edges.push_back(known->second);
      } else {
        const auto number = static_cast<std::uint32_t>(mesh.edges.size());
        edge_of[{from, to}] = number;
        mesh.edges.push_back({from, to, f, f});
        mesh.corner_edges.push_back(number);
      }
    }
    mesh.normals.push_back(normal);
    mesh.offsets.push_back(offset);
  }
  mesh.face_begin.push_back(static_cast<std::uint32_t>(mesh.corners.size()));
  for (const auto& list : around) {
    mesh.around_begin.push_back(static_cast<std::uint32_t>(mesh.around.size()));
    mesh.around.append(list);
  }
  mesh.around_begin.push_back(static_cast<std::uint32_t>(mesh.around.size()));

  auto& m = mesh.measured;
  m.half_width = std::numeric_limits<Real>::infinity();
  m.inner_radius = *std::min_element(mesh.offsets.begin(), mesh.offsets.end());
  const point_tree<Real> tree(mesh.vertices);
  for (std::size_t f = 0; f < mesh.faces(); ++f) {
    const Real width = mesh.offsets[f] + tree.furthest(-mesh.normals[f]);
    m.half_width = std::min(m.half_width, width / 2);
  }
  m.bounding_radius = 0;
  for (const vec3& v : mesh.vertices) m.bounding_radius = std::max(m.bounding_radius, v.norm());
}

/// Multiplies lengths by a power of two, which changes no digit.
template <class Real>
void scale_mesh(polyhedron_mesh& mesh, Real by) {
  for (vec3& v : mesh.vertices) v = by * v;
  for (real& o : mesh.offsets) o *= by;
  auto& m = mesh.measured;
  m.volume *= by * by * by;
  m.bounding_radius *= by;
  m.half_width *= by;
  m.inner_radius *= by;
  m.inertia = (by * by) * m.inertia;
  m.frame.position = by * m.frame.position;
}

/// Extents of polyhedra lie between these, so that their volumes are normal numbers.
inline constexpr real smallest_extent = 1e-100, largest_extent = 1e100;

/// Throws invalid_argument if a hull of the points would be too large or too small. Returns the
/// power of two by which lengths are to be divided, so that products of them are normal numbers.
template <class Real>
[[nodiscard]] Real require_measurable(const plain_vector<vector3<Real>>& points) {
  if (points.empty()) return 1;
  vector3<Real> low = points[0], high = points[0];
  for (const auto& p : points) {
    if (!finite(p))
      fail<std::invalid_argument>(
          "the vertices of a convex_polyhedron must be finite, but one is {}", p);
    low = lower_of(low, p), high = upper_of(high, p);
  }
  Real extent = 0;
  for (int k = 0; k < 3; ++k) extent = std::max(extent, high[k] - low[k]);
  if (extent > 0 && (extent < smallest_extent || extent > largest_extent))
    fail<std::invalid_argument>(
        "the extent of a convex_polyhedron is {}, beyond what numbers can hold: sizes lie between "
        "{} "
        "and {}; choose units in which it is nearer to 1",
        extent, smallest_extent, largest_extent);
  for (const auto& p : points)
    for (int k = 0; k < 3; ++k)
      if (std::abs(p[k]) > largest_extent)
        fail<std::invalid_argument>(
            "a vertex of a convex_polyhedron is at {}, beyond {}: give coordinates nearer to the "
            "origin",
            p, largest_extent);
  return extent > 0 ? std::ldexp(Real(1), std::ilogb(extent)) : Real(1);
}

/// The thickness of the points across a plane through three that lie far apart, over their extent.
template <class Real>
[[nodiscard]] Real flatness(const plain_vector<vector3<Real>>& points) {
  const auto furthest = [&](auto&& distance) {
    return *std::max_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
      return distance(a) < distance(b);
    });
  };
  const vector3<Real> a = points[0];
  const vector3<Real> b = furthest([&](const auto& p) { return (p - a).norm(); }) - a;
  const vector3<Real> c = furthest([&](const auto& p) { return b.cross(p - a).norm(); }) - a;
  const vector3<Real> normal = b.cross(c).normalized();
  const auto height = [&](const auto& p) { return std::abs(normal.dot(p - a)); };
  return b.norm() > 0 ? height(furthest(height)) / b.norm() : 0;
}

/// Why there is no hull of the points.
template <class Real>
[[gnu::cold]] void refuse_hull(const plain_vector<vector3<Real>>& points) {
  if (points.size() < 4 || !(flatness<Real>(points) > Real(1e-5)))
    fail<std::invalid_argument>(
        "the {} vertices of a convex_polyhedron span no volume: give at least four that do not lie "
        "in one plane",
        points.size());
  fail<std::invalid_argument>(
      "the {} vertices of a convex_polyhedron lie so close to each other that its faces cannot be "
      "told apart: give fewer; corners are to be farther apart than about a hundredth of its "
      "extent where its surface is curved",
      points.size());
}

/// The mesh of the hull of `points`. Throws invalid_argument where they do not span space, are not
/// finite, are too large or too small, or are too many.
template <class Real>
[[nodiscard]] polyhedron_mesh build_mesh(const plain_vector<vector3<Real>>& given) {
  const Real scale = require_measurable<Real>(given);
  plain_vector<vector3<Real>> points;
  for (const auto& p : given) points.push_back(p / scale);
  hull_faces faces = convex_hull<Real>(points);
  if (faces.empty()) refuse_hull<Real>(points);

  // Keep the points that are corners, in the order in which they were given.
  plain_vector<std::uint32_t> number(points.size(), 0);
  for (const auto& face : faces)
    for (const auto i : face) number[i] = 1;
  plain_vector<vector3<Real>> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (number[i] != 0) {
      number[i] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(points[i]);
    }
  if (kept.size() > polyhedron_mesh::max_vertices)
    fail<std::invalid_argument>(
        "a convex_polyhedron has {} vertices, but at most {} are possible: give fewer", kept.size(),
        polyhedron_mesh::max_vertices);
  for (auto& face : faces) {
    for (auto& i : face) i = number[i];
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  }
  std::sort(faces.begin(), faces.end());

  vector3<Real> base = vector3<Real>::Zero();
  for (const auto& p : kept) base += p / Real(kept.size());
  const auto moments = moments_of_solid<Real>(kept, faces, base);
  const auto principal = moments.reduce();

  polyhedron_mesh mesh;
  mesh.measured.volume = moments.mass;
  mesh.measured.inertia = principal.inertia;
  mesh.measured.frame = {base + principal.frame.position, principal.frame.orientation};
  const matrix3<Real> turn = principal.frame.orientation.toRotationMatrix().transpose();
  for (const auto& p : kept) mesh.vertices.push_back(turn * (p - mesh.measured.frame.position));
  complete_mesh<Real>(mesh, faces);
  scale_mesh<Real>(mesh, scale);

  byte_buffer content;
  byte_writer writer(content);
  mesh.pack(writer);
  mesh.id = id_of_content(content);
  return mesh;
}

}  // namespace talus::detail
