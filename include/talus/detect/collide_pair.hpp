#pragma once
// Contact points of two posed shapes in either order. The pair functions themselves are in pairs/;
// narrow.hpp has them all.
#include <type_traits>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/contact_sink.hpp"

namespace talus {

namespace detail {
inline constexpr auto drop_contact = [](const contact_geometry&) {};

/// A pair function collide(A, pose, B, pose, margin, sink) is found, in this very order.
template <class A, class B>
concept has_pair_function = requires(const A& a, const B& b, const pose& p) {
  collide(a, p, b, p, real(0), drop_contact);
};
/// The general routine takes the two shapes, in this very order. A pair function in either order
/// is preferred to it.
template <class A, class B>
concept has_general_routine = requires(const A& a, const B& b, const pose& p) {
  collide_convex(a, p, b, p, real(0), drop_contact);
};
template <class A, class B>
concept collides_in_order = has_pair_function<A, B> ||
    (!has_pair_function<B, A> && has_general_routine<A, B>);
}  // namespace detail

/// A and B can touch: a pair function is found for one of the two orders, or the general routine
/// for convex shapes. Two planes never can.
template <class A, class B>
concept collidable = detail::collides_in_order<A, B> || detail::collides_in_order<B, A>;

/// Calls `sink(contact_geometry)` for every contact point of `a` and `b` with a gap of at most
/// `margin` (length, not negative); the normal points from b towards a. What comes out depends on
/// the arguments alone, to the bit.
template <class A, class B, class Sink>
requires collidable<A, B>
inline void collide_pair(const A& a, const pose& pa, const B& b, const pose& pb, real margin,
                         Sink&& sink) {
  constexpr bool in_order = detail::collides_in_order<A, B>;
  constexpr bool single_point = A::isotropic && B::isotropic;  // worth to be inlined
  if constexpr (!in_order) {
    const auto swapped = [&](const contact_geometry& c) { sink(c.swapped()); };
    return collide_pair(b, pb, a, pa, margin, swapped);
  } else if constexpr (!detail::has_pair_function<A, B>) {
    if constexpr (std::is_same_v<std::remove_cvref_t<Sink>, detail::contact_sink>)
      collide_convex(a, pa, b, pb, margin, sink);
    else
      collide_convex(a, pa, b, pb, margin, detail::contact_sink(sink));
  } else if constexpr (single_point ||
                       std::is_same_v<std::remove_cvref_t<Sink>, detail::contact_sink>) {
    collide(a, pa, b, pb, margin, sink);
  } else {
    const detail::contact_sink any(sink);
    collide(a, pa, b, pb, margin, any);
  }
}

}  // namespace talus
