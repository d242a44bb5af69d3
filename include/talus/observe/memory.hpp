#pragma once
// Memory of the bodies of a world.
#include "talus/world/world.hpp"

namespace talus {

/// Bytes that this rank holds for its bodies, their shadow copies and their contacts.
template <class Scenario>
[[nodiscard, gnu::cold]] std::size_t bytes_in_use(const world<Scenario>& w) {
  const auto& s = detail::view_of(w);
  std::size_t bytes = 0;
  const auto of = [&](const auto& column) {
    bytes += column.capacity() * sizeof(typename std::remove_cvref_t<decltype(column)>::value_type);
  };
  s.each_shape([&](const auto& b) {
    b.movable.each_column(of);
    b.global.each_column(of);
    of(b.reach);
    of(b.global_reach);
    if constexpr (requires { b.places; }) of(b.places);
    bytes += b.grid.bytes() + b.global_grid.bytes();
    if constexpr (requires { b.near; })
      for (const auto& lists : b.near) bytes += lists.bytes();
  });
  s.each_constraint_list([&](const auto& list) { bytes += list.bytes(); });
  if constexpr (Scenario::contact_law::soft) {
    of(s.soft.bodies), of(s.soft.places);
    bytes += s.soft.pairs.bytes() + s.recorded.bytes();
  } else {
    of(s.solver.bodies);
    of(s.solver.shift);
    of(s.solver.turn);
    of(s.solver.gain);
    of(s.solver.drift);
    of(s.solver.tensors);
    of(s.solver.boundary_contacts);
    if constexpr (requires { s.colours.all; }) bytes += s.colours.all.bytes();
  }
  if constexpr (requires { s.choice.bodies; })
    for (const auto& bodies : s.choice.bodies) of(bodies);
  if constexpr (Scenario::template has_feature<sleeping>) bytes += s.sleep.bytes();
  if constexpr (Scenario::template has_feature<energy_ledger>) of(s.monitors.energy.mean);
  return bytes + s.found.bytes() + s.history.bytes();
}

}  // namespace talus
