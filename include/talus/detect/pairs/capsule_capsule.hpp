#pragma once
// Capsules with spheres and with each other: distances of points and segments.
#include <algorithm>
#include <cmath>

#include "talus/contact/contact_geometry.hpp"
#include "talus/shape/capsule.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

namespace detail {

/// The contact of two balls around the points p and q; `across` is the normal where they coincide.
template <class Real>
[[nodiscard]] contact_geometry contact_of_balls(const vector3<Real>& p, Real radius_p,
                                                const vector3<Real>& q, Real radius_q,
                                                const vector3<Real>& across,
                                                std::uint32_t feature) {
  const vector3<Real> d = p - q;
  const Real square = d.squaredNorm(), distance = std::sqrt(square);
  const vector3<Real> normal = square > Real(1e-200) ? vector3<Real>(d / distance) : across;
  const Real gap = distance - radius_p - radius_q;
  return {normal, q + (radius_q + Real(0.5) * gap) * normal, gap, feature};
}

/// A unit vector across a unit vector.
template <class Real>
[[nodiscard]] vector3<Real> any_across(const vector3<Real>& axis) {
  return axis.cross(vector3<Real>::Unit(std::abs(axis[0]) < Real(0.6) ? 0 : 1)).normalized();
}

}  // namespace detail

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. Reads no orientation of the
/// sphere.
template <class Sink, class Real = real>
void collide(const capsule& a, const pose& pa, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  const vector3<Real> axis = rotated(pa.orientation, vec3(0, 0, 1));
  const Real half = a.length / 2;
  const Real along = std::clamp<Real>(axis.dot(pb.position - pa.position), -half, half);
  const contact_geometry c =
      detail::contact_of_balls<Real>(pa.position + along * axis, a.radius, pb.position, b.radius,
                                     detail::any_across<Real>(axis), 0);
  if (c.gap <= margin) sink(c);
}

/// Calls `sink(contact_geometry)` for the points with a gap of at most `margin`: that of the
/// nearest points (feature 0), but capsules side by side, parallel within six degrees, have one at
/// each end of their common length instead, unless the nearest points are between and clearly
/// nearer.
template <class Sink, class Real = real>
void collide(const capsule& a, const pose& pa, const capsule& b, const pose& pb, real margin,
             Sink&& sink) {
  using vector = vector3<Real>;
  const vector u = rotated(pa.orientation, vec3(0, 0, 1)),
               v = rotated(pb.orientation, vec3(0, 0, 1)), d = pb.position - pa.position;
  const Real ha = a.length / 2, hb = b.length / 2, reach = ha + hb + a.radius + b.radius + margin;
  if (!(d.squaredNorm() <= reach * reach)) return;
  const Real uv = u.dot(v), du = d.dot(u), dv = d.dot(v), square = u.cross(v).squaredNorm();
  const auto on_a = [&](Real t) { return std::clamp(du + uv * t, -ha, ha); };  // nearest to b at t
  const auto on_b = [&](Real s) { return std::clamp(uv * s - dv, -hb, hb); };
  const vector across =
      square > Real(1e-12) ? u.cross(v).normalized() : detail::any_across<Real>(u);
  const auto contact_at = [&](Real s, Real t, std::uint32_t feature) {
    return detail::contact_of_balls<Real>(pa.position + s * u, a.radius, pb.position + t * v,
                                          b.radius, across, feature);
  };

  // Nearest points of the lines, drawn back onto the segments one after the other (Ericson 2004,
  // 5.1.9); of parallel ones, the middle of their common length.
  Real s;
  if (square > Real(1e-12)) {
    s = std::clamp((du - uv * dv) / square, -ha, ha);
  } else {
    const Real low = std::max(-ha, du - hb), high = std::min(ha, du + hb);
    s = std::clamp((low + high) / 2, -ha, ha);
  }
  const Real t = on_b(s);
  s = on_a(t);
  const contact_geometry nearest = contact_at(s, t, 0);
  if (!(nearest.gap <= margin)) return;

  // The common length on a, between the feet of the ends of b.
  const Real middle = du, half = hb * std::abs(uv);
  const Real low = std::max(-ha, middle - half), high = std::min(ha, middle + half);
  const Real smaller = std::min(a.radius, b.radius);
  if (square < Real(0.01) && high - low > Real(0.01) * smaller) {
    const auto end = [&](Real at, bool far) {
      const bool own = far ? at == ha : at == -ha;
      const Real other = own ? on_b(at) : std::clamp((at - du) / uv, -hb, hb);
      return contact_at(at, other, 1u + 2 * own + far);
    };
    const contact_geometry first = end(low, false), second = end(high, true);
    if (std::min(first.gap, second.gap) <= nearest.gap + Real(1e-3) * smaller) {
      if (first.gap <= margin) sink(first);
      if (second.gap <= margin) sink(second);
      return;
    }
  }
  sink(nearest);
}

}  // namespace talus
