#pragma once
// The range beyond touch of the contact law of a scenario: detection and shadow copies reach that
// much farther. Laws without range add nothing.
#include <cstddef>

#include "talus/interaction/soft_state.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

template <class Scenario>
inline constexpr bool acts_beyond_touch = requires {
  requires world_state<Scenario>::law::law::reaches;
};

/// Derives the parameters of pairs again if materials have changed, before ranges are read.
template <class Scenario>
void update_ranges(world_state<Scenario>& s) {
  if constexpr (acts_beyond_touch<Scenario>) s.soft.pairs.follow(s.materials);
}

/// The distance from its surface within which a body can act on others.
template <class Scenario, class Store>
[[nodiscard]] real acting_range(const world_state<Scenario>& s, const Store& store, std::size_t i) {
  if constexpr (acts_beyond_touch<Scenario>)
    return s.soft.pairs.range(store.material[i], widest_radius(store.shape[i]));
  else
    return (void)s, (void)store, (void)i, 0;
}

}  // namespace talus::detail
