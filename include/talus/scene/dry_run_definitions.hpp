#pragma once
// The definitions of dry_run.hpp, in the compiled part or in each program.
#include <sys/resource.h>

#include <cmath>
#include <string>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/scene/dry_run.hpp"

namespace talus::detail {

TALUS_INLINE double bytes_of_process() {
  rusage used{};
  return ::getrusage(RUSAGE_SELF, &used) == 0 ? 1024.0 * static_cast<double>(used.ru_maxrss) : 0;
}

[[nodiscard, gnu::cold]] inline std::string bytes_text(double bytes) {
  const char* units[] = {" kB", " MB", " GB", " TB"};
  double value = bytes / 1000;
  std::size_t k = 0;
  for (; value >= 1000 && k < 3; ++k) value /= 1000;
  return text(value, 3) + units[k];
}

[[nodiscard, gnu::cold]] inline std::string seconds_text(double seconds) {
  if (seconds < 120) return text(seconds, 3) + " s";
  if (seconds < 7200) return text(seconds / 60, 3) + " min";
  return text(seconds / 3600, 3) + " h";
}

TALUS_INLINE std::string to_text(const run_estimate& e, const std::string& program) {
  const std::uint64_t steps = e.steps;
  std::string all = compose("{}: dry run, nothing is written\n", program);
  all += compose("  bodies   {}, of which {} can move; {} on the rank with most of {}\n", e.bodies,
                 e.movable, e.bodies_max, e.ranks);
  all += compose("  contacts {} after the trial, about {} when the bodies rest on each other\n",
                 e.contacts, static_cast<std::uint64_t>(contacts_at_rest(e)));
  if (!e.pair_rules.empty()) all += compose("           {}\n", e.pair_rules);
  all += compose(
      "  memory   {} for bodies and contacts, {} on the rank with most, about {} at rest; the "
      "largest "
      "process has had {}\n",
      bytes_text(e.bytes), bytes_text(e.bytes_max), bytes_text(bytes_at_rest(e)),
      bytes_text(e.process_bytes_max));
  if (e.trial_steps == 0) return all + "  time     no step is to be made\n";
  all += compose("  speed    {} steps/s in a trial of {} steps\n", text(1 / e.seconds_per_step, 3),
                 e.trial_steps);
  return all + compose(
                   "  time     {} for the {} steps of this call of simulate(), as long as steps "
                   "take what they took in the trial\n",
                   seconds_text(e.seconds_per_step * static_cast<double>(steps)), steps);
}

}  // namespace talus::detail
