#pragma once
// The stages of a step of integrator<velocity_verlet>: bodies are shared between its halves, so
// that forces are computed after all ranks have the new positions.
#include "talus/ghosts/migrate_and_refresh.hpp"
#include "talus/ghosts/velocities_of_owners.hpp"
#include "talus/pairs/filtered_pairs.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"
#include "talus/step/advance.hpp"
#include "talus/step/soft_step.hpp"

namespace talus {
namespace detail {

/// Whether user-defined features see shadow copies between the end of a step and the next refresh.
template <class Scenario>
inline constexpr bool acts_after_refresh =
    !world_state<Scenario>::link_type::alone &&
    (has_own_hook<stages::at_close, Scenario> || has_own_hook<stages::at_end, Scenario> ||
     has_own_hook<stages::at_start, Scenario>);

}  // namespace detail

template <class Scenario>
void velocity_verlet::step(detail::world_state<Scenario>& s) {
  using namespace detail;
  timed(s, s.seconds.integrate,
        [&] { kick<forces_of::last_step>(s, s.dt / 2, s.dt), drift(s, s.dt); });
  run_hooks<stages::after_move>(s);
  run_hooks<stages::before_share>(s);
  migrate_and_refresh(s);
  note_copies_sent(s, true);
  run_hooks<stages::after_share>(s);
  run_hooks<stages::before_detect>(s);
  timed(s, s.seconds.detect, [&] { find_close_pairs(s); });
  note_copies_sent(s, false);
  run_hooks<stages::after_detect>(s);
  timed(s, s.seconds.respond, [&] { measure_forces(s); });
  run_hooks<stages::after_solve>(s);
  timed(s, s.seconds.integrate, [&] { kick<forces_of::this_step>(s, s.dt / 2, 0), end_forces(s); });
  if constexpr (acts_after_refresh<Scenario>) {
    const stage_clock clock(s.seconds.exchange);
    refresh_velocities(s);
  }
  run_hooks<stages::at_close>(s);
  advance(s);
}

}  // namespace talus
