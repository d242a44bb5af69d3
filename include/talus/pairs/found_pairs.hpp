#pragma once
// The loop over the candidate pairs of the neighbour list that are within reach in this step.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/pairs/close_pairs.hpp"
#include "talus/pairs/neighbour_list.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The number of pairs whose distances are compared before the close ones are used.
inline constexpr std::size_t pairs_of_block = 256;

/// The places of the bodies of a shape, with soft contacts.
template <class Shape, class Scenario>
[[nodiscard]] const auto* soft_places(world_state<Scenario>& s) {
  return s.soft.places.data() + s.template of<Shape>().first;
}

/// Whether `Take` leaves the places of the pairs in the history as they are.
template <class Take>
inline constexpr bool only_reads_places = requires {
  requires Take::only_reads_places;
};

/// Calls `take` for those pairs of one list of the neighbour list that are within reach in this
/// step.
template <class A, class B, partner P, class Scenario, class Take>
void each_found_pair_of(world_state<Scenario>& s, plain_vector<close_pair>& list, Take&& take) {
  [[maybe_unused]] const auto& of_a = s.template of<A>();
  const auto& of_b = s.template of<B>();
  constexpr bool moving = P == partner::moving;
  const auto& a = of_a.movable;
  const auto& b = moving ? of_b.movable : of_b.global;
  const auto reach_of_b = [&](std::size_t j) -> real {
    real reach = 0;
    if constexpr (B::finite) reach = moving ? of_b.reach[j] : of_b.global_reach[j];
    return (void)j, reach;
  };
  const auto margin = [](const auto& store, real reach, std::size_t k) {
    return reach - store.shape[k].bounding_radius();
  };
  const auto take_pair = [&](auto& pair) __attribute__((always_inline)) {
    const std::size_t i = pair.i, j = pair.j;
    if constexpr (requires { take(i, j, pair.last); }) {
      take(i, j, pair.last);
    } else {
      real margin_b = 0;
      if constexpr (B::finite) margin_b = margin(b, reach_of_b(j), j);
      take(i, j, margin(a, of_a.reach[i], i), margin_b, pair.last);
    }
  };
  if constexpr (!B::finite) {
    for (close_pair& pair : list) take_pair(pair);
  } else {
    constexpr std::size_t ahead = 6;
    std::array<std::uint32_t, pairs_of_block + 1> close;
    for (std::size_t first = 0; first < list.size(); first += pairs_of_block) {
      close_pair* const pairs = list.data() + first;
      const std::size_t size = std::min(pairs_of_block, list.size() - first);
      std::size_t count = 0;
      if constexpr (requires { take.find_close(pairs, size, close.data()); }) {
        count = take.find_close(pairs, size, close.data());
      } else if constexpr (world_state<Scenario>::law::soft && moving) {
        constexpr bool forget = !only_reads_places<std::remove_reference_t<Take>>;
        count = find_close<forget>(pairs, size, soft_places<A>(s), soft_places<B>(s), close.data());
      } else {
        for (std::size_t k = 0; k < size; ++k) {
          close_pair& pair = pairs[k];
          const real reach = of_a.reach[pair.i] + reach_of_b(pair.j);
          const bool apart =
              (a.position[pair.i] - b.position[pair.j]).squaredNorm() > reach * reach;
          close[count] = static_cast<std::uint32_t>(k);
          count += apart ? 0 : 1;
          if constexpr (!only_reads_places<std::remove_reference_t<Take>>)
            pair.last = apart ? history_place::none : pair.last;
        }
      }
      if constexpr (requires { take(pairs, close.data(), count); }) {
        take(pairs, close.data(), count);
      } else {
        for (std::size_t k = 0; k < count; ++k) {
          if constexpr (requires { take.prefetch(pairs[0]); })
            if (k + ahead < count) take.prefetch(pairs[close[k + ahead]]);
          take_pair(pairs[close[k]]);
        }
      }
    }
  }
  if constexpr (requires { take.finish(); }) take.finish();
}

/// Calls the maker of each kind of pair, make<A, B, partner>(), for those pairs of the neighbour
/// list that are within reach in this step.
template <class Scenario, class Make>
void each_found_pair(world_state<Scenario>& s, Make&& make) {
  each_kind_of_pair(s, [&]<class A, class B, partner P>(std::size_t kind) {
    auto take = make.template operator()<A, B, P>();
    auto& list = s.found.lists[kind];
    if constexpr (requires { take.make_all(list); })
      take.make_all(list);
    else
      each_found_pair_of<A, B, P>(s, list, take);
  });
}
template <template <class, class, class, partner> class Maker, class Scenario>
void each_found_pair(world_state<Scenario>& s) {
  each_found_pair(s, [&]<class A, class B, partner P>() { return Maker<Scenario, A, B, P>(s); });
}

}  // namespace talus::detail
