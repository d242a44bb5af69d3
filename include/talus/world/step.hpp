#pragma once
// One time step: the integrator defines the order of the stages, and the features of the scenario
// act at each (body/stages.hpp).
#include "talus/world/features/balancing.hpp"
#include "talus/world/features/continuous_collision.hpp"
#include "talus/world/features/driven.hpp"
#include "talus/world/features/energy_ledger.hpp"
#include "talus/world/features/momentum_balance.hpp"
#include "talus/world/features/penetration_monitor.hpp"
#include "talus/world/features/residual_monitor.hpp"
#include "talus/world/features/sleeping.hpp"
#include "talus/world/hooks.hpp"
#include "talus/world/integrators/moreau_midpoint.hpp"
#include "talus/world/integrators/semi_implicit_euler.hpp"
#include "talus/world/integrators/velocity_verlet.hpp"
#include "talus/world/migrate_and_refresh.hpp"
#include "talus/world/sort_bodies.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

template <class Scenario>
void step(world_state<Scenario>& s, real dt) {
  s.dt = dt;
  if (s.steps % steps_between_sorts == 0) sort_bodies(s);
  notify_neighbours(s);
  run_hooks<stages::at_start>(s);
  Scenario::integrator::step(s);
  run_hooks<stages::at_end>(s);
}

}  // namespace talus::detail
