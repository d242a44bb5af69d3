#pragma once
// features<sleeping>: its state (world/sleep_state.hpp), and the stages at which it acts
// (world/sleep.hpp).
#include "talus/world/detect.hpp"
#include "talus/world/sleep.hpp"
#include "talus/world/sleep_state.hpp"
#include "talus/world/stage_clock.hpp"
#include "talus/world/state.hpp"

namespace talus {

template <class Scenario>
struct sleeping::state {
  detail::sleep_state<typename detail::response_state<Scenario>::history_type> sleep;
};

struct sleeping::hooks {
  /// Wakes islands that something approaches.
  template <class Scenario>
  static void after_detect(detail::world_state<Scenario>& s) {
    timed(s, s.seconds.detect, [&] { wake_disturbed(s, [&] { detail::find_contacts(s); }); });
  }
  template <class Scenario>
  static void after_move(detail::world_state<Scenario>& s) {
    timed(s, s.seconds.integrate, [&] { put_to_sleep(s); });
  }
};

}  // namespace talus
