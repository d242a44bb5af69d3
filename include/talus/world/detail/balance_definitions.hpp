#pragma once
// The member function of world that moves cuts.
#include "talus/step/sort_bodies.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Before a step: moves the cuts if shares have become uneven, and connects ranks again if the
/// reach of bodies exceeds that of the connections. Collective.
template <class Scenario>
void world<Scenario>::look_at_balance_if_due() {
  if constexpr (!link_type::alone) {
    auto& b = state_.balance;
    if (ranks() == 1 || !b.due(state_.steps)) return;
    const detail::collectives_counted counted(state_);
    const detail::rank_load mine = detail::load_of(state_, b.seconds);
    const detail::whole_load all = detail::reduce_load(*state_.link, mine);
    const imbalance now = all.uneven();
    const bool timed = b.settings.by == balance_by::time && all.sum.seconds > 0;
    const bool uneven = (timed ? now.time : now.bodies) > b.settings.above;
    const real needed = detail::reach_of_connections(all.max.reach, b.asked);
    b.cost = detail::cost_of_body(b.cost, mine, all);
    b.seconds = 0;
    if (!uneven && 2 * all.max.reach <= b.reach) return;
    synchronize();  // sends the user's changes to neighbours while they are still neighbours
    if (uneven) {
      b.note_move(now);
      const auto places = detail::places_of_own(state_);
      b.divided = b.divided.shared_out(*state_.link, std::span<const vec3>(places),
                                       timed ? detail::weight_of_cost(b.cost) : 1, ranks());
    }
    b.reach = needed;
    state_.own = domain_type(b.divided, rank(), ranks(), b.reach);
    synchronize();
    detail::sort_bodies(state_);
  }
}

}  // namespace talus
