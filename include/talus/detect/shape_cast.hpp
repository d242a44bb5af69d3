#pragma once
// Where a shape that moves along a straight line without turning meets a posed shape, and the point
// of a shape nearest to a point.
//
// For two convex shapes, each direction n that separates them and that they close bounds the way
// from below, by their gap along n over the part of the motion along -n. The next direction is that
// of the nearest points (the algorithm of Gilbert, Johnson and Keerthi) at the end of that way.
// This is Newton's method for the distance, which is a convex function of the way: it comes from
// below and never passes the impact (conservative advancement, Mirtich 1996; van den Bergen 2004).
#include <algorithm>
#include <cmath>

#include "talus/concepts.hpp"
#include "talus/detect/detail/convex_distance.hpp"
#include "talus/detect/detail/triangle_contact.hpp"
#include "talus/detect/surface_hit.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/sphere.hpp"

namespace talus::detail {

/// A triangle as a convex shape.
struct triangle_corners {
  vec3 at[3];
  [[nodiscard]] vec3 middle() const { return (at[0] + at[1] + at[2]) / 3; }
  [[nodiscard]] static vec3 support(const void* corners, const vec3& d) {
    const vec3* const at = static_cast<const triangle_corners*>(corners)->at;
    const vec3& other = d.dot(at[1]) > d.dot(at[0]) ? at[1] : at[0];
    return d.dot(at[2]) > d.dot(other) ? at[2] : other;
  }
};
[[nodiscard]] inline smooth_form form_of_triangle(const triangle_corners& t) {
  smooth_form f{&t, &triangle_corners::support};
  f.thickness = (t.at[0] - t.at[1]).norm();
  return f;
}

inline constexpr real cast_tolerance = 1e-9;  ///< of the two sizes: a gap that counts as none
inline constexpr int most_advances = 64;

/// Shape a moves by `length` at most along the unit vector d. `at` is the pose of b; `sizes` are
/// the bounding radii of both. `form` as form_of() gives it.
template <class FormA, class FormB, class Real = real>
[[nodiscard]] surface_hit cast_convex(const FormA& a, const pose& from, const FormB& b,
                                      const pose& at, const vec3& d, real length, real sizes) {
  using vector = vector3<Real>;
  const vector apart = from.position - at.position;
  const chord near = chord_near_origin(apart, d, (1 + cast_tolerance) * sizes);
  if (near.empty() || !(near.to >= 0) || !(near.from <= length)) return {};
  const Real start = std::max(near.from, Real(0));
  // Coordinates about b, with a where the balls around both meet: a long way costs no digits.
  const convex_view<Real> view_a(a, pose{apart + start * d, from.orientation}),
      view_b(b, pose{vec3(0, 0, 0), at.orientation});
  const Real rounding = view_a.rounding() + view_b.rounding(), close = cast_tolerance * sizes;
  Real way = 0;
  vector normal = -d;
  vector on_b = view_a.centre();
  for (int k = 0; k < most_advances; ++k) {
    const convex_pair<Real> pair{view_a, view_b, vector(way * d)};
    const vector guess = k == 0 ? view_a.centre() : normal;
    const auto found = distance_of<Real>(pair, guess, Real(1e-13) * sizes, endless);
    if (found.state != separation::apart) {
      if (k == 0 && start == 0) return hit_at_start(from.position, d);
      break;
    }
    const Real gap = found.gap - rounding;
    if (k == 0 && start == 0 && gap <= 0) return hit_at_start(from.position, d);
    const vector n = found.normal;
    // A lower bound of the gap, whose rounding errors are those of the two points alone.
    const Real bound = pair.gap_along(n) - rounding, closing = -n.dot(d);
    const bool reached = gap <= close;
    if (closing > 0 || k == 0) normal = n;  // a direction of nearly nothing may be any
    on_b = found.on_b + view_b.rounding() * normal;
    if (!(closing > 0) && (bound > 0 || k == 0) && !(reached && k > 0)) return {};
    if (reached || !(closing > 0) || !(bound > 0)) {
      if (closing > 0 && bound > 0) way += bound / closing;
      break;
    }
    // Half of the tolerance is left, so that there are nearest points and a normal.
    const Real next = way + (bound - close / 2) / closing;
    if (!(start + next <= length)) return {};
    if (!(next > way)) break;
    way = next;
  }
  if (!(start + way <= length)) return {};
  return {start + way, at.position + on_b, normal, false};
}

/// The nearer of two.
inline void take_nearer(surface_hit& best, const surface_hit& other) {
  if (other.distance < best.distance) best = other;
}

/// A posed body meets a half-space.
template <class A, class Plane>
[[nodiscard]] surface_hit cast_to_plane(const A& a, const pose& from, const Plane& b, const vec3& d,
                                        real length) {
  const vec3 up = b.unit_normal();
  const pose turn{{0, 0, 0}, from.orientation};
  const vec3 lowest = turn.to_world(a.support(turn.to_body(-up)));
  const real height = b.distance(from.position) + up.dot(lowest), closing = -up.dot(d);
  if (height <= 0) return hit_at_start(from.position, d);
  if (!(closing > 0)) return {};
  const real way = height / closing;
  if (!(way <= length)) return {};
  return {way, from.position + lowest + way * d, up, false};
}

/// Where shape a, which moves by `length` at most along the unit vector d from its pose, meets b.
/// Neither a nor a part of it is a surface of triangles.
template <class A, class B>
[[nodiscard]] surface_hit shape_meets(const A& a, const pose& from, const B& b, const pose& at,
                                      const vec3& d, real length) {
  surface_hit best;
  if constexpr (!B::finite) {
    best = cast_to_plane(a, from, b, d, length);
  } else if constexpr (requires { a.parts(); }) {
    a.each_part([&](const auto& part, const pose& place) {
      const pose here = combined(from, place);
      surface_hit hit = shape_meets(part, here, b, at, d, std::min(length, best.distance));
      if (hit.inside) hit.point = from.position;
      take_nearer(best, hit);
    });
  } else if constexpr (requires { b.parts(); }) {
    b.each_part([&](const auto& part, const pose& place) {
      take_nearer(best, shape_meets(a, from, part, combined(at, place), d,
                                    std::min(length, best.distance)));
    });
  } else if constexpr (requires { b.tree(); }) {
    const triangle_tree& m = b.tree();
    const pose back = inverse(at), here = combined(back, from);
    const vec3 way = rotated(back.orientation, d);
    each_triangle_along(m, here.position, way, length, a.half_extents(here), [&](std::uint32_t t) {
      const triangle_corners corners{{m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)}};
      const vec3 middle = corners.middle();
      const triangle_corners centred{
          {corners.at[0] - middle, corners.at[1] - middle, corners.at[2] - middle}};
      const real size =
          std::max({centred.at[0].norm(), centred.at[1].norm(), centred.at[2].norm()});
      surface_hit hit =
          cast_convex(form_of(a), here, form_of_triangle(centred), pose{middle, {1, 0, 0, 0}}, way,
                      std::min(length, best.distance), a.bounding_radius() + size);
      if (hit.found()) {
        hit.point = hit.inside ? from.position : at.to_world(hit.point);
        hit.normal = hit.inside ? vec3(-d) : rotated(at.orientation, hit.normal);
      }
      take_nearer(best, hit);
      return std::min(length, best.distance);
    });
  } else {
    best = cast_convex(form_of(a), from, form_of(b), at, d, length,
                       a.bounding_radius() + b.bounding_radius());
  }
  return best;
}

/// The point of a body nearest to p, if its distance is at most `within`; p itself in the body.
template <class B>
[[nodiscard]] surface_hit nearest_on_shape(const B& b, const pose& at, const vec3& p, real within) {
  const auto inside = [&] { return surface_hit{0, p, vec3(0, 0, 0), true}; };
  surface_hit best;
  if constexpr (!B::finite) {
    const vec3 up = b.unit_normal();
    const real height = b.distance(p);
    if (height <= 0) return inside();
    if (height <= within) best = {height, p - height * up, up, false};
  } else if constexpr (requires { b.parts(); }) {
    b.each_part([&](const auto& part, const pose& place) {
      take_nearer(best,
                  nearest_on_shape(part, combined(at, place), p, std::min(within, best.distance)));
    });
  } else if constexpr (requires { b.tree(); }) {
    const triangle_tree& m = b.tree();
    const vec3 local = at.to_body(p);
    each_triangle_near(m, local, within, [&](std::uint32_t t) {
      const vec3 q = nearest_on_triangle(local, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)).at;
      const vec3 away = local - q;
      const real distance = away.norm();
      if (distance <= within && distance < best.distance)
        best = {distance, q, distance > 0 ? vec3(away / distance) : m.normals[t], false};
      return std::min(within, best.distance);
    });
    if (best.found())
      best.point = at.to_world(best.point), best.normal = rotated(at.orientation, best.normal);
  } else {
    const vec3 apart = p - at.position;
    const real size = b.bounding_radius();
    if (apart.norm() - size > within) return best;
    const convex_view<real> point(ball_form{0}, pose{apart, {1, 0, 0, 0}}),
        body(form_of(b), pose{vec3(0, 0, 0), at.orientation});
    const convex_pair<real> pair{point, body};
    const auto found = distance_of<real>(pair, apart, real(1e-13) * size, endless);
    if (found.state != separation::apart || found.gap <= body.rounding()) return inside();
    const real gap = found.gap - body.rounding();
    if (gap <= within)
      best = {gap, at.position + found.on_b + body.rounding() * found.normal, found.normal, false};
  }
  return best;
}

}  // namespace talus::detail
