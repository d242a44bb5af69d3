#pragma once
// One time step.
#include <type_traits>

#include "talus/world/detect.hpp"
#include "talus/world/driven.hpp"
#include "talus/world/energy_ledger.hpp"
#include "talus/world/last_residual.hpp"
#include "talus/world/midpoint.hpp"
#include "talus/world/migrate_and_refresh.hpp"
#include "talus/world/momentum_balance.hpp"
#include "talus/world/respond.hpp"
#include "talus/world/servo.hpp"
#include "talus/world/sleep.hpp"
#include "talus/world/soft_step.hpp"
#include "talus/world/sort_bodies.hpp"
#include "talus/world/state.hpp"
#include "talus/world/watch_leaps.hpp"

namespace talus::detail {

/// Runs a stage and adds its wall time to `total`, without the time spent in exchanges.
template <class Scenario, class Stage>
void timed(world_state<Scenario>& s, double& total, Stage&& stage) {
  const double exchanged = s.seconds.exchange;
  {
    const stage_clock clock(total);
    stage();
  }
  total -= s.seconds.exchange - exchanged;
}

template <class Scenario>
void step(world_state<Scenario>& s, real dt) {
  const auto detect_stage = [&](auto&& f) { timed(s, s.seconds.detect, f); };
  const auto respond_stage = [&](auto&& f) { timed(s, s.seconds.respond, f); };
  const auto integrate_stage = [&](auto&& f) { timed(s, s.seconds.integrate, f); };
  constexpr bool booked = watches<Scenario, energy_ledger>;
  constexpr bool watched = booked || watches<Scenario, momentum_balance>;
  constexpr bool verlet = std::is_same_v<typename Scenario::integrator, velocity_verlet>;
  constexpr bool midpoint = world_state<Scenario>::midpoint;
  s.dt = dt;
  if (s.steps % steps_between_sorts == 0) sort_bodies(s);
  notify_neighbours(s);
  constexpr bool drives = world_state<Scenario>::drives;
  if constexpr (drives) aim_driven(s);
  if constexpr (!Scenario::contact_law::soft) {
    if constexpr (watches<Scenario, energy_ledger>) open_energy(s);
    if constexpr (midpoint) integrate_stage([&] { drift_to_midpoint(s); });
    const auto find_contacts = [&] {
      if constexpr (midpoint) forget_earlier_turns(s);
      detect(s);  // contacts of local bodies with each other, copies, globals
    };
    detect_stage(find_contacts);
    if constexpr (world_state<Scenario>::sleeps)  // islands that something comes near wake
      detect_stage([&] { wake_disturbed(s, find_contacts); });
    respond_stage([&] { respond(s); });  // velocities that fulfil the contact law
    if constexpr (drives) settle_servos(s), watch_leaps(s);
    if constexpr (watches<Scenario, energy_ledger>) book_response(s);
    if constexpr (watches<Scenario, momentum_balance>) book_momentum(s);
    if constexpr (world_state<Scenario>::continuous)
      detect_stage([&] {  // until when bodies that struck something go on
        limit_flights(s, [&] { each_neighbour_pair<flight_stopper>(s); });
      });
    integrate_stage([&] { integrate(s); });  // positions of the bodies owned here
    if constexpr (drives) move_driven(s);
    if constexpr (watches<Scenario, energy_ledger>) book_motion(s);
    if constexpr (watches<Scenario, momentum_balance>) close_momentum(s);
    if constexpr (world_state<Scenario>::sleeps) integrate_stage([&] { put_to_sleep(s); });
    if constexpr (watches<Scenario, energy_ledger>) close_energy(s);
  } else if constexpr (verlet) {
    if constexpr (watched) open_soft(s);
    if constexpr (booked) survey_at_start(s);
    integrate_stage([&] { kick(s, dt / 2), drift(s, dt); });
    if constexpr (drives) move_driven(s);
    if constexpr (booked) book_migration(s, -1);
    migrate_and_refresh(s);
    if constexpr (booked) book_migration(s, 1);
    detect_stage([&] { find_close_pairs(s); });
    respond_stage([&] { measure_forces(s); });
    if constexpr (drives) push_servos(s);
    integrate_stage([&] { kick(s, dt / 2), end_forces(s); });
    if constexpr (watched) close_soft(s);
    if constexpr (booked) close_springs_as_measured(s);
  } else {
    if constexpr (watched) open_soft(s);
    detect_stage([&] { find_close_pairs(s); });
    respond_stage([&] { measure_forces(s); });  // of all overlaps with a body owned here
    if constexpr (drives) push_servos(s);
    if constexpr (booked) open_springs_as_measured(s);
    integrate_stage([&] { kick(s, dt), end_forces(s), drift(s, dt); });
    if constexpr (drives) move_driven(s);
    if constexpr (watched) close_soft(s);
  }
  s.time = s.clock.after(s.time, s.steps, 1, dt);
  ++s.steps;
  if constexpr (!verlet)
    migrate_and_refresh(s);  // bodies that left go to their new owner, shadow copies are refreshed
  if constexpr (Scenario::contact_law::soft && booked && !verlet) survey_at_end(s);
  if constexpr (watches<Scenario, residual_monitor>) (void)last_residual(s);
}

}  // namespace talus::detail
