#pragma once
// Whether a program makes the number of steps, and the length of steps, of its command line.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/state/step_lengths.hpp"

namespace talus::detail {

/// Whether the configuration of options::configuration has this key from the command line.
[[nodiscard, gnu::cold]] inline bool on_command_line(std::string_view configuration,
                                                     std::string_view key) {
  const std::string head = "\n" + std::string(key) + " = ";
  const std::string all = "\n" + std::string(configuration);
  const std::size_t at = all.find(head);
  if (at == all.npos) return false;
  const std::string_view line =
      std::string_view(all).substr(at + 1, all.find('\n', at + 1) - at - 1);
  return line.ends_with("  # command line") || line.ends_with("  # --set");
}

/// Whether calls of simulate() that asked for these numbers of steps make as many as `steps`: one
/// of them, all, all but the first or the last, or several in a row that ask for equal parts of it
/// does so, but for a remainder of the division of at most a hundredth. (Other relations, such as
/// twice as many, also hold by chance for calls with numbers of their own.)
[[nodiscard, gnu::cold]] inline bool make_steps(const std::vector<std::uint64_t>& asked,
                                                std::uint64_t steps) {
  if (asked.empty()) return true;  // the program calls step()
  std::uint64_t all = 0;
  for (std::size_t first = 0, end = 0; first < asked.size(); first = end) {
    for (end = first; end < asked.size() && asked[end] == asked[first];) ++end;
    const std::uint64_t calls = end - first, sum = calls * asked[first];
    all += sum;
    if (asked[first] == steps) return true;
    if (sum <= steps && steps - sum < calls && 100 * (steps - sum) <= steps) return true;
  }
  return steps == all ||
         (asked.size() > 1 && (steps == all - asked.front() || steps == all - asked.back()));
}

/// A sentence on standard error if they do not; else empty.
[[nodiscard, gnu::cold]] inline std::string unused_steps(const std::vector<std::uint64_t>& asked,
                                                         std::uint64_t steps) {
  if (make_steps(asked, steps)) return {};
  std::uint64_t all = 0;
  for (const std::uint64_t n : asked) all += n;
  return compose(
      "--steps is {}, but the calls of world.simulate in this program ask for {} steps in all: if "
      "that does not follow from it, give one .steps = options.steps",
      steps, all);
}

/// Whether steps of these lengths have the length `dt`. Of more lengths than are kept, it is within
/// them.
[[nodiscard, gnu::cold]] inline bool have_length(const std::vector<step_lengths::entry>& used,
                                                 real dt) {
  for (const auto& one : used)
    if (std::abs(one.dt - dt) <= 1e-6 * dt) return true;
  return used.empty() ||
         (used.size() >= step_lengths::most && used.front().dt < dt && dt < used.back().dt);
}

/// A sentence on standard error if none does; else empty.
[[nodiscard, gnu::cold]] inline std::string unused_dt(const std::vector<step_lengths::entry>& used,
                                                      real dt) {
  if (have_length(used, dt)) return {};
  const real least = used.front().dt, most = used.back().dt;
  return compose(
      "--dt is {}, but the steps of this program have lengths of {}{}: if these do not follow from "
      "it, give world.simulate .dt = options.dt",
      dt, text(least, 4), least == most ? std::string() : " to " + text(most, 4));
}

}  // namespace talus::detail
