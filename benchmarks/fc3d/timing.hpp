#pragma once
// CPU time of a solver.
#include <algorithm>
#include <ctime>
#include <vector>

namespace fc3d {

inline double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
inline double cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

/// Calls run(timed), which calls timed(f) once, until there are 9 times of f or they add up to
/// 20 ms; their median.
template <class Run>
double median_seconds(Run&& run) {
  std::vector<double> times;
  for (double total = 0; times.empty() || (total < 0.02 && times.size() < 9); total += times.back())
    run([&](auto&& f) {
      const double start = cpu_seconds();
      f();
      times.push_back(cpu_seconds() - start);
    });
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

}  // namespace fc3d
