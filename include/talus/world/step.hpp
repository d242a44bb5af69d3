#pragma once
// One time step.
#include "talus/world/detect.hpp"
#include "talus/world/hand_over.hpp"
#include "talus/world/respond.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

template <class Scenario>
void step(world_state<Scenario>& s, real dt) {
  s.dt = dt;
  announce_changes(s);
  {
    const stage_clock clock(s.seconds.detect);
    detect(s);  // contacts of local bodies with each other, with shadow copies, with global bodies
  }
  {
    const stage_clock clock(s.seconds.respond);
    respond(s);  // velocities that fulfil the contact law, iterated with the neighbours
  }
  {
    const stage_clock clock(s.seconds.integrate);
    integrate(s);  // positions of the bodies owned here
  }
  ++s.steps;
  s.time += dt;
  hand_over(s);  // bodies that left go to their new owner, shadow copies are refreshed
}

}  // namespace talus::detail
