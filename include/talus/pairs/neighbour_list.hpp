#pragma once
// Candidate pairs, kept from step to step while bodies move little (neighbour lists, Verlet 1967).
// Each step uses only pairs within their present reach, so that keeping the list changes nothing
// but the order of the contacts.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "talus/detect/narrow.hpp"
#include "talus/pairs/pair_order.hpp"
#include "talus/pairs/search.hpp"
#include "talus/pairs/shape_pairs.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Calls visit<A, B, partner>(number) for all pairs of shapes in the order of their lists.
template <class Scenario, class Visit>
void each_kind_of_pair(held_bodies<Scenario>& s, Visit&& visit) {
  std::size_t kind = 0;
  s.each_finite_shape([&](auto& a) {
    using A = typename std::remove_cvref_t<decltype(a)>::shape_type;
    visit.template operator()<A, A, partner::moving>(kind++);
    s.each_shape([&](auto& b) {
      using B = typename std::remove_cvref_t<decltype(b)>::shape_type;
      constexpr bool later =
          index_of<typename Scenario::shapes, A> < index_of<typename Scenario::shapes, B>;
      if constexpr (B::finite && later) visit.template operator()<A, B, partner::moving>(kind++);
      visit.template operator()<A, B, partner::immovable>(kind++);
    });
  });
}

/// Whether no body leaves its skin, and all are known with unchanged indices.
template <class Scenario>
[[nodiscard]] bool all_within_skin(const world_state<Scenario>& s) {
  bool hold = true;
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    const auto& store = b.movable;
    const auto& [noted, locals] = s.found.shapes[k++];
    hold = hold && store.size() == noted.size() && store.locals == locals;
    for (std::size_t i = 0; hold && i < store.size(); ++i)
      hold = noted[i].covers(store.id[i], store.position[i], b.reach[i]);
  });
  return hold;
}

/// Whether other bodies are here than at the search, in another order, or with other owners.
template <class Scenario>
[[nodiscard]] bool numbers_changed(const world_state<Scenario>& s) {
  bool changed = false;
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    const auto& [noted, locals] = s.found.shapes[k++];
    changed = changed || b.movable.locals != locals ||
              !std::equal(noted.begin(), noted.end(), b.movable.id.begin(), b.movable.id.end(),
                          [](const noted_body& x, system_id id) { return x.id == id; });
  });
  return changed;
}

/// Updates the pairs to the present indices of bodies, after some have migrated or were removed.
/// False if there are new bodies.
template <class Scenario>
[[nodiscard]] bool renumber_pairs(world_state<Scenario>& s) {
  constexpr std::size_t shapes = world_state<Scenario>::shape_count;
  using finite_shapes = typename world_state<Scenario>::finite_shapes;
  std::array<plain_vector<std::uint32_t>, shapes> was, now;
  bool known = true;
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    was[k] = numbers_before(s.found.shapes[k].bodies, b.movable.id);
    known = known && std::find(was[k].begin(), was[k].end(), nobody) == was[k].end();
    ++k;
  });
  if (!known) return false;

  std::array<plain_vector<char>, shapes> came;  // added or removed, by the present index
  k = 0;
  s.each_finite_shape([&](const auto& b) {
    candidate_pairs::shape& found = s.found.shapes[k];
    plain_vector<noted_body> bodies(b.movable.size());
    came[k].resize(b.movable.size());
    for (std::size_t i = 0; i < b.movable.size(); ++i) {
      bodies[i] = found.bodies[was[k][i]];
      came[k][i] = (was[k][i] < found.locals) != (i < b.movable.locals);
    }
    now[k] = numbers_now(was[k], found.bodies.size());
    found.bodies.swap(bodies);
    found.locals = b.movable.locals;
    ++k;
  });
  ++s.found.searches;
  const history_place anew = s.history.place_of_arrivals();
  each_kind_of_pair(s, [&]<class A, class B, partner P>(std::size_t kind) {
    constexpr std::size_t a = index_of<finite_shapes, A>;
    auto& list = s.found.lists[kind];
    std::size_t kept = 0;
    for (close_pair pair : list) {
      pair.i = now[a][pair.i];
      bool change = pair.i != nobody && came[a][pair.i];
      if constexpr (P == partner::moving) {
        constexpr std::size_t b = index_of<finite_shapes, B>;
        pair.j = now[b][pair.j];
        change = change || (pair.j != nobody && came[b][pair.j]);
      }
      if (pair.i == nobody || pair.j == nobody) continue;
      if (change && pair.last == history_place::none) pair.last = anew;
      list[kept++] = pair;
    }
    list.resize(kept);
  });
  return true;
}

/// Measures the present reach of all bodies; returns false if something else than movable bodies
/// has made the candidate pairs of the last search incomplete.
template <class Scenario>
[[nodiscard]] bool pairs_may_hold(world_state<Scenario>& s) {
  bool hold = s.found.known;
  update_ranges(s);
  s.each_shape([&](const auto& b) { hold = hold && !b.globals_changed; });
  s.each_finite_shape([&](auto& b) {
    b.reach.resize(b.movable.size());
    for (std::size_t i = 0; i < b.movable.size(); ++i) b.reach[i] = reach_in_step(s, b.movable, i);
  });
  if constexpr (world_state<Scenario>::drives) hold = hold && driven_within_skin(s);
  return hold;
}

/// Whether the candidate pairs of the last search are complete and have the present indices.
template <class Scenario>
[[nodiscard]] bool pairs_hold_unchanged(world_state<Scenario>& s) {
  return pairs_may_hold(s) && all_within_skin(s);
}

/// Whether the candidate pairs of the last search are still complete, after an update to the
/// present indices if bodies have migrated.
template <class Scenario>
[[nodiscard]] bool pairs_still_hold(world_state<Scenario>& s) {
  if (!pairs_may_hold(s)) return false;
  if (all_within_skin(s)) return true;
  if constexpr (world_state<Scenario>::link_type::alone || world_state<Scenario>::periodic)
    return false;  // the user adds and removes bodies, or several have one id
  else
    return numbers_changed(s) && renumber_pairs(s) && all_within_skin(s);
}

/// The body of the lesser id is the first one of a pair of two of one shape.
template <class Scenario>
void put_in_order_of_ids(world_state<Scenario>& s) {
  each_kind_of_pair(s, [&]<class A, class B, partner P>(std::size_t kind) {
    if constexpr (std::is_same_v<A, B> && P == partner::moving) {
      const auto& id = s.template of<A>().movable.id;
      for (close_pair& pair : s.found.lists[kind])
        if (id[pair.j] < id[pair.i]) std::swap(pair.i, pair.j);
    }
  });
}

/// Whether a triangle of global surface j is in reach of body i of shape A, which includes its
/// skin, until the next search. Contacts of hard laws have a slack beside the reach.
template <class A, class B, class Scenario>
[[nodiscard]] bool surface_in_reach(world_state<Scenario>& s, std::size_t i, std::size_t j) {
  const auto& of_a = s.template of<A>();
  const auto& surfaces = s.template of<B>().global;
  const real size = of_a.movable.shape[i].bounding_radius();
  real reach = of_a.reach[i] + (contact_slack + real(1e-6)) * size;
  if constexpr (world_state<Scenario>::drives)
    if (const driven_body* one = driven_at<B>(s, j)) {
      if (!follows_turns<B, Scenario>) return true;
      reach += one->skin - (1 + contact_slack) * surfaces.shape[j].bounding_radius();
    }
  const vec3 centre = surfaces.pose(j).to_body(of_a.movable.position[i]);
  bool near = false;
  surface_near<A, B>(s, i, j).each_within(centre, vec3(reach, reach, reach), size,
                                          [&](std::uint32_t) { near = true; });
  return near;
}

/// Searches for all pairs that are within reach of each other, or within the skin around.
template <class Scenario>
void find_pairs_with_skin(world_state<Scenario>& s) {
  real sum = 0;
  std::size_t bodies = 0;
  s.each_finite_shape([&](const auto& b) {
    bodies += b.movable.size();
    for (std::size_t i = 0; i < b.movable.size(); ++i) sum += b.movable.shape[i].bounding_radius();
  });
  const real mean = sum / static_cast<real>(std::max<std::size_t>(bodies, 1));
  if constexpr (world_state<Scenario>::drives) give_skins(s, mean);
  prepare_detection(
      s,
      [&](const auto& store, std::size_t i, std::size_t) {
        return reach_in_step(s, store, i) +
               skin_of(store.shape[i].bounding_radius(), mean, store.velocity[i].norm(), s.dt);
      },
      true);

  candidate_pairs& found = s.found;
  found.known = false;
  ++found.searches;
  for (auto& list : found.lists) list.clear();
  std::size_t kinds = 0;
  each_neighbour_pair(s, [&]<class A, class B, partner P>() {
    const std::size_t kind = kinds++;
    if (found.lists.size() < kinds) found.lists.resize(kinds);
    return [&, kind](std::size_t i, std::size_t j, real, real) {
      if constexpr (world_state<Scenario>::sleeps) {
        auto& with = s.template of<B>();
        if (undisturbed(s.template of<A>().movable, i,
                        P == partner::moving ? with.movable : with.global, j))
          return;
      }
      if constexpr (P == partner::immovable && keeps_near<A, B>) {
        if (!surface_in_reach<A, B>(s, i, j)) return;
      } else if constexpr (!B::finite && collidable<sphere, B>) {
        const auto& a = s.template of<A>();
        const auto& b = s.template of<B>().global;
        bool near = false;
        real reach = a.reach[i];
        if constexpr (world_state<Scenario>::drives)
          if (const driven_body* one = driven_at<B>(s, j))
            reach = one->skin < 0 ? std::numeric_limits<real>::infinity() : reach + one->skin;
        collide_pair(sphere{reach}, a.movable.pose(i), b.shape[j], b.pose(j), 0,
                     [&](const contact_geometry&) { near = true; });
        if (!near) return;
      }
      found.lists[kind].push_back(
          {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), history_place::unknown});
    };
  });
  if constexpr (world_state<Scenario>::law::soft) {
    put_in_order_of_ids(s);
    edges_by_partner by_partner;
    each_kind_of_pair(s, [&]<class A, class B, partner P>(std::size_t kind) {
      order_pairs<A, B, P == partner::moving>(s, by_partner, found.lists[kind]);
    });
  }
  found.shapes.resize(world_state<Scenario>::shape_count);
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    candidate_pairs::shape& noted = found.shapes[k++];
    noted.locals = b.movable.locals;
    noted.bodies.clear();
    for (std::size_t i = 0; i < b.movable.size(); ++i) {
      noted.bodies.push_back({b.movable.id[i], b.movable.position[i], b.reach[i]});
      b.reach[i] = reach_in_step(s, b.movable, i);
    }
  });
  if constexpr (world_state<Scenario>::drives) (void)driven_within_skin(s);  // measures them again
  found.known = true;
}

/// Searches for all pairs within reach of each other, unless the last search is still valid.
template <class Scenario>
void find_close_pairs(world_state<Scenario>& s) {
  if (pairs_still_hold(s))
    count_bodies(s);
  else
    find_pairs_with_skin(s);
}

/// Searches for all pairs within reach of each other, unless the last search is still valid.
/// Returns false without a search while bodies move so fast that a search is not valid for long.
template <class Scenario>
[[nodiscard]] bool keep_close_pairs(world_state<Scenario>& s) {
  candidate_pairs& found = s.found;
  if (found.pause > 0) return --found.pause, false;
  if (pairs_still_hold(s)) return ++found.steps, count_bodies(s), true;
  const bool held = !found.known || found.steps >= 2;
  found.failures = held ? 0 : found.failures + 1;
  found.steps = 0;
  if (found.failures < 2) return find_pairs_with_skin(s), true;
  found.failures = 0;
  found.known = false;
  found.pause = 16;
  return false;
}

}  // namespace talus::detail
