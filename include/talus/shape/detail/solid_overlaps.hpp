#pragma once
// Volume and moments of what a convex solid with flat faces shares with others: the solid is
// clipped by their faces, and what several share counts once by inclusion and exclusion.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/principal_axes.hpp"

namespace talus::detail {

/// The points x with normal . x <= offset.
struct face_plane {
  vec3 normal;
  real offset;
};
/// Corners of a face, counterclockwise as seen from outside.
using solid_face = std::vector<vec3>;
using solid = std::vector<solid_face>;

template <class Shape>
inline constexpr bool is_box = std::is_same_v<Shape, box>;
/// Whether it is a box or a polyhedron.
template <class Shape>
inline constexpr bool is_flat_solid = is_box<Shape> || requires(const Shape& s) {
  s.mesh().face(0);
  s.mesh().normals;
};

/// The faces of a box or a polyhedron in its frame.
template <class Shape>
[[nodiscard]] solid solid_of(const Shape& s) {
  solid faces;
  if constexpr (is_box<Shape>) {
    const vec3 half = real(0.5) * s.size;
    for (int axis = 0; axis < 3; ++axis)
      for (const real side : {-1., 1.}) {
        solid_face face;
        // The other two axes in the order that turns counterclockwise about the normal.
        const int i = side > 0 ? (axis + 1) % 3 : (axis + 2) % 3, j = 3 - axis - i;
        for (int corner = 0; corner < 4; ++corner) {
          const real u = corner == 1 || corner == 2 ? 1 : -1, v = corner > 1 ? 1 : -1;
          vec3 p(0, 0, 0);
          p[axis] = side * half[axis], p[i] = u * half[i], p[j] = v * half[j];
          face.push_back(p);
        }
        faces.push_back(std::move(face));
      }
  } else {
    const auto& mesh = s.mesh();
    for (std::size_t f = 0; f < mesh.faces(); ++f) {
      solid_face face;
      for (const auto corner : mesh.face(f)) face.push_back(mesh.vertices[corner]);
      faces.push_back(std::move(face));
    }
  }
  return faces;
}
/// The planes of the faces of a box or a polyhedron at a pose.
template <class Shape>
[[nodiscard]] std::vector<face_plane> face_planes_of(const Shape& s, const pose& at) {
  std::vector<face_plane> all;
  const auto add = [&](const vec3& normal, real offset) {
    const vec3 n = rotated(at.orientation, normal);
    all.push_back({n, offset + n.dot(at.position)});
  };
  if constexpr (is_box<Shape>) {
    for (int axis = 0; axis < 3; ++axis)
      for (const real side : {-1., 1.}) add(side * vec3::Unit(axis), s.size[axis] / 2);
  } else {
    for (std::size_t f = 0; f < s.mesh().faces(); ++f)
      add(s.mesh().normals[f], s.mesh().offsets[f]);
  }
  return all;
}

/// The part of a convex solid behind a face; points within `slack` of its plane are in it.
[[nodiscard]] inline solid clipped(const solid& given, const face_plane& by, real slack) {
  const auto height = [&](const vec3& p) { return by.normal.dot(p) - by.offset; };
  bool cuts = false;
  for (const solid_face& face : given)
    for (const vec3& p : face) cuts = cuts || height(p) > slack;
  if (!cuts) return given;
  solid rest;
  solid_face lid;
  for (const solid_face& face : given) {
    solid_face kept;
    for (std::size_t k = 0; k < face.size(); ++k) {
      const vec3 &p = face[k], &q = face[(k + 1) % face.size()];
      const real of_p = height(p), of_q = height(q);
      const bool in_p = of_p <= slack, in_q = of_q <= slack;
      if (in_p) kept.push_back(p);
      if (in_p && of_p >= -slack) lid.push_back(p);
      if (in_p != in_q) {
        const real t = std::clamp(of_p / (of_p - of_q), real(0), real(1));
        const vec3 cut = p + t * (q - p);
        kept.push_back(cut), lid.push_back(cut);
      }
    }
    if (kept.size() > 2) rest.push_back(std::move(kept));
  }
  if (rest.empty() || lid.size() < 3) return rest;
  // The corners of the lid, several times each, by their angle about the middle.
  vec3 middle(0, 0, 0);
  for (const vec3& p : lid) middle += p / real(lid.size());
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(by.normal[k]) < std::abs(by.normal[least])) least = k;
  const vec3 e = unit(by.normal.cross(vec3::Unit(least))), f = by.normal.cross(e);
  std::vector<std::pair<real, vec3>> sorted;
  for (const vec3& p : lid)
    sorted.emplace_back(portable::atan2(f.dot(p - middle), e.dot(p - middle)), p);
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& x, const auto& y) { return x.first < y.first; });
  for (std::size_t k = 0; k < lid.size(); ++k) lid[k] = sorted[k].second;
  rest.push_back(std::move(lid));
  return rest;
}

/// Moments of a solid about the origin: those of the tetrahedra over its faces, as in
/// moments_of_solid(). The triangles of a face meet in its middle.
template <class Real>
[[nodiscard]] mass_moments<Real> moments_of_faces(const solid& faces) {
  mass_moments<Real> sum;
  for (const solid_face& face : faces) {
    vector3<Real> a(0, 0, 0);
    for (const vec3& p : face) a += p / Real(face.size());
    for (std::size_t k = 0; k < face.size(); ++k) {
      const vector3<Real> b = face[k], c = face[(k + 1) % face.size()], s = a + b + c;
      const Real det = a.dot(b.cross(c));
      sum.mass += det / 6;
      sum.first += det / 24 * s;
      sum.second += det / 120 * (outer(s, s) + outer(a, a) + outer(b, b) + outer(c, c));
    }
  }
  return sum;
}

/// Adds, with a sign, what a solid shares with any of the others from number `first` on.
template <class Real>
void add_shared_by_solids(const solid& one, const std::vector<std::vector<face_plane>>& others,
                          std::size_t first, Real sign, real slack, mass_moments<Real>& sum) {
  for (std::size_t n = first; n < others.size(); ++n) {
    solid both = one;
    for (const face_plane& h : others[n]) {
      both = clipped(both, h, slack);
      if (both.size() < 4) break;
    }
    if (both.size() < 4) continue;
    mass_moments<Real> m = moments_of_faces<Real>(both);
    m.mass *= sign, m.first *= sign, m.second *= sign;
    sum += m;
    add_shared_by_solids<Real>(both, others, n + 1, -sign, slack, sum);
  }
}

}  // namespace talus::detail
