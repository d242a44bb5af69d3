#pragma once
// A surface of triangles and a body: the contacts of the triangles near it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/detail/triangle_contact.hpp"
#include "talus/detect/level_patches.hpp"
#include "talus/detect/pairs/convex_convex.hpp"
#include "talus/detect/triangle_feature.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/shape/triangle_mesh.hpp"

namespace talus {

namespace detail {

template <class Shape>
inline constexpr bool is_surface =
    std::is_same_v<Shape, triangle_mesh> || std::is_same_v<Shape, surface_near_body>;

/// One triangle as a polyhedron without thickness.
class flat_polyhedron {
 public:
  flat_polyhedron() {
    mesh_.vertices.resize(3), mesh_.normals.resize(2), mesh_.offsets.resize(2);
    const auto fill = [](auto& to, std::initializer_list<std::uint32_t> numbers) {
      for (const std::uint32_t n : numbers) to.push_back(n);
    };
    fill(mesh_.face_begin, {0, 3, 6}), fill(mesh_.corners, {0, 1, 2, 0, 2, 1});
    fill(mesh_.corner_edges, {0, 1, 2, 2, 1, 0});
    mesh_.edges.push_back({0, 1, 0, 1});
    mesh_.edges.push_back({1, 2, 0, 1});
    mesh_.edges.push_back({2, 0, 0, 1});
    fill(mesh_.around_begin, {0, 2, 4, 6}), fill(mesh_.around, {0, 1, 0, 1, 0, 1});
  }
  /// Sets it to triangle t, relative to its centroid, which is returned.
  vec3 become(const triangle_tree& m, std::uint32_t t) {
    const vec3 &a = m.corner(t, 0), &b = m.corner(t, 1), &c = m.corner(t, 2);
    const vec3 centre = (a + b + c) / 3;
    mesh_.vertices[0] = a - centre, mesh_.vertices[1] = b - centre, mesh_.vertices[2] = c - centre;
    mesh_.normals[0] = m.normals[t], mesh_.normals[1] = -m.normals[t];
    mesh_.offsets[0] = mesh_.offsets[1] = 0;
    // The scale of tolerances: the radius of the inscribed circle.
    mesh_.measured.half_width = triangle_tree::twice_area(a, b, c).norm() /
                                ((b - a).norm() + (c - b).norm() + (a - c).norm());
    return centre;
  }
  [[nodiscard]] const polyhedron_mesh& mesh() const { return mesh_; }
  /// Whether the parts of a contact name an edge or a corner.
  [[nodiscard]] static bool is_at_edge(std::uint64_t parts) {
    const std::uint64_t own = parts & 0xffff;
    return own >= 1 && own <= 6;
  }

 private:
  polyhedron_mesh mesh_;
};

/// The point of a triangle at `p`, with the edge or the corner on which it lies within `near`.
[[nodiscard]] inline triangle_point place_on_triangle(const triangle_tree& m, std::uint32_t t,
                                                      const vec3& p, real near) {
  triangle_point q = nearest_on_triangle(p, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2));
  for (int k = 0; k < 3 && q.corner < 0; ++k)
    if ((m.corner(t, static_cast<std::size_t>(k)) - q.at).norm() <= near) q.corner = k, q.edge = -1;
  for (int k = 0; k < 3 && q.corner < 0 && q.edge < 0; ++k) {
    const vec3 &a = m.corner(t, static_cast<std::size_t>(k)),
               &b = m.corner(t, static_cast<std::size_t>((k + 1) % 3));
    const vec3 along = (b - a).normalized(), x = q.at - a;
    if ((x - along.dot(x) * along).norm() <= near) q.edge = k;
  }
  return q;
}

}  // namespace detail

/// Calls `sink(contact_geometry)` for each face, edge and corner of the surface whose point nearest
/// to the centre has a gap of at most `margin`. Reads no orientation of the sphere.
template <class A, class Sink>
requires detail::is_surface<A>
void collide(const A& a, const pose& pa, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  const detail::triangle_tree& m = a.tree();
  const vec3 centre = pa.to_body(pb.position);
  const real reach = b.radius + margin;
  const vec3 around(reach, reach, reach);
  const real close = real(1e-6) * b.radius;
  detail::sphere_feet feet(close);
  detail::triangles_near near;
  a.each_within(centre, around, b.radius, [&](std::uint32_t t) { near.add(t); });
  const auto touch = [&](std::uint32_t t, const vec3& normal, real gap) {
    const vec3 up = rotated(pa.orientation, normal);
    sink(contact_geometry{-up, pb.position - up * (b.radius + real(0.5) * gap), gap,
                          detail::feature_of(t, 0)});
  };
  near.each([&](std::uint32_t t) {
    const auto q =
        detail::nearest_on_triangle(centre, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2));
    const vec3 away = centre - q.at;
    const real distance = away.norm();
    if (!(distance <= reach)) return;
    const vec3 normal = distance > real(1e-12) * b.radius ? vec3(away / distance) : m.normals[t];
    const bool inside = q.edge < 0 && q.corner < 0;
    const real gap = distance - b.radius;
    if (!(inside || detail::nearest_of_surface(m, t, q, normal)) ||
        near.hide(m, t, q.at, normal, gap, close) ||
        (q.corner >= 0 && near.come_nearer(m, q.at, centre, close)))
      return;
    if (!feet.add({q.at, normal, gap, t, inside})) touch(t, normal, gap);
  });
  feet.each(m, touch);
}

namespace detail {
/// Distinguishes the features of two contacts of the same parts with different normals.
inline constexpr std::uint64_t another_normal = 0x80000000;
}  // namespace detail

/// Calls `sink(contact_geometry)` for the points of each triangle with a gap of at most `margin`,
/// of all triangles in one plane together up to 16. Inner edges over which the surface is flat, or
/// bends towards the body, act as the plane of their triangle.
template <class A, class B, class Sink>
requires(detail::is_surface<A>&& concepts::convex_shape<B>) void collide_convex(
    const A& a, const pose& pa, const B& b, const pose& pb, real margin, Sink&& sink) {
  const detail::triangle_tree& m = a.tree();
  const pose back = detail::inverse(pa);
  const pose there = detail::combined(back, pb);
  const real size = b.bounding_radius();
  const vec3 reach = b.half_extents(there) + vec3(margin, margin, margin);
  const auto form = detail::form_of(b);
  detail::flat_polyhedron flat;
  detail::felt_points felt(real(1e-6) * size);
  detail::level_patches level(size, m.bounding_radius);
  detail::triangles_near near;
  a.each_within(there.position, reach, size + margin, [&](std::uint32_t t) { near.add(t); });
  near.each([&](std::uint32_t t) {
    const vec3 middle = pa.to_world(flat.become(m, t));
    const detail::convex_view<real> view_a(mesh_form{&flat.mesh()},
                                           pose{vec3(0, 0, 0), pa.orientation}),
        view_b(form, pose{pb.position - middle, pb.orientation});
    detail::convex_contact<real> contact(view_a, view_b, middle, margin, true);
    const auto is_covered = [&](const detail::triangle_point& p, const vec3& direction) {
      return (p.edge >= 0 || p.corner >= 0) && !detail::nearest_of_surface(m, t, p, direction) &&
             detail::is_covered(m, t, p.at, direction, there.position);
    };
    const auto add_level = [&](const contact_geometry& c, const detail::triangle_point& q,
                               const vec3& side) {
      const contact_geometry one{c.normal, c.point, c.gap, detail::feature_of(t, c.feature)};
      const real height = side.dot(m.corner(t, 0) - there.position);
      // The nearest point of an edge or a corner has no parts; level with a face it has its normal.
      const vec3 up = rotated(pa.orientation, side);
      const bool beside = c.feature == 0 && c.normal.dot(up) > real(5e-15) - 1;
      const bool cut = (flat.is_at_edge(c.feature) || beside) && detail::goes_on_around(m, t, q);
      if (!level.add(one, up, height, cut)) sink(one);
    };
    // Whether the body leaves the plane of the triangle sooner over an edge, as the upper one of a
    // wall that reaches a little into a body above it.
    const auto leaves = [&](real gap, const vec3& at) {
      return gap < 0 && -gap > 4 * near.distance_to_bend(m, t, at);
    };
    int tilted = 0;                       // the side from which the body leans on the triangle
    std::array<std::uint64_t, 16> named;  // features of contacts with its edges and corners
    std::size_t names = 0;
    bool sideways = false;
    const bool under = m.normals[t].dot(there.position - m.corner(t, 0)) < 0;
    for (const contact_geometry& c : contact.find()) {
      const vec3 up = rotated(back.orientation, -c.normal);  // from the surface to the body
      const real straight = m.normals[t].dot(up);
      const vec3 at = back.to_world(c.point) - real(0.5) * c.gap * up;
      const auto q = detail::place_on_triangle(m, t, at, real(1e-6) * size);
      if (near.hide(m, t, q.at, up, c.gap, real(1e-6) * size)) continue;
      const bool inside = q.edge < 0 && q.corner < 0;
      if (std::abs(straight) > 1 - real(1e-8)) {
        if (!is_covered(q, up)) add_level(c, q, straight < 0 ? vec3(-m.normals[t]) : m.normals[t]);
      } else if (!inside && detail::nearest_of_surface(m, t, q, up)) {
        if (const std::uint32_t face = detail::level_beside(m, t, q, up);
            face != detail::triangle_tree::none) {
          // That face has this contact too, at a more accurate place.
          const vec3 side = m.normals[face].dot(up) < 0 ? vec3(-m.normals[face]) : m.normals[face];
          const contact_geometry one{c.normal, c.point, c.gap, detail::feature_of(t, c.feature)};
          if (!level.add(one, rotated(pa.orientation, side),
                         side.dot(m.corner(face, 0) - there.position), true))
            sink(one);
          continue;
        }
        if (!felt.add(q.at)) continue;
        named[names++ % named.size()] = c.feature;
        sink(contact_geometry{c.normal, c.point, c.gap, detail::feature_of(t, c.feature)});
      } else if ((std::abs(straight) > real(0.7) || c.gap < 0) &&
                 near.is_wide(m, t, real(0.05) * size * size)) {
        sideways = std::abs(straight) <= real(0.7);
        tilted = (sideways ? under : straight < 0) ? -1 : 1;
      } else {
        // The direction does not belong to the surface. Use the lowest point of the body, if it is
        // over this triangle.
        const vec3 side = under ? vec3(-m.normals[t]) : m.normals[t];
        const vec3 above = rotated(pa.orientation, side);
        const vec3 lowest = view_b.support(-above) - view_b.rounding() * above;
        const real gap = above.dot(lowest);
        const vec3 below = back.to_world(middle + lowest);
        const auto foot =
            detail::nearest_on_triangle(below, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2));
        if (gap <= margin && foot.edge < 0 && foot.corner < 0 && !leaves(gap, foot.at) &&
            !is_covered(detail::place_on_triangle(m, t, foot.at, real(1e-6) * size), side) &&
            felt.add(foot.at))
          sink(contact_geometry{-above, middle + lowest - real(0.5) * gap * above, gap,
                                detail::feature_of(t, 0xf)});
      }
    }
    if (tilted == 0) return;
    const vec3 side = real(tilted) * m.normals[t];
    for (contact_geometry c : contact.over_face(tilted < 0 ? 1 : 0)) {
      const auto end = named.begin() + static_cast<std::ptrdiff_t>(std::min(names, named.size()));
      if (std::find(named.begin(), end, c.feature) != end) c.feature ^= detail::another_normal;
      const vec3 at = back.to_world(c.point) - real(0.5) * c.gap * side;
      const auto q = detail::place_on_triangle(m, t, at, real(1e-6) * size);
      if (!near.hide(m, t, q.at, side, c.gap, real(1e-6) * size) && !is_covered(q, side) &&
          !(sideways && leaves(c.gap, q.at)))
        add_level(c, q, side);
    }
  });
  level.each(sink);
}

/// Immovable bodies make no contacts with each other.
template <class Sink>
void collide(const triangle_mesh&, const pose&, const triangle_mesh&, const pose&, real, Sink&&) {}
template <class Sink>
void collide(const triangle_mesh&, const pose&, const plane&, const pose&, real, Sink&&) {}

}  // namespace talus
