#pragma once
// The general routine for two convex shapes. Pairs with a function of their own (two boxes, two
// capsules, spheres) do not use it.
#include <string_view>
#include <type_traits>

#include "talus/concepts.hpp"
#include "talus/detect/detail/convex_contact.hpp"

namespace talus {

namespace detail {

template <class Shape>
[[nodiscard]] constexpr std::string_view type_text() {
  return __PRETTY_FUNCTION__;
}
/// One of the two orders of each pair of shapes: by their forms, then by their names.
template <class A, class B>
inline constexpr bool convex_in_order = form_type<A>::order != form_type<B>::order
                                            ? form_type<A>::order < form_type<B>::order
                                            : type_text<A>() <= type_text<B>();

/// The contacts of two posed shapes; `climb` as of convex_contact::find().
template <class Real, class A, class B, class Sink>
void collide_views(const A& a, const pose& pa, const B& b, const pose& pb, Real margin, Sink&& sink,
                   bool climb) {
  const convex_view<Real> view_a(form_of(a), pose{vec3(0, 0, 0), pa.orientation}),
      view_b(form_of(b), pose{pb.position - pa.position, pb.orientation});
  convex_contact<Real> contact(view_a, view_b, pa.position, margin);
  for (const contact_geometry& c : contact.find(climb)) sink(c);
}

}  // namespace detail

/// Calls `sink(contact_geometry)` for the points with a gap of at most `margin`: up to 16 where a
/// flat face is involved, two where straight lines lie along each other, else one. The normal is
/// the direction of least penetration or of the nearest points; a face whose normal is as good
/// within half a percent of the smaller shape's thickness and five percent of the gap is preferred
/// (of two, that of a), so that the choice holds while a body rests. A feature names the parts of
/// the two shapes that meet; a single contact has feature 0.
template <class A, class B, class Sink, class Real = real>
requires(concepts::convex_shape<A>&& concepts::convex_shape<B>&&
             detail::convex_in_order<A, B>) void collide_convex(const A& a, const pose& pa,
                                                                const B& b, const pose& pb,
                                                                real margin, Sink&& sink) {
  const vector3<Real> apart = pb.position - pa.position;
  const Real reach = a.bounding_radius() + b.bounding_radius() + margin;
  if (!(apart.squaredNorm() <= reach * reach)) return;
  detail::collide_views<Real>(a, pa, b, pb, margin, sink, true);
}

}  // namespace talus
