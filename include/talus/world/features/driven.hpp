#pragma once
// features<driven>: its state (world/driven_bodies.hpp), and the stages at which it acts
// (world/driven.hpp, world/servo.hpp).
#include "talus/world/driven.hpp"
#include "talus/world/driven_bodies.hpp"
#include "talus/world/servo.hpp"
#include "talus/world/state.hpp"
#include "talus/world/watch_leaps.hpp"

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
      settle_servos(s), watch_leaps(s);
  }
  template <class Scenario>
  static void after_move(detail::world_state<Scenario>& s) {
    move_driven(s);
  }
};

}  // namespace talus
