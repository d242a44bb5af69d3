#pragma once
// Ellipsoids with planes, spheres and each other. (The general routine gives the same contacts to
// rounding errors, at several times the cost.)
#include <algorithm>
#include <cmath>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/detail/convex_climb.hpp"
#include "talus/detect/pairs/convex_convex.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

namespace detail {

/// A posed ellipsoid as the matrix M whose support point along n is M n / sqrt(n.M n).
template <class Real>
struct ellipsoid_matrix {
  vector3<Real> centre;
  matrix3<Real> m;

  ellipsoid_matrix(const ellipsoid& e, const quat& turn, const vector3<Real>& at) : centre(at) {
    const matrix3<Real> axes = turn.toRotationMatrix();
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) {
        Real sum = 0;
        for (int k = 0; k < 3; ++k) sum += axes(i, k) * axes(j, k) * (e.radii[k] * e.radii[k]);
        m(i, j) = m(j, i) = sum;
      }
  }
};

/// The difference of two ellipsoids, or of an ellipsoid and a point, for climb().
template <class Real>
struct ellipsoid_pair {
  using vector = vector3<Real>;
  const ellipsoid_matrix<Real>& a;
  const ellipsoid_matrix<Real>* b;  ///< or null, if the second body is a point
  vector other;                     ///< centre of the second body

  [[nodiscard]] difference_point<Real> at(const vector& n) const {
    const vector ma = a.m * n;
    difference_point<Real> p;
    p.a = a.centre - ma / std::sqrt(n.dot(ma));
    p.b = other;
    if (b != nullptr) {
      const vector mb = b->m * n;
      p.b += mb / std::sqrt(n.dot(mb));
    }
    p.w = p.a - p.b;
    return p;
  }
  [[nodiscard]] symmetric_2<Real> bend(const vector& n, const difference_point<Real>& p,
                                       const vector& t, const vector& u) const {
    symmetric_2<Real> sum;
    const auto add = [&](const matrix3<Real>& m, const vector& point) {
      const Real reach = std::abs(n.dot(point));
      const vector mt = m * t, mu = m * u;
      const Real pt = point.dot(t), pu = point.dot(u);
      sum.aa += (t.dot(mt) - pt * pt) / reach;
      sum.ab += (t.dot(mu) - pt * pu) / reach;
      sum.bb += (u.dot(mu) - pu * pu) / reach;
    };
    add(a.m, p.a - a.centre);
    if (b != nullptr) add(b->m, p.b - other);
    return sum;
  }
  /// A good first normal: of two balls, and of ellipsoids of one form and orientation, the best.
  [[nodiscard]] vector start(Real ball) const {
    matrix3<Real> s = a.m;
    if (b != nullptr)
      s += b->m;
    else
      for (int k = 0; k < 3; ++k) s(k, k) += ball * ball;
    const vector d = a.centre - other;
    // The direction of the inverse of s times d, by the cofactors of s.
    const vector x = s.col(0), y = s.col(1), z = s.col(2);
    return vector(y.cross(z).dot(d), z.cross(x).dot(d), x.cross(y).dot(d));
  }
};

/// The contact of an ellipsoid and another one, or a point with a ball of `rounding` around it, in
/// the frame whose origin is `origin`; false if they overlap by more than `unique`, so that this is
/// not certain to be the shallowest way out (convex_contact.hpp).
template <class Real, class Sink>
[[nodiscard]] bool touch_ellipsoid(const ellipsoid_pair<Real>& pair, Real rounding, Real smallest,
                                   Real unique, const vec3& origin, Real margin, Sink& sink) {
  using vector = vector3<Real>;
  const vector start = pair.start(rounding), between = pair.a.centre - pair.other;
  if (!(start.squaredNorm() > 0)) return false;
  const Real size = between.norm() + smallest + rounding;
  const summit_of<Real> s = climb<Real>(pair, start, vector::Zero(), margin + rounding, size);
  if (s.state == climbed::beyond) return true;
  const Real gap = s.gap - rounding;
  if (s.state == climbed::lost || gap < -unique) return false;
  if (gap <= margin)
    sink(contact_geometry{s.normal, origin + Real(0.5) * (s.at.a + s.at.b + rounding * s.normal),
                          gap, 0});
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
  const detail::ellipsoid_matrix<Real> m(b, pb.orientation, pb.position);
  const vector3<Real> mu = m.m * up;
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
  const detail::ellipsoid_matrix<Real> ma(a, pa.orientation, vector(0, 0, 0)),
      mb(b, pb.orientation, apart);
  const detail::ellipsoid_pair<Real> pair{ma, &mb, apart};
  const Real smallest = std::min(a.inner_radius(), b.inner_radius());
  const Real unique = std::min(Real(0.1) * smallest, Real(0.5) * (a.smallest_curvature_radius() +
                                                                  b.smallest_curvature_radius()));
  if (!detail::touch_ellipsoid<Real>(pair, 0, smallest, unique, pa.position, margin, sink))
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
  const detail::ellipsoid_matrix<Real> ma(a, pa.orientation, vector(0, 0, 0));
  const detail::ellipsoid_pair<Real> pair{ma, nullptr, apart};
  const Real smallest = std::min(a.inner_radius(), b.radius);
  // (A tenth of the smaller radius is below half of the larger one and a radius of curvature.)
  if (!detail::touch_ellipsoid<Real>(pair, b.radius, smallest, Real(0.1) * smallest, pa.position,
                                     margin, sink))
    detail::collide_views<Real>(a, pa, b, pb, margin, sink, false);
}

}  // namespace talus
