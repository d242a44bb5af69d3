#pragma once
// A convex polyhedron and a sphere: one contact at the point of the polyhedron nearest to the
// centre. Reads no orientation of the sphere.
#include <cmath>
#include <limits>

#include "talus/contact/contact_geometry.hpp"
#include "talus/shape/convex_polyhedron.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

namespace detail {

/// The point nearest to a point outside the polyhedron, on one of the faces that face it.
template <class Real>
[[nodiscard]] vector3<Real> nearest_on_mesh(const polyhedron_mesh& m, const vector3<Real>& p) {
  using vector = vector3<Real>;
  vector nearest = p;
  Real least = std::numeric_limits<Real>::infinity();
  const auto offer = [&](const vector& x) {
    const Real square = (x - p).squaredNorm();
    if (square < least) least = square, nearest = x;
  };
  for (std::size_t f = 0; f < m.faces(); ++f) {
    const vector& n = m.normals[f];
    const Real height = n.dot(p) - m.offsets[f];
    if (height < 0 || height * height >= least) continue;
    const auto corners = m.face(f);
    bool inside = true;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const vector &from = m.vertices[corners[k]],
                   &to = m.vertices[corners[k + 1 < corners.size() ? k + 1 : 0]];
      const vector edge = to - from, x = p - from;
      if (!(edge.cross(n).dot(x) > 0)) continue;  // on the inner side of this edge
      inside = false;
      const Real t = edge.dot(x) / edge.squaredNorm();
      offer(t <= 0 ? from : t >= 1 ? to : vector(from + t * edge));
    }
    if (inside) offer(p - height * n);
  }
  return nearest;
}

}  // namespace detail

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. A centre inside leaves by the
/// nearest face.
template <class Sink, class Real = real>
void collide(const convex_polyhedron& a, const pose& pa, const sphere& b, const pose& pb,
             real margin, Sink&& sink) {
  using vector = vector3<Real>;
  const polyhedron_mesh& m = a.mesh();
  const Real reach = b.radius + margin, far = reach + a.bounding_radius();
  if (!((pa.position - pb.position).squaredNorm() <= far * far)) return;
  const vector centre = pa.to_body(pb.position);
  std::size_t face = 0;
  Real distance = -std::numeric_limits<Real>::infinity();
  for (std::size_t f = 0; f < m.faces(); ++f) {
    const Real beyond = m.normals[f].dot(centre) - m.offsets[f];
    if (beyond > distance) distance = beyond, face = f;
  }
  if (!(distance <= reach)) return;
  vector normal = m.normals[face];
  if (distance > Real(1e-9) * m.measured.half_width) {
    const vector away = centre - detail::nearest_on_mesh<Real>(m, centre);
    distance = away.norm();
    normal = away / distance;
  }
  const Real gap = distance - b.radius;
  if (!(gap <= margin)) return;
  const vector up = rotated(pa.orientation, normal);
  sink(contact_geometry{-up, pb.position - up * (b.radius + Real(0.5) * gap), gap, 0});
}

}  // namespace talus
