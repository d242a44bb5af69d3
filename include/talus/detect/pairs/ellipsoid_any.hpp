#pragma once
// Ellipsoids with planes, spheres and each other. (The general routine gives the same contacts to
// rounding errors, at several times the cost.)
#include <algorithm>
#include <cmath>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/detail/ellipsoid_climb.hpp"
#include "talus/detect/ellipsoid_place.hpp"
#include "talus/detect/pairs/convex_convex.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

namespace detail {

/// The pair of an ellipsoid in the origin and another one, or a ball, for a search of their normal.
template <bool Ball, class Real>
[[nodiscard]] ellipsoid_climb<Real, Ball> climb_of(const ellipsoid_place<Real>& a,
                                                   const vector3<Real>& apart, Real margin) {
  ellipsoid_climb<Real, Ball> pair;
  pair.a = matrix_of(a);
  pair.apart = {apart[0], apart[1], apart[2]};
  pair.limit = margin;
  return pair;
}

/// The contact of such a pair in the frame whose origin is `origin`; false if they overlap by more
/// than `certain`, so that this is not certain to be the shallowest way out (convex_contact.hpp).
template <bool Ball, class Real, class Sink>
[[nodiscard]] bool touch_ellipsoid(ellipsoid_climb<Real, Ball>& pair, Real certain,
                                   const vec3& origin, Real margin, Sink& sink) {
  pair.search();
  if (pair.beyond) return true;
  const Real gap = pair.gap - pair.ball;
  if (!pair.summit || gap < -certain) return false;
  if (gap <= margin) {
    const vector3<Real> normal = lane(pair.normal, 0);
    const vector3<Real> both = lane(pair.on_a, 0) + lane(pair.on_b, 0);
    sink(contact_geometry{normal, origin + Real(0.5) * (both + pair.ball * normal), gap, 0});
  }
  return true;
}

}  // namespace detail

/// Calls `sink(contact_geometry)` if the gap is at most `margin`.
template <class Sink, class Real = real>
void collide(const plane& a, const pose&, const ellipsoid& b, const pose& pb, real margin,
             Sink&& sink) {
  const vector3<Real> up = a.unit_normal();
  const Real height = up.dot(pb.position) - a.offset;
  if (!(height - b.bounding_radius() <= margin)) return;
  const auto place = detail::place_of<Real>(b, pb, 0);
  const vector3<Real> mu = lane(detail::matrix_of(place).times({up[0], up[1], up[2]}), 0);
  const Real reach = std::sqrt(up.dot(mu)), gap = height - reach;
  if (!(gap <= margin)) return;
  sink(contact_geometry{-up, pb.position - mu / reach - Real(0.5) * gap * up, gap, 0});
}

/// Calls `sink(contact_geometry)` if the gap is at most `margin`.
template <class Sink, class Real = real>
void collide(const ellipsoid& a, const pose& pa, const ellipsoid& b, const pose& pb, real margin,
             Sink&& sink) {
  using vector = vector3<Real>;
  const vector apart = pb.position - pa.position;
  const Real reach = a.bounding_radius() + b.bounding_radius() + margin;
  if (!(apart.squaredNorm() <= reach * reach)) return;
  const auto in_a = detail::place_of<Real>(a, pa, 0), in_b = detail::place_of<Real>(b, pb, 0);
  auto pair = detail::climb_of<false, Real>(in_a, apart, margin);
  pair.b = detail::matrix_of(in_b);
  pair.smallest = std::min(in_a.inner, in_b.inner);
  const Real certain = detail::certain_overlap(in_a.inner, in_a.radius, in_b.inner, in_b.radius);
  if (!detail::touch_ellipsoid(pair, certain, pa.position, margin, sink))
    detail::collide_views<Real>(a, pa, b, pb, margin, sink, false);
}

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. Reads no orientation of the
/// sphere.
template <class Sink, class Real = real>
void collide(const ellipsoid& a, const pose& pa, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  using vector = vector3<Real>;
  const vector apart = pb.position - pa.position;
  const Real reach = a.bounding_radius() + b.radius + margin;
  if (!(apart.squaredNorm() <= reach * reach)) return;
  auto pair =
      detail::climb_of<true, Real>(detail::place_of<Real>(a, pa, 0), apart, margin + b.radius);
  pair.ball = b.radius;
  pair.smallest = std::min(a.inner_radius(), b.radius);
  // (A tenth of the smaller radius is below half of the larger one and a radius of curvature.)
  if (!detail::touch_ellipsoid(pair, Real(0.1) * pair.smallest, pa.position, margin, sink))
    detail::collide_views<Real>(a, pa, b, pb, margin, sink, false);
}

}  // namespace talus
