#pragma once
// features<balancing>: its state (features/balancing/balance_state.hpp). Cuts move between steps,
// when world::step() checks the shares (world/balance.hpp).
#include "talus/features/balancing/balance_state.hpp"
#include "talus/state/state.hpp"

namespace talus {

template <class Scenario>
struct balancing::state {
  detail::balance_state<typename Scenario::decomposition> balance;
};

}  // namespace talus
