#pragma once
// A world whose future depends on its bodies and the memory of their contacts alone: all derived
// data that saves work from step to step (pairs, copies, pauses) is discarded, and rebuilt. Both
// the run that writes a checkpoint and the one that reads it restart from this state there, so they
// continue alike to the bit, although the order of contacts matters.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "talus/core/id_table.hpp"
#include "talus/core/sort.hpp"
#include "talus/state/state.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

struct checkpoint_access {
  template <class World>
  [[nodiscard]] static auto& keeper(World& w) {
    return w.keeper_;
  }
  /// Numbers passed to record(), also while a restart leaves out calls of simulate().
  template <class World>
  [[nodiscard]] static recorded_values& records(World& w) {
    return w.records_;
  }
  template <class World>
  [[nodiscard]] static std::uint64_t& seed(World& w) {
    return w.seed_;
  }
  template <class World>
  [[nodiscard]] static std::uint64_t& fills(World& w) {
    return w.fills_;
  }
  template <class World>
  [[nodiscard]] static std::uint64_t& attempts(World& w) {
    return w.attempts_;
  }
  template <class World>
  [[nodiscard]] static std::uint64_t& added_here(World& w) {
    return w.added_here_;
  }
  /// The reach of the connections, and the positions of the cuts, of a world that moves them.
  template <class World>
  [[nodiscard]] static std::vector<real> cuts(const World& w) {
    const auto& balance = w.state_.balance;
    std::vector<real> numbers = balance.divided.positions();
    numbers.insert(numbers.begin(), balance.reach);
    return numbers;
  }
  /// Divides space by those numbers; the caller synchronizes.
  template <class World>
  static void place_cuts(World& w, std::span<const real> numbers) {
    auto& balance = w.state_.balance;
    if (numbers.size() < 2) return;  // there were none
    balance.divided = balance.divided.placed(numbers.subspan(1));
    balance.reach = numbers[0];
    w.state_.own = typename World::domain_type(balance.divided, w.rank(), w.ranks(), balance.reach);
  }
  template <class World>
  static void require_domain(const World& w) {
    w.require_domain();
  }
};

/// The bodies owned here.
template <class Scenario>
[[nodiscard]] id_table own_bodies(const held_bodies<Scenario>& s) {
  std::size_t all = 0;
  s.each_finite_shape([&](const auto& b) { all += b.movable.locals; });
  id_table own;
  own.reset(all);
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i) own.add(b.movable.id[i]);
  });
  return own;
}

/// The memory of contacts, of the bodies owned here alone.
template <class History>
[[nodiscard]] History of_own_bodies(const History& all, const id_table& own) {
  History kept;
  kept.reset(all.entries().size());
  for (const auto& c : all.entries())
    if (own.has(c.key.a) || own.has(c.key.b)) kept.add(c.key, c.memory);
  return kept;
}

/// Sleeping bodies that are known here, in the order of their ids.
template <class Scenario>
[[nodiscard]] plain_vector<system_id> known_sleepers(const held_bodies<Scenario>& s) {
  plain_vector<system_id> all;
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.size(); ++i)
      if (b.movable.asleep(i)) all.push_back(b.movable.id[i]);
  });
  sort_values(all);
  return all;
}

/// The pending state of sleeping and waking; alike on all ranks.
struct pending_wakes {
  std::uint64_t all = 0, spreads = 0;
};

template <class Scenario>
[[nodiscard]] pending_wakes measure_pending_wakes(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::sleeps) {
    std::array<std::uint64_t, 2> any{s.sleep.all, s.sleep.spreads};
    s.link->reduce(reduction::max, std::span(any));
    return {any[0], any[1]};
  } else {
    return (void)s, pending_wakes{};
  }
}

/// Collective: discards derived data, and rebuilds the shadow copies. All bodies are with their
/// owners.
template <class Scenario>
void begin_afresh(world<Scenario>& w, const pending_wakes& wakes) {
  using state = world_state<Scenario>;
  state& s = state_of(w);
  const bool alone = w.ranks() == 1;
  const id_table own = alone ? id_table{} : own_bodies(s);
  auto history = alone ? std::move(s.history) : of_own_bodies(s.history, own);
  s.history = {};
  s.found = {};
  if constexpr (!state::law::soft) {
    s.solver.islands.begin_afresh();
    s.islands = {};
    s.exact_islands = {};
  }
  s.each_finite_shape([](auto& b) {
    b.movable.drop_shadows();
    b.grid = {};
    b.global_grid = {};
  });
  s.each_shape([](auto& b) { b.globals_changed = true; });
  if constexpr (!state::link_type::alone) {
    s.neighbours.clear();
    s.neighbour_messages.clear();
    s.choice = {};
  }
  s.changed = true;
  if constexpr (state::filters) s.filtered.known = false;  // what sleeps after a restart stays so
  if constexpr (state::sleeps) {
    auto frozen = alone ? std::move(s.sleep.contacts) : of_own_bodies(s.sleep.contacts, own);
    auto settings = s.sleep.settings;
    s.sleep = {};
    s.sleep.settings = settings;
    w.synchronize();
    s.sleep.contacts = std::move(frozen);
    s.sleep.asleep = known_sleepers(s);
    s.sleep.all = wakes.all != 0;
    s.sleep.spreads = wakes.spreads != 0;
  } else {
    (void)wakes;
    w.synchronize();
  }
  s.history = std::move(history);
  if constexpr (std::remove_cvref_t<decltype(s)>::law::soft) s.found.forget_places();
}

}  // namespace talus::detail
