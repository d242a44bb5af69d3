#pragma once
// Boxes, capsules, cylinders and convex polyhedra with each other, except for the pairs with a
// special routine (two boxes, two capsules).
#include <type_traits>

#include "talus/detect/detail/convex_contact.hpp"

namespace talus {

namespace detail {

/// Rank of a shape in the order in which pairs are computed; 0 for other shapes.
template <class Shape>
inline constexpr int convex_rank = std::is_same_v<Shape, box>                 ? 1
                                   : std::is_same_v<Shape, capsule>           ? 2
                                   : std::is_same_v<Shape, cylinder>          ? 3
                                   : std::is_same_v<Shape, convex_polyhedron> ? 4
                                                                              : 0;
template <class A, class B>
inline constexpr bool convex_in_order = convex_rank<A> > 0 &&
                                        (convex_rank<A> < convex_rank<B> ||
                                         (convex_rank<A> == convex_rank<B> && convex_rank<A> > 2));

}  // namespace detail

/// Calls `sink(contact_geometry)` for the points with a gap of at most `margin`: up to 16 where a
/// flat face is involved, two where straight lines lie along each other, else one. The normal is
/// the direction of least penetration or of the nearest points; a face whose normal is as good
/// within half a percent of the smaller shape's thickness and five percent of the gap is preferred
/// (of two, that of a), so that the choice holds while a body rests. A feature names the parts of
/// the two shapes that meet; a single contact has feature 0.
template <class A, class B, class Sink, class Real = real>
requires(detail::convex_in_order<A, B>) void collide(const A& a, const pose& pa, const B& b,
                                                     const pose& pb, real margin, Sink&& sink) {
  const vector3<Real> apart = pb.position - pa.position;
  const Real reach = a.bounding_radius() + b.bounding_radius() + margin;
  if (!(apart.squaredNorm() <= reach * reach)) return;
  const detail::convex_view<Real> view_a(a, pose{vec3(0, 0, 0), pa.orientation}),
      view_b(b, pose{apart, pb.orientation});
  detail::convex_contact<Real> contact(view_a, view_b, pa.position, margin);
  for (const contact_geometry& c : contact.find()) sink(c);
}

}  // namespace talus
