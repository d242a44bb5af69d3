#pragma once
// Superellipsoids with planes, spheres, ellipsoids and each other. (The general routine takes the
// other shapes.)
#include <algorithm>
#include <cmath>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/detail/common_normal.hpp"
#include "talus/detect/detail/placed_superellipsoid.hpp"
#include "talus/detect/pairs/convex_convex.hpp"
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

}  // namespace talus
