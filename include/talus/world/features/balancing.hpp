#pragma once
// features<balancing>: what it keeps (world/balance_state.hpp). Cuts move between steps, where
// world::step() looks (world/balance.hpp).
#include "talus/world/balance_state.hpp"
#include "talus/world/state.hpp"

namespace talus {

template <class Scenario>
struct balancing::state {
  detail::balance_state<typename Scenario::decomposition> balance;
};

}  // namespace talus
