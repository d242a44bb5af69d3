#pragma once
// Whether a program uses the number of steps, and their length, on its command line.
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/state/step_lengths.hpp"

namespace talus::detail {

/// Whether calls of simulate() that asked for these numbers of steps may follow from `steps`: some
/// in a row ask for as many (but for the remainders of a division), one asks for twice as many, or
/// the last of several reaches it.
[[nodiscard, gnu::cold]] inline bool follow_from(const std::vector<std::uint64_t>& asked,
                                                 std::uint64_t steps) {
  constexpr std::size_t many = 1000;
  if (asked.empty() || asked.size() > many || steps == 0) return true;
  std::uint64_t all = 0;
  for (std::size_t first = 0; first < asked.size(); ++first) {
    all += asked[first];
    if (asked[first] == 2 * steps) return true;
    std::uint64_t sum = 0;
    for (std::size_t k = first; k < asked.size() && sum <= steps; ++k) {
      sum += asked[k];
      const std::uint64_t rest = k - first;
      if (sum + rest >= steps && sum <= steps + rest) return true;
    }
  }
  return asked.size() > 1 && all >= steps && all - asked.back() < steps;
}

/// A sentence on standard error if they do not; else empty.
[[nodiscard, gnu::cold]] inline std::string unused_steps(const std::vector<std::uint64_t>& asked,
                                                         std::uint64_t steps) {
  if (follow_from(asked, steps)) return {};
  std::uint64_t all = 0;
  for (const std::uint64_t n : asked) all += n;
  return compose(
      "--steps {} seems to have no effect in this program, whose calls of world.simulate ask for "
      "{} steps in "
      "all: give it .steps = options.steps",
      steps, all);
}

/// Whether one of these lengths of steps may follow from `dt`: it is `dt`, up to ten times as much,
/// or a whole part down to a tenth.
[[nodiscard, gnu::cold]] inline bool follows_from(const std::vector<step_lengths::entry>& used,
                                                  real dt) {
  for (const auto& one : used)
    for (const real ratio : {one.dt / dt, dt / one.dt})
      if (ratio < 10.5 && std::abs(ratio - std::round(ratio)) < 1e-6) return true;
  return used.empty();
}

/// A sentence on standard error if none does; else empty.
[[nodiscard, gnu::cold]] inline std::string unused_dt(const std::vector<step_lengths::entry>& used,
                                                      real dt) {
  if (follows_from(used, dt)) return {};
  const real least = used.front().dt, most = used.back().dt;
  return compose(
      "--dt {} seems to have no effect in this program, whose steps have lengths of {}{}: give "
      "world.simulate .dt = options.dt",
      dt, text(least, 4), least == most ? std::string() : " to " + text(most, 4));
}

}  // namespace talus::detail
