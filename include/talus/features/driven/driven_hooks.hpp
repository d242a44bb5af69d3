#pragma once
// features<driven>: its state (state/driven_bodies.hpp), and the stages at which it acts
// (features/driven/driven.hpp, features/driven/servo.hpp).
#include "talus/features/driven/driven.hpp"
#include "talus/features/driven/monitor_leaps.hpp"
#include "talus/features/driven/servo.hpp"
#include "talus/state/driven_bodies.hpp"
#include "talus/state/state.hpp"

namespace talus {

template <class Scenario>
struct driven::state {
  detail::driven_bodies<Scenario::shapes::size> driving;
};

struct driven::hooks {
  template <class Scenario>
  static void at_start(detail::world_state<Scenario>& s) {
    aim_driven(s);
  }
  template <class Scenario>
  static void after_solve(detail::world_state<Scenario>& s) {
    if constexpr (Scenario::contact_law::soft)
      push_servos(s);
    else
      settle_servos(s), monitor_leaps(s);
  }
  template <class Scenario>
  static void after_move(detail::world_state<Scenario>& s) {
    move_driven(s);
  }
};

}  // namespace talus
