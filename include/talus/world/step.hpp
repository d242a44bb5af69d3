#pragma once
// One time step.
#include "talus/world/detect.hpp"
#include "talus/world/energy_ledger.hpp"
#include "talus/world/hand_over.hpp"
#include "talus/world/last_residual.hpp"
#include "talus/world/momentum_balance.hpp"
#include "talus/world/respond.hpp"
#include "talus/world/state.hpp"

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
  s.dt = dt;
  announce_changes(s);
  if constexpr (watches<Scenario, energy_ledger>) open_energy(s);
  timed(s, s.seconds.detect, [&] {
    detect(s);  // contacts of local bodies with each other, with shadow copies, with global bodies
  });
  timed(s, s.seconds.respond, [&] {
    respond(s);  // velocities that fulfil the contact law, iterated with the neighbours
  });
  if constexpr (watches<Scenario, energy_ledger>) book_response(s);
  if constexpr (watches<Scenario, momentum_balance>) book_momentum(s);
  if constexpr (world_state<Scenario>::continuous)
    timed(s, s.seconds.detect, [&] {  // until when bodies that struck something go on
      limit_flights(s, [&] { each_close_pair<flight_stopper>(s); });
    });
  timed(s, s.seconds.integrate, [&] {
    integrate(s);  // positions of the bodies owned here
  });
  if constexpr (watches<Scenario, energy_ledger>) book_motion(s), close_energy(s);
  if constexpr (watches<Scenario, momentum_balance>) close_momentum(s);
  ++s.steps;
  s.time += dt;
  hand_over(s);  // bodies that left go to their new owner, shadow copies are refreshed
  if constexpr (watches<Scenario, residual_monitor>) (void)last_residual(s);
}

}  // namespace talus::detail
