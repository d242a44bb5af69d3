#pragma once
// Pairs that may touch, kept from step to step: steps of soft contacts are short, and bodies move
// by little in each (neighbour lists, Verlet 1967).
#include <cstddef>
#include <type_traits>

#include "talus/detect/narrow.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/world/detect.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

/// A body may move by this part of its bounding radius until pairs are looked for anew.
inline constexpr real pair_skin = 0.05;

/// Whether the pairs found last are all that can touch now: the same bodies in the same order, none
/// of which has left its skin.
template <class Scenario>
[[nodiscard]] bool pairs_still_hold(world_state<Scenario>& s) {
  const soft_pairs_found& found = s.soft.found;
  std::size_t k = 0;
  bool hold = found.known;
  s.each_shape([&](const auto& b) { hold = hold && !b.globals_changed; });
  s.each_finite_shape([&](const auto& b) {
    const auto& store = b.movable;
    hold = hold && k + store.size() <= found.bodies.size();
    for (std::size_t i = 0; hold && i < store.size(); ++i, ++k) {
      const auto& then = found.bodies[k];
      hold = then.id == store.id[i] &&
             (store.position[i] - then.position).squaredNorm() <= then.skin * then.skin;
    }
  });
  return hold && k == found.bodies.size();
}

/// Looks for all pairs within reach of each other, unless those found before still hold.
template <class Scenario>
void find_close_pairs(world_state<Scenario>& s) {
  if (pairs_still_hold(s)) return;
  prepare_detection(s, [](const auto& store, std::size_t i, std::size_t) {
    return (1 + pair_skin) * store.shape[i].bounding_radius();
  });
  soft_pairs_found& found = s.soft.found;
  found.known = false;
  for (auto& list : found.lists) list.clear();
  std::size_t kinds = 0;
  each_close_pair(s, [&]<class A, class B, partner P>() {
    const std::size_t kind = kinds++;
    if (found.lists.size() < kinds) found.lists.resize(kinds);
    return [&s, &found, kind](std::size_t i, std::size_t j, real, real) {
      if constexpr (!B::finite && collidable<sphere, B>) {
        const auto& a = s.template of<A>().movable;
        const auto& b = s.template of<B>().global;
        bool near = false;
        const sphere skin{(1 + pair_skin) * a.shape[i].bounding_radius()};
        collide_pair(skin, a.pose(i), b.shape[j], b.pose(j), 0,
                     [&](const contact_geometry&) { near = true; });
        if (!near) return;
      }
      found.lists[kind].push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)});
    };
  });
  found.bodies.clear();
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.size(); ++i)
      found.bodies.push_back({b.movable.id[i], b.movable.position[i],
                              pair_skin * b.movable.shape[i].bounding_radius()});
  });
  s.each_shape([](auto& b) { b.globals_changed = false; });
  found.known = true;
}

/// Like each_close_pair(), for the pairs found.
template <class Scenario, class Make>
void each_found_pair(world_state<Scenario>& s, Make&& make) {
  std::size_t kind = 0;
  const auto visit = [&]<class A, class B, partner P>() {
    auto take = make.template operator()<A, B, P>();
    const auto& a = s.template of<A>().movable;
    const auto& b = P == partner::moving ? s.template of<B>().movable : s.template of<B>().global;
    for (const auto& [i, j] : s.soft.found.lists[kind]) {
      if constexpr (B::finite) {
        const real reach = a.shape[i].bounding_radius() + b.shape[j].bounding_radius();
        if ((a.position[i] - b.position[j]).squaredNorm() > reach * reach) continue;
      }
      take(i, j, 0, 0);
    }
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

}  // namespace talus::detail
