#pragma once
// features<residual_monitor>: the contact residual after each step.
#include "talus/state/state.hpp"
#include "talus/step/last_residual.hpp"

namespace talus {

struct residual_monitor::hooks {
  template <class Scenario>
  static void at_end(detail::world_state<Scenario>& s) {
    (void)last_residual(s);
  }
};

}  // namespace talus
