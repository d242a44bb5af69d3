#pragma once
// The stages of a step of integrator<semi_implicit_euler>: velocities, then positions with them.
#include "talus/ghosts/migrate_and_refresh.hpp"
#include "talus/pairs/filtered_pairs.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"
#include "talus/step/advance.hpp"
#include "talus/step/detect.hpp"
#include "talus/step/joint_positions.hpp"
#include "talus/step/respond.hpp"
#include "talus/step/soft_step.hpp"

namespace talus {
namespace detail {

/// The stages of a step of hard contacts, from their detection on.
template <class Scenario>
void step_with_contacts(world_state<Scenario>& s) {
  timed(s, s.seconds.detect, [&] { find_contacts(s); });
  note_copies_sent(s, false);
  run_hooks<stages::after_detect>(s);
  timed(s, s.seconds.respond, [&] { respond(s); });  // velocities that satisfy the contact law
  run_hooks<stages::after_solve>(s);
  timed(s, s.seconds.integrate, [&] {
    integrate(s);  // positions of the bodies owned here
    if constexpr (world_state<Scenario>::has_joints) settle_joints(s), break_joints(s);
  });
  run_hooks<stages::after_move>(s);
  run_hooks<stages::at_close>(s);
  run_hooks<stages::before_share>(s);
  advance(s);
  migrate_and_refresh(s);  // bodies that left migrate to their new owner, and shadow copies are
                           // refreshed
  run_hooks<stages::after_share>(s);
}

/// The stages of a step of soft contacts.
template <class Scenario>
void step_with_forces(world_state<Scenario>& s) {
  run_hooks<stages::before_detect>(s);
  timed(s, s.seconds.detect, [&] { find_close_pairs(s); });
  note_copies_sent(s, false);
  run_hooks<stages::after_detect>(s);
  timed(s, s.seconds.respond, [&] { measure_forces(s); });  // of all overlaps with own bodies
  run_hooks<stages::after_solve>(s);
  timed(s, s.seconds.integrate,
        [&] { kick<forces_of::this_step>(s, s.dt, s.dt), end_forces(s), drift(s, s.dt); });
  run_hooks<stages::after_move>(s);
  run_hooks<stages::at_close>(s);
  run_hooks<stages::before_share>(s);
  advance(s);
  migrate_and_refresh(s);
  run_hooks<stages::after_share>(s);
}

}  // namespace detail

template <class Scenario>
void semi_implicit_euler::step(detail::world_state<Scenario>& s) {
  if constexpr (Scenario::contact_law::soft)
    detail::step_with_forces(s);
  else
    detail::step_with_contacts(s);
}

}  // namespace talus
