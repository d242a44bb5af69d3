#pragma once
// One iteration of Gauss-Seidel over ranks.
#include <type_traits>

#include "talus/core/each.hpp"

namespace talus::detail {

/// Boundary contacts, simultaneously, from the velocities that both ranks hold alike.
template <class Ranks, class Lists, class State>
void relax_boundary(Lists& lists, State& s) {
  if constexpr (!std::remove_cvref_t<Ranks>::alone) {
    each_of(lists, [&](auto& list) { list.relax_boundary(s); });
    each_of(lists, [&](auto& list) { list.apply_boundary(s); });
  }
}

/// Interior contacts, one after the other. If there is `more` to come, the ranks have the
/// velocities of each other's bodies afterwards: those are sent as soon as the border is swept.
template <class Lists, class State, class Ranks>
void sweep_interior(Lists& lists, State& s, bool forward, bool more, Ranks& ranks) {
  constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
  if constexpr (!alone) {
    each_of(lists, [&](auto& list) { list.sweep_border(s, forward); });
    if (more) ranks.start_velocities();
  }
  each_of(lists, [&](auto& list) { list.sweep_inner(s, forward); });
  if constexpr (!alone)
    if (more) ranks.finish_velocities();
}

}  // namespace talus::detail
