#pragma once
// First stage of a step: pairs that may touch, and what becomes of them.
#include "talus/world/contact_maker.hpp"
#include "talus/world/continuous.hpp"
#include "talus/world/hooks.hpp"
#include "talus/world/midpoint.hpp"
#include "talus/world/neighbour_list.hpp"
#include "talus/world/search.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

/// Finds all contacts that this rank computes: those that touch a body it owns.
template <class Scenario>
void detect(world_state<Scenario>& s) {
  s.each_contact_list([](auto& list) { list.clear(); });
  if constexpr (world_state<Scenario>::sleeps)
    if (all_rest(s)) return count_bodies(s);
  if constexpr (world_state<Scenario>::continuous) {
    prepare_detection(s);
    follow_flights(s, [&] { each_neighbour_pair<impact_finder>(s); });
    prepare_detection(s, [&](const auto& store, std::size_t i, std::size_t k) {
      return reach_after_flight(s, store, i, k);
    });
    each_neighbour_pair<contact_maker>(s);
  } else if (keep_close_pairs(s)) {
    each_found_pair<contact_maker>(s);
  } else {
    prepare_detection(s);
    each_neighbour_pair<contact_maker>(s);
  }
}

/// The stage of detection in a step of hard contacts, as often as contacts are looked for.
template <class Scenario>
void find_contacts(world_state<Scenario>& s) {
  run_hooks<stages::before_detect>(s);
  if constexpr (world_state<Scenario>::midpoint) forget_earlier_turns(s);
  detect(s);
}

}  // namespace talus::detail
