#pragma once
// features<residual_monitor>: the contact residual of each step. That of soft contacts is of the
// forces that move the bodies in the step, which exist anyway.
#include "talus/state/state.hpp"
#include "talus/step/last_residual.hpp"

namespace talus {

struct residual_monitor::hooks {
  template <class Scenario>
  static void after_solve(detail::world_state<Scenario>& s) {
    if constexpr (Scenario::contact_law::soft)
      s.convergence.add_residual(detail::unbalanced_force_of_step(s).value());
  }
  template <class Scenario>
  static void at_end(detail::world_state<Scenario>& s) {
    if constexpr (!Scenario::contact_law::soft) (void)last_residual(s);
  }
};

}  // namespace talus
