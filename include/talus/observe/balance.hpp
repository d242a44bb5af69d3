#pragma once
// How evenly the ranks share the work, with features<balancing>.
#include <cstdint>

#include "talus/world/balance.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The effect of moving the cuts.
struct load_balance {
  imbalance before;         ///< the worst of those that caused a move
  imbalance after;          ///< now; time since the last move of the cuts, or from the beginning
  std::uint64_t moved = 0;  ///< number of moves
};

/// Collective. If no cuts have moved, `before` is `after`.
template <class Scenario>
[[nodiscard, gnu::cold]] load_balance measure_balance(world<Scenario>& w) {
  load_balance found;
  if constexpr (detail::require_feature<Scenario, balancing>()) {
    w.require_all_ranks("measure_balance");
    const auto& s = detail::view_of(w);
    found.after = detail::reduce_load(w.link(), detail::load_of(s, s.balance.since_move)).uneven();
    found.moved = s.balance.moved;
    found.before = found.moved > 0 ? s.balance.before : found.after;
  }
  return found;
}

}  // namespace talus
