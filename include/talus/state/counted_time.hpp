#pragma once
// The time of a world from the number of its steps: a running sum of dt would accumulate round-off.
#include <cstdint>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Time = origin + (steps - first) dt, with a new origin if dt changes.
struct counted_time {
  real origin = 0;          ///< the time of the change to dt
  std::uint64_t first = 0;  ///< the number of steps then
  real dt = 0;              ///< 0: no step since this origin

  /// The time `n` steps of that length after the step number `steps`, whose time is `now`.
  [[nodiscard]] real after(real now, std::uint64_t steps, std::uint64_t n, real length) {
    if (length != dt) origin = now, first = steps, dt = length;
    return origin + static_cast<real>(steps + n - first) * dt;
  }
};

}  // namespace talus::detail
