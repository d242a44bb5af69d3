#pragma once
// First stage of a step: candidate pairs, and the contacts made from them.
#include "talus/features/continuous_collision/continuous.hpp"
#include "talus/features/sleeping/sleep.hpp"
#include "talus/ghosts/shared_joints.hpp"
#include "talus/pairs/flush_bodies.hpp"
#include "talus/pairs/found_pairs.hpp"
#include "talus/pairs/search.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"
#include "talus/step/contact_maker.hpp"
#include "talus/step/kept_contacts.hpp"
#include "talus/step/midpoint.hpp"

namespace talus::detail {

/// Records the sleeping bodies of a pair of shapes that an awake body approaches.
template <class Scenario, class ShapeA, class ShapeB, partner Partner>
class sleeper_finder {
  static constexpr bool paired = Partner == partner::moving;

 public:
  explicit sleeper_finder(world_state<Scenario>& s) : s_(s) {}

  void operator()(std::size_t i, std::size_t j, real, real) {
    const auto& b = s_.template of<ShapeB>();
    (void)meet_sleeper(s_, s_.template of<ShapeA>().movable, i, paired ? b.movable : b.global, j);
  }

 private:
  world_state<Scenario>& s_;
};

/// Before bodies are followed: wakes bodies that they will strike, so that these are awake at the
/// impact.
template <class Scenario>
void wake_ahead(world_state<Scenario>& s) {
  if (!all_rest(s) && !s.sleep.asleep.empty()) {
    prepare_detection(s);
    each_neighbour_pair<sleeper_finder>(s);
  }
  (void)wake_islands_in_step(s);
}

/// Makes the contacts of pairs of spheres, or keeps them.
template <class Scenario>
class found_spheres {
 public:
  explicit found_spheres(world_state<Scenario>& s) : s_(s) {}

  void make_all(plain_vector<close_pair>& pairs) {
    using state = world_state<Scenario>;
    if constexpr (state::may_use_colours)
      if (s_.on_one_rank() && s_.by_colours()) return make_by_colours(pairs);
    if constexpr (!state::may_use_colours || state::two_solvers)
      if (s_.on_one_rank()) return contact_keeper<Scenario, false>(s_).make_all(pairs);
    if constexpr (!world_state<Scenario>::link_type::alone)
      each_found_pair_of<sphere, sphere, partner::moving>(
          s_, pairs, contact_maker<Scenario, sphere, sphere, partner::moving>(s_));
  }

 private:
  /// Colours follow from all pairs: where these change in most steps, to keep contacts is in vain.
  void make_by_colours(plain_vector<close_pair>& pairs) {
    if constexpr (keeps_first_contacts<Scenario>()) {
      auto& kept = s_.found.kept;
      if (kept.pause == 0) return contact_keeper<Scenario, true>(s_).make_all(pairs);
      if (--kept.pause == 0) kept.search = ~std::uint64_t{0};
    }
    std::get<list_of_spheres<Scenario>>(s_.contacts).clear();
    each_found_pair_of<sphere, sphere, partner::moving>(
        s_, pairs, contact_maker<Scenario, sphere, sphere, partner::moving>(s_));
  }

  world_state<Scenario>& s_;
};

/// Finds all contacts that this rank computes: those that touch a body it owns.
template <class Scenario>
void detect(world_state<Scenario>& s) {
  s.solver.rebounds = s.materials.rebounds();
  s.solver.impacts = s.solver.impacts_ended = false;
  s.solver.finishes = finishes_impacts(s);
  s.each_contact_list([&]<class List>(List& list) {
    if (!keeps_contacts_in<Scenario, List>() || !s.on_one_rank()) list.clear();
  });
  if constexpr (is_cohesive<typename world_state<Scenario>::law>) s.attraction.clear();
  constexpr bool continuous = world_state<Scenario>::continuous;
  if constexpr (world_state<Scenario>::sleeps && continuous) wake_ahead(s);
  if constexpr (world_state<Scenario>::sleeps)
    if (all_rest(s)) {
      count_bodies(s);
      if constexpr (continuous) s.impacts.time.assign(s.solver.bodies.size(), never);
      return;
    }
  if constexpr (continuous) {
    // (If some sleep, the reach covers several steps.)
    prepare_detection(
        s, [&](const auto& store, std::size_t i, std::size_t) { return reach_of(store, i, s.dt); });
    update_flush_bodies(s);
    follow_flights(s, [&] { each_neighbour_pair<impact_finder>(s); });
    prepare_detection(s, [&](const auto& store, std::size_t i, std::size_t k) {
      return reach_after_flight(s, store, i, k);
    });
    each_neighbour_pair<contact_maker>(s);
  } else if (keep_close_pairs(s)) {
    update_flush_bodies(s);
    each_found_pair(s, [&]<class A, class B, partner P>() {
      if constexpr (keeps_contacts_of<Scenario, A, B, P>())
        return found_spheres<Scenario>(s);
      else
        return contact_maker<Scenario, A, B, P>(s);
    });
  } else {
    s.each_contact_list([](auto& list) { list.clear(); });
    prepare_detection(s);
    update_flush_bodies(s);
    each_neighbour_pair<contact_maker>(s);
  }
}

/// The stage of detection in a step of hard contacts: repeated if a feature has changed what can
/// touch.
template <class Scenario>
void find_contacts(world_state<Scenario>& s) {
  const auto search = [&] {
    run_hooks<stages::before_detect>(s);
    if constexpr (world_state<Scenario>::midpoint) clear_earlier_turns(s);
    detect(s);
  };
  search();
  bool again = false;
  run_hooks<search_stages::contacts_found>(s, again);
  if (again) search();
  if constexpr (world_state<Scenario>::has_joints) place_joints(s), gather_joints(s);
}

}  // namespace talus::detail
