#pragma once
// Time as the system measures it. (<chrono> costs a third of a second in every file compiled.)
#include <ctime>

namespace talus::detail {

[[nodiscard]] inline double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
/// Seconds of wall time since an arbitrary moment; monotonic.
[[nodiscard]] inline double wall_seconds() { return seconds_of(CLOCK_MONOTONIC); }
/// Processor seconds of this thread; each rank has its own.
[[nodiscard]] inline double thread_seconds() { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }

}  // namespace talus::detail
