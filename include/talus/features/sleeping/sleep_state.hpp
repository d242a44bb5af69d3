#pragma once
// State of a world for features<sleeping>; see features/sleeping/sleeping_islands.hpp.
#include <cstdint>
#include <utility>

#include "talus/core/disjoint_sets.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus {

/// When islands are put to sleep; see world::sleeping.
struct sleep_settings {
  /// Speed below which a body counts as resting, in units of length over time; its angular speed
  /// times its bounding radius as well. Typical: a fiftieth of its speed after a fall by its own
  /// size; 0.05 for bodies of size 1 in gravity of 10.
  real speed = 0.05;
  /// How long all bodies of an island must have rested, in units of time.
  real time = 0.5;
};

namespace detail {

/// Steps of its present motion for which a body searches ahead, so that an island is awake on all
/// ranks at the impact.
inline constexpr int steps_of_warning = 4;
/// Islands are put to sleep in every fourth step only, many at once.
inline constexpr int steps_between_rests = 4;
/// Within so many steps the ranks of an island agree whether something immovable bears it.
inline constexpr int steps_to_tell = 40;

template <class History>
struct sleep_state {
  using waker = plain_pair<system_id, float>;  ///< a sleeping body, rest time of its waker

  sleep_settings settings;
  History contacts;                ///< of sleeping bodies: memory of their contacts until they wake
  plain_vector<system_id> asleep;  ///< all that are known here, sorted
  plain_vector<waker> touched;     ///< own bodies that an awake body approaches
  disjoint_sets islands;           ///< in the solver's indices
  /// Two times for each body, which all bodies of an island share: how long it has rested, and how
  /// long nothing immovable has supported it.
  plain_vector<float> island_timer, island_unborne;
  bool all = false;      ///< all are to wake
  bool changed = false;  ///< own bodies fell asleep or woke, neighbours not yet notified
  bool noted = false;    ///< the memory was sorted after wake_islands_in_step() began
  bool spreads = false;  ///< a body known here woke: others of its island may have to

  [[nodiscard]] std::size_t bytes() const {
    return contacts.bytes() + asleep.capacity() * sizeof(system_id) +
           touched.capacity() * sizeof(waker) + islands.bytes() +
           (island_timer.capacity() + island_unborne.capacity()) * sizeof(float);
  }
};

}  // namespace detail
}  // namespace talus
