#pragma once
// One time step: the integrator defines the order of the stages, and the features of the scenario
// act at each (body/stages.hpp).
#include <utility>

#include "talus/features/balancing/balancing.hpp"
#include "talus/features/continuous_collision/continuous_collision.hpp"
#include "talus/features/driven/driven_hooks.hpp"
#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/features/momentum_balance.hpp"
#include "talus/features/penetration_monitor.hpp"
#include "talus/features/sleeping/sleeping.hpp"
#include "talus/ghosts/migrate_and_refresh.hpp"
#include "talus/pairs/filtered_pairs.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/state.hpp"
#include "talus/step/act_on_bodies.hpp"
#include "talus/step/integrators/moreau_midpoint.hpp"
#include "talus/step/integrators/semi_implicit_euler.hpp"
#include "talus/step/integrators/velocity_verlet.hpp"
#include "talus/step/residual_monitor.hpp"
#include "talus/step/sort_bodies.hpp"

namespace talus::detail {

template <class Scenario>
void step(world_state<Scenario>& s, real dt) {
  static_assert(views_are_defined<Scenario, typename Scenario::features>,
                "a world with a feature of one's own needs what its hooks see: write "
                "#include <talus/feature.hpp>");
  s.dt = dt;
  if (dt != s.lengths.now()) {
    real fastest = 0;
    if constexpr (Scenario::contact_law::soft) fastest = std::exchange(s.soft.fastest_approach, 0);
    s.lengths.change(dt, fastest);
  }
  if (s.steps % steps_between_sorts == 0) sort_bodies(s);
  if constexpr (world_state<Scenario>::filters) note_filters(s);
  notify_neighbours(s);
  note_copies_sent(s, !Scenario::integrator::shares_midway);
  if constexpr (!world_state<Scenario>::midpoint) act_on_bodies(s, s.time);
  run_hooks<stages::at_start>(s);
  Scenario::integrator::step(s);
  run_hooks<stages::at_end>(s);
}

}  // namespace talus::detail
