#pragma once
// Where a ray meets a posed shape: in closed form for the shapes of talus, by their chords; a
// convex shape of one's own is met by a point that moves (shape_cast.hpp).
#include <algorithm>
#include <cmath>

#include "talus/core/portable_powers.hpp"
#include "talus/detect/shape_cast.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/capsule.hpp"
#include "talus/shape/convex_polyhedron.hpp"
#include "talus/shape/cylinder.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/sphere.hpp"

namespace talus::detail {

// The outward normal at a point p of the surface where a ray along d comes in.
[[nodiscard]] inline vec3 normal_where(const sphere&, const vec3& p, const vec3&) {
  return unit(p);
}
[[nodiscard]] inline vec3 normal_where(const box& s, const vec3& p, const vec3& d) {
  const vec3 h = s.half();
  vec3 n = -d;
  real most = -endless;
  for (int k = 0; k < 3; ++k) {
    const real side = p[k] < 0 ? -1 : 1, beyond = std::abs(p[k]) - h[k];
    if (side * d[k] < 0 && beyond > most) most = beyond, n = side * vec3::Unit(k);
  }
  return n;
}
[[nodiscard]] inline vec3 normal_where(const capsule& s, const vec3& p, const vec3&) {
  return unit(vec3(p[0], p[1], p[2] - std::clamp(p[2], -s.length / 2, s.length / 2)));
}
[[nodiscard]] inline vec3 normal_where(const cylinder& s, const vec3& p, const vec3& d) {
  const vec3 side = unit(vec3(p[0], p[1], 0)), end(0, 0, p[2] < 0 ? -1 : 1);
  const real round = portable::hypot(p[0], p[1]) - s.radius, flat = std::abs(p[2]) - s.length / 2;
  if (!(end.dot(d) < 0)) return side;
  return !(side.dot(d) < 0) || flat > round ? end : side;
}
[[nodiscard]] inline vec3 normal_where(const ellipsoid& s, const vec3& p, const vec3&) {
  return unit(p.cwiseQuotient(s.radii).cwiseQuotient(s.radii));
}
[[nodiscard]] inline vec3 normal_where(const convex_polyhedron& s, const vec3& p, const vec3& d) {
  const polyhedron_mesh& m = s.mesh();
  vec3 n = -d;
  real most = -endless;
  for (std::size_t f = 0; f < m.faces(); ++f) {
    const real beyond = m.normals[f].dot(p) - m.offsets[f];
    if (m.normals[f].dot(d) < 0 && beyond > most) most = beyond, n = m.normals[f];
  }
  return n;
}

/// The outer normal at p of a shape whose surface is a level of a function.
template <class Shape>
[[nodiscard]] vec3 normal_where(const Shape& s, const vec3& p, const vec3&) requires requires {
  s.level(p);
}
{ return unit(s.level(p).gradient); }

template <class Shape>
concept cut_by_rays = requires(const Shape& s, const vec3& v) {
  s.chord(v, v);
  normal_where(s, v, v);
};

/// A start that is nearer to a surface than this lies on it, relative to its distance from the
/// middle of the body.
inline constexpr real start_tolerance = 2e-9;

/// What a ray meets that starts in a convex body or on its surface, of which the chord is given. A
/// start on the surface is moved out: the ray then enters the body, or leaves it and meets nothing.
template <class Shape>
[[nodiscard]] surface_hit ray_from_body(const Shape& s, const chord& given, const vec3& start,
                                        const vec3& along) {
  const chord moved = s.chord((1 + start_tolerance) * start, along);
  if (moved.empty() || !(moved.to > 0)) return {};
  if (!(moved.from > 0)) return hit_at_start(start, along);
  const real enters = std::max(given.from, real(0));
  const vec3 p = start + enters * along;
  return {enters, p, normal_where(s, p, along), false};
}

/// Where the ray meets the triangles, from either side; in the frame of the surface. A start on the
/// surface counts as in front of it, where its normals point. Whether a line
/// passes an edge on the left is decided by the numbers of its ends, alike for both triangles of
/// the edge, so no ray slips between them.
[[nodiscard]] inline surface_hit ray_meets_triangles(const triangle_tree& m, const vec3& from,
                                                     const vec3& d, real length) {
  const real middle = -from.dot(d);  // numbers of the size of the surface, for a far start
  const vec3 p = from + middle * d;
  const real round_off = real(1e-12) * (m.bounding_radius + from.norm());
  surface_hit best;
  const auto left_of = [&](std::uint32_t i, std::uint32_t j) {
    const real volume =
        d.dot(vec3(m.vertices[std::min(i, j)] - p).cross(m.vertices[std::max(i, j)] - p));
    return i < j ? volume : -volume;
  };
  each_triangle_along(m, from, d, length, vec3(0, 0, 0), [&](std::uint32_t t) {
    const auto& c = m.triangles[t];
    const real u = left_of(c[1], c[2]), v = left_of(c[2], c[0]), w = left_of(c[0], c[1]);
    const bool through = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
    const real slope = m.normals[t].dot(d);
    if (through && u + v + w != 0 && slope != 0) {
      const real way = middle + m.normals[t].dot(m.corner(t, 0) - p) / slope;
      const bool at_start = std::abs(way) <= round_off;
      if (at_start ? slope > 0 : way < 0) return std::min(length, best.distance);
      if (way <= length && way < best.distance)
        best = {std::max(way, real(0)), from + std::max(way, real(0)) * d,
                slope < 0 ? m.normals[t] : vec3(-m.normals[t]), false};
    }
    return std::min(length, best.distance);
  });
  return best;
}

/// Where a ray from a point along the unit vector d, `length` long, meets a body first.
template <class B>
[[nodiscard]] surface_hit ray_meets(const B& b, const pose& at, const vec3& from, const vec3& d,
                                    real length) {
  surface_hit best;
  if constexpr (!B::finite) {
    const real height = b.distance(from), closing = -b.unit_normal().dot(d);
    const real round_off = real(1e-12) * (from.norm() + std::abs(height));
    if (height < -round_off) return hit_at_start(from, d);
    const real way = std::max(height, real(0)) / closing;
    if (closing > 0 && way <= length) best = {way, from + way * d, b.unit_normal(), false};
    return best;
  } else {
    const chord near =
        chord_near_origin(from - at.position, d, (1 + cast_tolerance) * b.bounding_radius());
    if (near.empty() || !(near.to >= 0) || !(near.from <= length)) return best;
    if constexpr (requires { b.parts(); }) {
      b.each_part([&](const auto& part, const pose& place) {
        take_nearer(best,
                    ray_meets(part, combined(at, place), from, d, std::min(length, best.distance)));
      });
    } else if constexpr (requires { b.tree(); }) {
      const pose turn{{0, 0, 0}, at.orientation};
      best = ray_meets_triangles(b.tree(), at.to_body(from), turn.to_body(d), length);
      if (best.found())
        best.normal = turn.to_world(best.normal), best.point = from + best.distance * d;
    } else if constexpr (cut_by_rays<B>) {
      const pose turn{{0, 0, 0}, at.orientation};
      const vec3 p = turn.to_body(from - at.position), along = turn.to_body(d);
      const real middle = -p.dot(along);  // see ray_meets_triangles
      const vec3 q = p + middle * along;
      const chord c = b.chord(q, along);
      const real enters = middle + c.from, leaves = middle + c.to;
      if (c.empty() || !(leaves > 0) || !(enters <= length)) return best;
      if (enters <= start_tolerance * b.bounding_radius()) {
        const surface_hit hit = ray_from_body(b, chord{enters, leaves}, p, along);
        if (hit.inside) return hit_at_start(from, d);
        if (hit.found())
          best = {hit.distance, from + hit.distance * d, turn.to_world(hit.normal), false};
        return best;
      }
      best = {enters, from + enters * d, turn.to_world(normal_where(b, q + c.from * along, along)),
              false};
    } else {
      const auto cast = [&](const vec3& start) {
        return cast_convex(ball_form{0}, pose{start, {1, 0, 0, 0}}, form_of(b), at, d, length,
                           b.bounding_radius());
      };
      best = cast(from);
      if (best.found() && best.distance <= start_tolerance * b.bounding_radius()) {
        // As ray_from_body.
        const surface_hit moved = cast(from + start_tolerance * (from - at.position));
        if (moved.inside) return hit_at_start(from, d);
        const real way = best.distance;
        best = moved;
        if (best.found()) best.distance = way;
      }
      if (best.found()) best.point = from + best.distance * d;
    }
    return best;
  }
}

}  // namespace talus::detail
