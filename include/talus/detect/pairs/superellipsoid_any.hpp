#pragma once
// Superellipsoids with planes, spheres, ellipsoids and each other. (The general routine takes the
// other shapes. Near a point where a superellipsoid is flat it would find points less precisely.)
#include <algorithm>
#include <cmath>
#include <limits>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/detail/common_normal.hpp"
#include "talus/detect/detail/placed_superellipsoid.hpp"
#include "talus/detect/pairs/convex_convex.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/shape/superellipsoid.hpp"

namespace talus {

namespace detail {

[[nodiscard]] inline const superellipsoid& as_superellipsoid(const superellipsoid& s) { return s; }
[[nodiscard]] inline superellipsoid as_superellipsoid(const ellipsoid& e) { return {e.radii}; }
[[nodiscard]] inline superellipsoid as_superellipsoid(const sphere& s) {
  return {{s.radius, s.radius, s.radius}};
}

/// The contact of two superellipsoids, in units of the smaller one.
template <class Real>
class superellipsoid_contact {
  using vector = vector3<Real>;

 public:
  superellipsoid_contact(const superellipsoid& a, const quat& turn_a, const superellipsoid& b,
                         const quat& turn_b, const vector& apart, Real margin)
      : unit_(std::min(a.radii.maxCoeff(), b.radii.maxCoeff())),
        margin_(margin / unit_),
        smallest_(std::min(a.inner_radius(), b.inner_radius()) / unit_),
        a_(a, turn_a, vector(0, 0, 0), unit_),
        b_(b, turn_b, apart / unit_, unit_) {}

  enum class result { beyond, touching, unknown };

  /// From the centres; `unknown` if the bodies overlap so deeply that this is not certain to be the
  /// shallowest way out.
  [[nodiscard]] result search() {
    const vector start = pair_.start();
    if (!(start.squaredNorm() > 0)) return result::unknown;
    const Real size = b_.centre().norm() + smallest_;
    // Where a surface is flat, the best normal is near after a few steps, but its points are not.
    summit_of<Real> s =
        climb<Real>(pair_, start, vector::Zero(), margin_, size, Real(0.1) * smallest_);
    bool good = s.state != climbed::beyond && improve(s.at.a, s.normal, s.gap);
    if (s.state != climbed::beyond && !good) {
      s = climb<Real>(pair_, s.normal, vector::Zero(), margin_, size);
      good = s.state != climbed::beyond && improve(s.at.a, s.normal, s.gap);
    }
    if (s.state == climbed::beyond) return result::beyond;
    if (!good || gap_ < Real(-0.1) * smallest_) return result::unknown;
    return gap_ <= margin_ ? result::touching : result::beyond;
  }
  /// From a contact that the general routine has found; it stays as it is if there is no better one
  /// nearby.
  [[nodiscard]] contact_geometry improved(const contact_geometry& c, const vec3& origin) {
    const vector half = Real(0.5) * c.gap * c.normal;
    if (!improve((c.point - origin + half) / unit_, c.normal, c.gap / unit_)) return c;
    return found(origin);
  }
  [[nodiscard]] contact_geometry found(const vec3& origin) const {
    return {normal_, origin + unit_ * middle_, unit_ * gap_, 0};
  }

 private:
  [[nodiscard]] bool improve(const vector& on_a, const vector& normal, Real gap) {
    using placed = placed_superellipsoid<Real>;
    common_normal<Real, placed, placed> search(a_, a_.size(), b_, b_.size(), on_a, normal, gap);
    if (!search.find() || !(search.normal().dot(normal) > Real(0.9))) return false;
    normal_ = search.normal(), gap_ = search.gap(), middle_ = search.middle();
    if (gap_ >= 0) return true;
    // Of overlapping bodies, a normal may be worse than those around it.
    const vector t =
        normal_.cross(vector::Unit(std::abs(normal_[0]) < Real(0.6) ? 0 : 1)).normalized();
    const symmetric_2<Real> m = pair_.bend(normal_, {}, t, normal_.cross(t));
    return m.aa + gap_ > 0 && (m.aa + gap_) * (m.bb + gap_) > m.ab * m.ab;
  }

  Real unit_, margin_, smallest_;
  placed_superellipsoid<Real> a_, b_;
  superellipsoid_pair<Real> pair_{a_, b_};
  vector normal_{0, 0, 0}, middle_{0, 0, 0};
  Real gap_ = 0;
};

/// The contact of a superellipsoid with a straight edge through `on_edge` along the unit vector
/// `edge`, near the point `on_a` of its surface, in its frame: Newton's method for the point x of
/// the surface, with x = on_edge + t edge + d g, where g is the gradient of the level at x and lies
/// across the edge. Returns whether x, in `on_a`, t and d are as exact as rounding errors allow.
template <class Real>
[[nodiscard]] bool find_on_edge(const superellipsoid& s, const vector3<Real>& on_edge,
                                const vector3<Real>& edge, vector3<Real>& on_a, Real& t, Real& d) {
  using vector = vector3<Real>;
  const Real size = s.bounding_radius();
  vector x = on_a;
  surface_level l = s.level(x);
  t = edge.dot(x - on_edge);
  d = l.gradient.dot(x - on_edge - t * edge) / l.gradient.squaredNorm();
  Real last = std::numeric_limits<Real>::infinity();
  for (int k = 0; k < 60; ++k) {
    const vector g = l.gradient;
    // The inverse of 1 - d H for the second derivative H, of rank two: by its columns.
    matrix3<Real> m = matrix3<Real>::Identity();
    vector bent(0, 0, 0);  // H edge
    for (int i = 0; i < 2; ++i) {
      const vector& v = l.curvature.along[i];
      m -= d * l.curvature.factor[i] * outer(v, v);
      bent += l.curvature.factor[i] * edge.dot(v) * v;
    }
    const vector a = m.col(0), b = m.col(1), c = m.col(2);
    const Real determinant = a.dot(b.cross(c));
    if (!(determinant > 0)) return false;
    const auto solved = [&](const vector& y) {
      return vector(y.dot(b.cross(c)), y.dot(c.cross(a)), y.dot(a.cross(b))) / determinant;
    };
    const vector rest = x - on_edge - t * edge - d * g;
    const vector along = solved(edge), out = solved(g), back = solved(rest);
    const Real of_level = l.value - 1 - g.dot(back), of_slope = edge.dot(g) - bent.dot(back);
    const Real p = g.dot(along), q = g.dot(out), u = bent.dot(along), v = bent.dot(out);
    const Real minor = p * v - q * u;
    if (minor == 0) return false;
    const Real dt = (q * of_slope - v * of_level) / minor,
               dd = (u * of_level - p * of_slope) / minor;
    const vector step = dt * along + dd * out - back;
    const Real length = step.norm();
    if (!(length < Real(0.1) * size)) return false;
    x += step, t += dt, d += dd;
    l = s.level(x);
    const Real error = std::abs(edge.dot(l.gradient)) / l.gradient.norm();
    if (length < Real(1e-13) * size || (error < Real(1e-14) && !(length < last))) {
      on_a = x;
      return true;
    }
    last = length;
  }
  on_a = x;
  return true;
}

/// A contact with a box, as the general routine finds it. Where an edge of the box touches, the
/// points of that are to 1e-6 of the size: they are found again.
template <class Real>
[[nodiscard]] contact_geometry improved_on_edge(const superellipsoid& a, const pose& pa,
                                                const box& b, const pose& pb,
                                                const contact_geometry& c) {
  using vector = vector3<Real>;
  const pose turn_a{{0, 0, 0}, pa.orientation}, turn_b{{0, 0, 0}, pb.orientation};
  const vector normal = turn_b.to_body(c.normal), half = b.half();  // out of the box
  const vector on_b = pb.to_body(vector(c.point - Real(0.5) * c.gap * c.normal));
  int free = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(normal[k]) < std::abs(normal[free])) free = k;
  vector corner = half;
  for (int k = 0; k < 3; ++k)
    corner[k] = k == free ? Real(0) : (normal[k] < 0 ? -half[k] : half[k]);
  const Real size = a.bounding_radius(), near = Real(1e-4) * size;
  const vector off = on_b - corner;
  for (int k = 0; k < 3; ++k)
    if (k != free && (!(std::abs(off[k]) < near) || !(std::abs(normal[k]) > Real(1e-6)))) return c;
  if (!(std::abs(normal[free]) < Real(1e-4)) || !(std::abs(on_b[free]) < half[free])) return c;
  const vector edge = turn_a.to_body(turn_b.to_world(vector::Unit(free)));
  const vector on_edge = pa.to_body(pb.to_world(corner));
  const vector first = pa.to_body(vector(c.point + Real(0.5) * c.gap * c.normal));
  vector x = first;
  Real t = 0, d = 0;
  if (!find_on_edge<Real>(a, on_edge, edge, x, t, d)) return c;
  const vector g = a.level(x).gradient;
  const vector n = -turn_a.to_world(unit(g));
  // The same contact, and a point of the edge.
  if (!(std::abs(t) <= half[free]) || !(n.dot(c.normal) > Real(1 - 1e-4)) ||
      !((x - first).norm() < Real(0.1) * size))
    return c;
  const Real gap = -d * g.norm();
  if (!(std::abs(gap - c.gap) < Real(1e-5) * size)) return c;
  return {n, pa.to_world(x) - Real(0.5) * gap * n, gap, c.feature};
}

template <class Real, class A, class B, class Sink>
void collide_superellipsoids(const A& a, const pose& pa, const B& b, const pose& pb, Real margin,
                             Sink&& sink) {
  const vector3<Real> apart = pb.position - pa.position;
  const Real reach = a.bounding_radius() + b.bounding_radius() + margin;
  if (!(apart.squaredNorm() <= reach * reach)) return;
  constexpr bool round = B::isotropic;
  superellipsoid_contact<Real> contact(as_superellipsoid(a), pa.orientation, as_superellipsoid(b),
                                       round ? quat(1, 0, 0, 0) : pb.orientation, apart, margin);
  using result = typename superellipsoid_contact<Real>::result;
  const result found = contact.search();
  if (found == result::touching) sink(contact.found(pa.position));
  if (found != result::unknown) return;
  collide_convex(a, pa, b, pb, margin, [&](const contact_geometry& c) {
    const contact_geometry best = contact.improved(c, pa.position);
    if (best.gap <= margin) sink(best);
  });
}

}  // namespace detail

/// Calls `sink(contact_geometry)` if the gap is at most `margin`.
template <class Sink, class Real = real>
void collide(const plane& a, const pose&, const superellipsoid& b, const pose& pb, real margin,
             Sink&& sink) {
  const vector3<Real> up = a.unit_normal();
  const Real height = up.dot(pb.position) - a.offset;
  if (!(height - b.bounding_radius() <= margin)) return;
  const matrix3<Real> axes = pb.orientation.toRotationMatrix();
  const vector3<Real> lowest = axes * b.support(axes.transpose() * vector3<Real>(-up));
  const Real gap = height + up.dot(lowest);
  if (!(gap <= margin)) return;
  sink(contact_geometry{-up, pb.position + lowest - Real(0.5) * gap * up, gap, 0});
}

/// Calls `sink(contact_geometry)` if the gap is at most `margin`.
template <class Sink, class Real = real>
void collide(const superellipsoid& a, const pose& pa, const superellipsoid& b, const pose& pb,
             real margin, Sink&& sink) {
  detail::collide_superellipsoids<Real>(a, pa, b, pb, margin, sink);
}

/// Calls `sink(contact_geometry)` if the gap is at most `margin`.
template <class Sink, class Real = real>
void collide(const ellipsoid& a, const pose& pa, const superellipsoid& b, const pose& pb,
             real margin, Sink&& sink) {
  detail::collide_superellipsoids<Real>(a, pa, b, pb, margin, sink);
}

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. Reads no orientation of the
/// sphere.
template <class Sink, class Real = real>
void collide(const superellipsoid& a, const pose& pa, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  detail::collide_superellipsoids<Real>(a, pa, b, pb, margin, sink);
}

/// Calls `sink(contact_geometry)` if the gap is at most `margin`.
template <class Sink, class Real = real>
void collide(const box& a, const pose& pa, const superellipsoid& b, const pose& pb, real margin,
             Sink&& sink) {
  collide_convex(a, pa, b, pb, margin, [&](const contact_geometry& c) {
    const contact_geometry best = detail::improved_on_edge<Real>(b, pb, a, pa, c.swapped());
    if (best.gap <= margin) sink(best.swapped());
  });
}

}  // namespace talus
