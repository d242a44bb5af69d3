#pragma once
// Fixed bodies that can move again. The contacts of a fixed body were computed by the other body's
// rank alone, so only that rank stores their impulses. From now on both ranks compute these
// contacts, and must start from the same impulse: zero.
#include <cstddef>
#include <type_traits>

#include "talus/contact/acting_memory.hpp"
#include "talus/ghosts/stages.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Calls f(history) for each contact history that migrates with its bodies.
template <class Scenario, class F>
void each_migrating_history(world_state<Scenario>& s, F&& f) {
  f(s.history);
  run_hooks<ghost_stages::each_history>(s, f);
}
/// Whether features have contact histories of their own.
template <class Scenario>
inline constexpr bool has_more_histories =
    has_hook<ghost_stages::each_history, Scenario, void (*)(const no_choice&)>;

/// For features<events>: contacts of a body end as it becomes immovable or movable. Between two
/// immovable bodies there are none. Those of a body that is released begin anew, whether or not
/// their memory is cleared; the owner of the other body, which reported them, notes it.
template <class Scenario>
[[gnu::cold]] void note_parted(world_state<Scenario>& s, system_id id, bool is_released) {
  const auto moves = [&](system_id other) {  // here, if the body is released
    bool any = false;
    s.each_finite_shape([&](const auto& b) {
      const std::size_t end = is_released ? b.movable.locals : b.movable.size();
      for (std::size_t i = 0; i < end; ++i)
        any = any || (b.movable.id[i] == other && !b.movable.fixed(i));
    });
    return any;
  };
  const auto note = [&]<class Feature>(type_list<Feature>) {
    if constexpr (std::is_same_v<Feature, events>)
      each_migrating_history(s, [&](const auto& history) {
        for (const auto& e : history.entries())
          if ((e.key.a == id || e.key.b == id) && has_acted(e.memory) &&
              moves(e.key.a == id ? e.key.b : e.key.a) == is_released)
            Feature::hooks::note_parted(own_state<Feature>(s), e.key.a, e.key.b);
      });
  };
  [&]<class... Features>(type_list<Features...>) {
    (note(type_list<Features>{}), ...);
  }(typename Scenario::features{});
}

template <class Scenario>
void clear_history_of(world_state<Scenario>& s, system_id id) {
  if constexpr (world_state<Scenario>::follows_contacts) note_parted(s, id, true);
  each_migrating_history(s, [id](auto& history) { history.forget(id); });
}

/// Body `i` of this rank was released, here or, if it has just arrived, on the rank that it came
/// from.
template <class Scenario, class Store>
[[gnu::cold]] void note_release(world_state<Scenario>& s, Store& store, std::size_t i) {
  store.flags[i] |= flag_released;
  s.released.push_back(store.id[i]);
  clear_history_of(s, store.id[i]);
}

/// All neighbours have the list of the bodies released here.
template <class Scenario>
void end_releases(population<Scenario>& s) {
  if (s.released.empty()) return;
  s.released.clear();
  s.each_finite_shape([&](auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i)
      b.movable.flags[i] &= static_cast<std::uint8_t>(~flag_released);
  });
}

}  // namespace talus::detail
