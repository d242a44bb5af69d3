#pragma once
// The search for candidate pairs: every body is put into its grid, then all pairs within reach are
// found.
#include <stdexcept>
#include <type_traits>

#include "talus/core/plain_vector.hpp"
#include "talus/pairs/filtered_pairs.hpp"
#include "talus/pairs/stages.hpp"
#include "talus/state/acting_range.hpp"
#include "talus/state/body_numbers.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/kinematic_bodies.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The rank that owns body `i` of a shape's movable bodies, also if it is a shadow copy.
template <class Scenario, class Bodies>
[[nodiscard]] int owner_of_index(const rank_state<Scenario>& s, const Bodies& bodies,
                                 std::size_t i) {
  using shapes = typename state_traits<Scenario>::finite_shapes;
  std::size_t last = bodies.movable.locals;
  for (const auto& n : s.neighbours)
    if (last <= i && i < (last += n.copies[index_of<shapes, typename Bodies::shape_type>]))
      return n.rank;
  return s.link->rank();
}

/// Makes room for all bodies in the arrays of the response.
template <class Scenario>
void count_bodies(world_state<Scenario>& s) {
  const body_counts count = number_bodies(s);
  if constexpr (world_state<Scenario>::law::soft) {
    s.soft.bodies.resize(count.all), s.soft.places.resize(count.all);
  } else {
    s.solver.first_tensor = count.scalar;
    s.solver.bodies.resize(count.all);
    if constexpr (world_state<Scenario>::drives) number_driven(s);
  }
}

/// Whether a pair is skipped: one sleeps, and the other cannot move either.
template <class StoreA, class StoreB>
[[nodiscard]] bool undisturbed(const StoreA& a, std::size_t i, const StoreB& b, std::size_t j) {
  return (a.asleep(i) && !b.moves(j)) || (b.asleep(j) && !a.moves(i));
}

/// The number of steps of their motion for which bodies search ahead.
template <class Scenario>
[[nodiscard]] int steps_ahead(const world_state<Scenario>& s) {
  int steps = 1;
  run_hooks<search_stages::search_ahead>(s, steps);
  return steps;
}

/// The reach of a body in the step under way.
template <class Scenario, class Store>
[[nodiscard]] real reach_in_step(const world_state<Scenario>& s, const Store& store,
                                 std::size_t i) {
  if constexpr (world_state<Scenario>::law::soft)
    return store.shape[i].bounding_radius() + acting_range(s, store, i);
  else
    return reach_of(store, i, steps_ahead(s) * s.dt);
}

/// The reach of a global body; with its skin if it is driven and pairs are to be kept.
template <class Shape, class Scenario, class Store>
[[nodiscard]] real reach_of_global(const world_state<Scenario>& s, const Store& store,
                                   std::size_t i, bool with_skin) {
  if constexpr (world_state<Scenario>::drives)
    if (const driven_body* one = with_skin ? driven_at<Shape>(s, i) : nullptr) return one->skin;
  return (void)with_skin, reach_of(store, i, s.dt);
}

/// Sorts the bodies of each shape into its grid; reach(store, i, index in the solver's arrays) is
/// the reach of a movable body.
template <class Scenario, class Reach>
void prepare_detection(world_state<Scenario>& s, Reach&& reach_of_movable, bool with_skin = false) {
  count_bodies(s);
  update_ranges(s);
  if constexpr (world_state<Scenario>::may_be_flush)
    s.each_shape([&](const auto& b) { s.flush.known = s.flush.known && !b.globals_changed; });
  if constexpr (world_state<Scenario>::drives)
    each_driven(s, [](auto& b, std::size_t, const driven_body&) { b.globals_changed = true; });
  s.each_finite_shape([&](auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    const auto sort = [&](auto& store, plain_vector<real>& reach, auto& grid) {
      reach.resize(store.size());
      for (std::size_t i = 0; i < store.size(); ++i)
        reach[i] = &store == &b.movable ? reach_of_movable(store, i, b.first + i)
                                        : reach_of_global<shape>(s, store, i, with_skin);
      try {
        grid.build(store.position, reach);
      } catch (const unplaceable& e) {
        const int rank = &store == &b.movable ? owner_of_index(s, b, e.index) : s.link->rank();
        fail<std::runtime_error>(
            "body {} at {} on rank {}, with velocity {}, angular velocity {} and dt = {}, cannot "
            "be "
            "placed in step {}: {}",
            store.id[e.index], store.position[e.index], rank, store.velocity[e.index],
            store.angular_velocity[e.index], s.dt, s.steps, e.what());
      }
    };
    sort(b.movable, b.reach, b.grid);
    if (b.globals_changed) sort(b.global, b.global_reach, b.global_grid);
  });
  s.each_shape([](auto& b) { b.globals_changed = false; });
}

template <class Scenario>
void prepare_detection(world_state<Scenario>& s) {
  prepare_detection(
      s, [&](const auto& store, std::size_t i, std::size_t) { return reach_in_step(s, store, i); });
}

/// Finds all pairs of bodies within reach of each other that may touch: make<A, B, partner>()
/// returns the receiver of the pairs of the shapes A and B, as (index of a, index of b, margin of
/// a, margin of b).
template <class Scenario, class Make>
void each_neighbour_pair(world_state<Scenario>& s, Make&& make) {
  constexpr bool filters = world_state<Scenario>::filters;
  const auto margin = [](const auto& store, const plain_vector<real>& reach, std::size_t i) {
    return reach[i] - store.shape[i].bounding_radius();
  };
  s.each_finite_shape([&](auto& a) {
    using A = typename std::remove_cvref_t<decltype(a)>::shape_type;

    auto among = make.template operator()<A, A, partner::moving>();
    a.grid.pairs([&](std::size_t i, std::size_t j) {
      if constexpr (filters)
        if (!may_touch(s, a.movable, i, a.movable, j)) return;
      among(i, j, margin(a.movable, a.reach, i), margin(a.movable, a.reach, j));
    });
    if constexpr (requires { among.finish(); }) among.finish();

    s.each_shape([&](auto& b) {
      using B = typename std::remove_cvref_t<decltype(b)>::shape_type;
      constexpr bool later =
          index_of<typename Scenario::shapes, A> < index_of<typename Scenario::shapes, B>;
      if constexpr (B::finite && later) {
        auto between = make.template operator()<A, B, partner::moving>();
        a.grid.pairs_with(b.grid, [&](std::size_t i, std::size_t j) {
          if constexpr (filters)
            if (!may_touch(s, a.movable, i, b.movable, j)) return;
          between(i, j, margin(a.movable, a.reach, i), margin(b.movable, b.reach, j));
        });
      }
      auto against = make.template operator()<A, B, partner::immovable>();
      if constexpr (B::finite) {
        if (b.global.size() > 0)
          a.grid.pairs_with(b.global_grid, [&](std::size_t i, std::size_t j) {
            if constexpr (filters)
              if (!may_touch(s, a.movable, i, b.global, j)) return;
            against(i, j, margin(a.movable, a.reach, i), margin(b.global, b.global_reach, j));
          });
      } else {
        // Pairs of other ranks too: kept pairs may come to be owned here.
        for (std::size_t j = 0; j < b.global.size(); ++j)
          for (std::size_t i = 0; i < a.movable.size(); ++i) {
            if constexpr (filters)
              if (!may_touch(s, a.movable, i, b.global, j)) continue;
            against(i, j, margin(a.movable, a.reach, i), 0);
          }
      }
    });
  });
}

/// Calls an adder of pairs for all pairs within reach of each other: a Maker<Scenario, A, B,
/// partner>(s) takes the pairs of the shapes A and B.
template <template <class, class, class, partner> class Maker, class Scenario>
void each_neighbour_pair(world_state<Scenario>& s) {
  each_neighbour_pair(s,
                      [&]<class A, class B, partner P>() { return Maker<Scenario, A, B, P>(s); });
}

}  // namespace talus::detail
