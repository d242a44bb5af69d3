#pragma once
// features<sleeping>: its state (features/sleeping/sleep_state.hpp), and the stages at which it
// acts (features/sleeping/sleep.hpp).
#include "talus/features/sleeping/sleep.hpp"
#include "talus/features/sleeping/sleep_state.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"

namespace talus {

template <class Scenario>
struct sleeping::state {
  detail::sleep_state<typename detail::response_state<Scenario>::history_type> sleep;
};

struct sleeping::hooks {
  template <class Scenario>
  static void search_ahead(const detail::world_state<Scenario>& s, int& steps) {
    if (!s.sleep.asleep.empty()) steps = detail::steps_of_warning;
  }
  /// Wakes islands that something approaches. (If bodies are followed, this is done before the
  /// search: see wake_ahead() of step/detect.hpp. Following them twice would move them twice.)
  template <class Scenario>
  static void contacts_found(detail::world_state<Scenario>& s, bool& search_again) {
    if constexpr (!detail::world_state<Scenario>::continuous)
      search_again = search_again || wake_islands_in_step(s);
  }
  template <class Scenario>
  static void after_move(detail::world_state<Scenario>& s) {
    timed(s, s.seconds.integrate, [&] { put_to_sleep(s); });
  }

  // In the exchange of ghosts.

  /// A contact outlives the motion in which it was found.
  template <class Scenario>
  static void ghost_reach(const detail::world_state<Scenario>& s,
                          detail::ghost_stages::horizon& ahead) {
    ahead.time = detail::steps_of_warning * s.dt;
    ahead.further += 4 * s.dt * s.sleep.settings.speed;
  }
  template <class Scenario>
  static void before_ghosts(detail::world_state<Scenario>& s) {
    if (!s.by_colours()) wake_islands(s);
  }
  template <class Scenario>
  static void ghosts_renewed(detail::world_state<Scenario>& s) {
    note_changed_sleepers(s);
  }
  template <class Scenario>
  static void after_ghosts(detail::world_state<Scenario>& s) {
    if constexpr (detail::world_state<Scenario>::may_use_colours)
      if (s.by_colours()) wake_everywhere(s);
  }
  /// The message with copies has one byte: whether own bodies fell asleep or woke.
  template <class Scenario>
  static void flags_changed(const detail::world_state<Scenario>& s, bool& changed) {
    changed = changed || s.sleep.changed;
  }
  template <class Scenario, class Out>
  static void pack_notice(const detail::world_state<Scenario>& s, Out& out) {
    out.put(static_cast<std::uint8_t>(s.sleep.changed));
  }
  template <class Scenario, class In>
  static void unpack_notice(detail::world_state<Scenario>& s, In& in) {
    s.sleep.changed |= in.template get<std::uint8_t>() != 0;
  }
  /// The frozen memory of the contacts of sleeping bodies.
  template <class Scenario, class F>
  static void each_history(detail::world_state<Scenario>& s, F& f) {
    f(s.sleep.contacts);
  }
};

}  // namespace talus
