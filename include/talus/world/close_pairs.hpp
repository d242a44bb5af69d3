#pragma once
// Pairs that may touch, kept from step to step while bodies move by little (neighbour lists, Verlet
// 1967). What is done with them depends on who is within reach at present, so that keeping them
// changes nothing but the order of the contacts.
#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "talus/detect/narrow.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/world/search.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

/// A body may move by this part of its bounding radius, or of the mean one if that is less, until
/// pairs are looked for anew; and by what it moves in some steps, or few fast ones would have them
/// looked for all the time.
inline constexpr real pair_skin = 0.1;
inline constexpr int pair_steps = 8;

/// Measures the present reach of all bodies, and tells whether the pairs found last are all that
/// can touch now: the same bodies in the same order, none of which reaches out of its skin.
template <class Scenario>
[[nodiscard]] bool pairs_still_hold(world_state<Scenario>& s) {
  const found_pairs& found = s.found;
  bool hold = found.known;
  std::size_t k = 0;
  s.each_shape([&](const auto& b) { hold = hold && !b.globals_changed; });
  s.each_finite_shape([&](auto& b) {
    const auto& store = b.movable;
    hold = hold && k + store.size() <= found.bodies.size();
    if (!hold) return;
    b.reach.resize(store.size());
    for (std::size_t i = 0; i < store.size(); ++i, ++k) {
      const auto& then = found.bodies[k];
      b.reach[i] = reach_in_step(s, store, i);
      const real left = then.reach - b.reach[i];
      hold = hold && then.id == store.id[i] && left >= 0 &&
             (store.position[i] - then.position).squaredNorm() <= left * left;
    }
  });
  return hold && k == found.bodies.size();
}

/// Looks for all pairs that are within reach of each other, or within the skin around.
template <class Scenario>
void find_pairs_with_skin(world_state<Scenario>& s) {
  real sum = 0;
  std::size_t bodies = 0;
  s.each_finite_shape([&](const auto& b) {
    bodies += b.movable.size();
    for (std::size_t i = 0; i < b.movable.size(); ++i) sum += b.movable.shape[i].bounding_radius();
  });
  const real mean = sum / static_cast<real>(std::max<std::size_t>(bodies, 1));
  prepare_detection(s, [&](const auto& store, std::size_t i, std::size_t) {
    const real radius = store.shape[i].bounding_radius();
    return reach_in_step(s, store, i) + pair_skin * std::min(mean, radius) +
           std::min(pair_steps * s.dt * store.velocity[i].norm(), radius);
  });

  found_pairs& found = s.found;
  found.known = false;
  for (auto& list : found.lists) list.clear();
  std::size_t kinds = 0;
  each_close_pair(s, [&]<class A, class B, partner P>() {
    const std::size_t kind = kinds++;
    if (found.lists.size() < kinds) found.lists.resize(kinds);
    return [&s, &found, kind](std::size_t i, std::size_t j, real, real) {
      if constexpr (world_state<Scenario>::sleeps) {
        auto& with = s.template of<B>();
        if (undisturbed(s.template of<A>().movable, i,
                        P == partner::moving ? with.movable : with.global, j))
          return;
      }
      if constexpr (!B::finite && collidable<sphere, B>) {
        const auto& a = s.template of<A>();
        const auto& b = s.template of<B>().global;
        bool near = false;
        collide_pair(sphere{a.reach[i]}, a.movable.pose(i), b.shape[j], b.pose(j), 0,
                     [&](const contact_geometry&) { near = true; });
        if (!near) return;
      }
      found.lists[kind].push_back(
          {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), history_place::unknown});
    };
  });
  found.bodies.clear();
  s.each_finite_shape([&](auto& b) {
    for (std::size_t i = 0; i < b.movable.size(); ++i) {
      found.bodies.push_back({b.movable.id[i], b.movable.position[i], b.reach[i]});
      b.reach[i] = reach_in_step(s, b.movable, i);
    }
  });
  s.each_shape([](auto& b) { b.globals_changed = false; });
  found.known = true;
}

/// Looks for all pairs within reach of each other, unless those found before still hold.
template <class Scenario>
void find_close_pairs(world_state<Scenario>& s) {
  if (!pairs_still_hold(s)) find_pairs_with_skin(s);
}

/// The same, unless bodies move so fast that pairs do not hold for long: then false.
template <class Scenario>
[[nodiscard]] bool keep_close_pairs(world_state<Scenario>& s) {
  found_pairs& found = s.found;
  if (found.pause > 0) return --found.pause, false;
  if (pairs_still_hold(s)) return ++found.steps, count_bodies(s), true;
  const bool worth = !found.known || found.steps >= 2;
  found.steps = 0;
  if (worth) return find_pairs_with_skin(s), true;
  found.known = false;
  found.pause = 16;
  return false;
}

/// Like each_close_pair(), for the pairs found.
template <class Scenario, class Make>
void each_found_pair(world_state<Scenario>& s, Make&& make) {
  std::size_t kind = 0;
  const auto visit = [&]<class A, class B, partner P>() {
    auto take = make.template operator()<A, B, P>();
    const auto& of_a = s.template of<A>();
    const auto& of_b = s.template of<B>();
    constexpr bool moving = P == partner::moving;
    const auto& a = of_a.movable;
    const auto& b = moving ? of_b.movable : of_b.global;
    for (close_pair& pair : s.found.lists[kind]) {
      const std::size_t i = pair.i, j = pair.j;
      const auto margin = [](const auto& store, real reach, std::size_t k) {
        return reach - store.shape[k].bounding_radius();
      };
      const real reach_a = of_a.reach[i];
      real margin_b = 0;
      if constexpr (B::finite) {
        const real reach_b = moving ? of_b.reach[j] : of_b.global_reach[j];
        const real reach = reach_a + reach_b;
        if ((a.position[i] - b.position[j]).squaredNorm() > reach * reach) {
          pair.last = history_place::none;
          continue;
        }
        margin_b = margin(b, reach_b, j);
      }
      take(i, j, margin(a, reach_a, i), margin_b, pair.last);
    }
    if constexpr (requires { take.finish(); }) take.finish();
    ++kind;
  };
  s.each_finite_shape([&](auto& a) {
    using A = typename std::remove_cvref_t<decltype(a)>::shape_type;
    visit.template operator()<A, A, partner::moving>();
    s.each_shape([&](auto& b) {
      using B = typename std::remove_cvref_t<decltype(b)>::shape_type;
      constexpr bool later =
          index_of<typename Scenario::shapes, A> < index_of<typename Scenario::shapes, B>;
      if constexpr (B::finite && later) visit.template operator()<A, B, partner::moving>();
      visit.template operator()<A, B, partner::immovable>();
    });
  });
}
template <template <class, class, class, partner> class Maker, class Scenario>
void each_found_pair(world_state<Scenario>& s) {
  each_found_pair(s, [&]<class A, class B, partner P>() { return Maker<Scenario, A, B, P>(s); });
}

}  // namespace talus::detail
