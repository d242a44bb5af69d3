#pragma once
// Contact points of two posed shapes in either order. The pair functions themselves are in pairs/;
// narrow.hpp has them all.
#include "talus/contact/contact_geometry.hpp"

namespace talus {

namespace detail {
inline constexpr auto drop_contact = [](const contact_geometry&) {};

/// A function collide(A, pose, B, pose, margin, sink) can be found, in this very order.
template <class A, class B>
concept collides_in_order = requires(const A& a, const B& b, const pose& p) {
  collide(a, p, b, p, real(0), drop_contact);
};
}  // namespace detail

/// A and B can touch: a pair function is found for one of the two orders. Two planes never can.
template <class A, class B>
concept collidable = detail::collides_in_order<A, B> || detail::collides_in_order<B, A>;

/// Calls `sink(contact_geometry)` for every contact point of `a` and `b` with a gap of at most
/// `margin` (length, not negative); the normal points from b towards a. What comes out depends on
/// the arguments alone, to the bit.
template <class A, class B, class Sink>
requires collidable<A, B>
inline void collide_pair(const A& a, const pose& pa, const B& b, const pose& pb, real margin,
                         Sink&& sink) {
  if constexpr (detail::collides_in_order<A, B>)
    collide(a, pa, b, pb, margin, sink);
  else
    collide(b, pb, a, pa, margin, [&](const contact_geometry& c) { sink(c.swapped()); });
}

}  // namespace talus
