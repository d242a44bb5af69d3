#pragma once
// The definitions of dry_run.hpp, in the compiled part or in each program.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/scene/dry_run.hpp"

namespace talus::detail {

TALUS_INLINE double bytes_of_process() {
  rusage used{};
  return ::getrusage(RUSAGE_SELF, &used) == 0 ? 1024.0 * static_cast<double>(used.ru_maxrss) : 0;
}

TALUS_INLINE std::uint64_t run_estimate::trial_steps() const {
  std::uint64_t sum = 0;
  for (const trial_part& p : trial) sum += p.steps;
  return sum;
}
TALUS_INLINE double run_estimate::trial_seconds() const {
  double sum = 0;
  for (const trial_part& p : trial) sum += p.seconds;
  return sum;
}

TALUS_INLINE bool run_estimate::settled() const {
  const std::uint64_t made = trial_steps();
  if (contacts() == 0 || static_cast<double>(first_step + made) < steps_of_fall) return false;
  std::uint64_t before = 0;
  double least = static_cast<double>(contacts()), most = least;
  for (const trial_part& p : trial) {
    if (2 * before >= made) {  // the second half
      least = std::min(least, static_cast<double>(p.contacts));
      most = std::max(most, static_cast<double>(p.contacts));
    }
    before += p.steps;
  }
  return most < 1.1 * least;
}
TALUS_INLINE double run_estimate::contacts_at_rest() const {
  const auto now = static_cast<double>(contacts());
  if (!falls || trial.empty() || settled()) return now;
  return std::max(now, contacts_per_body_at_rest * static_cast<double>(movable));
}
TALUS_INLINE double run_estimate::bytes_at_rest() const {
  return bytes + (contacts_at_rest() - static_cast<double>(contacts())) * bytes_per_contact;
}

TALUS_INLINE double run_estimate::step_at_end() const {
  const std::uint64_t made = trial_steps();
  std::uint64_t before = 0, steps_of_last = 0;
  double seconds_of_last = 0;
  for (const trial_part& p : trial) {
    before += p.steps;
    if (8 * before > 7 * made) steps_of_last += p.steps, seconds_of_last += p.seconds;
  }
  return made > 0 ? seconds_of_last / static_cast<double>(steps_of_last) : 0;
}
TALUS_INLINE double run_estimate::step_at_rest() const {
  const double now = static_cast<double>(contacts()), then = contacts_at_rest();
  const double at_end = step_at_end();
  if (then <= now) return at_end;
  // The slope of time over contacts, by least squares.
  double n = 0, c = 0, t = 0, cc = 0, ct = 0;
  double least = now, most = now, previous = static_cast<double>(trial.front().contacts);
  for (const trial_part& p : trial) {
    const double count = 0.5 * (previous + static_cast<double>(p.contacts));
    previous = static_cast<double>(p.contacts);
    const auto weight = static_cast<double>(p.steps);
    n += weight, c += weight * count, t += p.seconds;
    cc += weight * count * count, ct += count * p.seconds;
    least = std::min(least, count), most = std::max(most, count);
  }
  const double slope = (n * ct - c * t) / (n * cc - c * c);
  if (most - least > 0.2 * then && slope > 0) return at_end + slope * (then - now);
  const auto count = static_cast<double>(movable);
  return at_end * (count + time_of_contact_over_body * then) /
         (count + time_of_contact_over_body * now);
}
TALUS_INLINE double run_estimate::seconds() const {
  const auto made = static_cast<double>(trial_steps());
  const double left = std::max(0.0, static_cast<double>(steps) - made);
  const double at_rest = step_at_rest();
  // As they fall, the number of contacts grows.
  const double falling =
      std::clamp(steps_of_fall - static_cast<double>(first_step) - made, 0.0, left);
  return trial_seconds() + falling * 0.5 * (step_at_end() + at_rest) + (left - falling) * at_rest;
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

[[nodiscard, gnu::cold]] inline std::string join_names(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : "\", \"") + name;
  return all;
}

TALUS_INLINE std::string to_text(const run_estimate& e, const std::string& program) {
  std::string all = program.empty()
                        ? std::string("a later call of simulate()\n")
                        : compose("{}: dry run, no output of the options is written\n", program);
  all += compose("  bodies   {}, of which {} can move; {} on the rank with most of {}\n", e.bodies,
                 e.movable, e.bodies_max, e.ranks);
  const std::uint64_t made = e.trial_steps();
  if (made == 0) return all + "  time     none: there is no step to be made\n";
  const bool moving = e.falls && !e.settled();
  all += compose("  contacts {} after the trial, ", e.contacts());
  all += moving ? compose("about {} when the bodies rest on each other\n",
                          static_cast<std::uint64_t>(e.contacts_at_rest()))
         : e.settled() && (e.falls || !e.forces.empty()) ? "and their number no longer grows\n"
         : !e.forces.empty()
             ? compose("and as many later: the estimate does not know how \"{}\" changes them\n",
                       join_names(e.forces))
         : e.gravity ? "and as many later: no body can move yet\n"
                     : "and as many later: there is no gravity\n";
  if (!e.pair_rules.empty()) all += compose("           {}\n", e.pair_rules);
  all += compose(
      "  memory   {} for bodies and contacts, {} on the rank with most, about {} at rest; the "
      "largest process has had {}\n",
      bytes_text(e.bytes), bytes_text(e.bytes_max), bytes_text(e.bytes_at_rest()),
      bytes_text(e.process_bytes_max));
  all += compose("  speed    {} steps/s in a trial of {} steps, {} at its end",
                 text(static_cast<double>(made) / e.trial_seconds(), 3), made,
                 text(1 / e.step_at_end(), 3));
  if (moving) all += compose(", about {} at rest", text(1 / e.step_at_rest(), 3));
  return all + compose("\n  time     {} for the {} steps of this call of simulate(){}\n",
                       seconds_text(e.seconds()), e.steps,
                       e.ends_early ? ", which ends early in the trial" : "");
}

TALUS_INLINE std::string to_text(const total_estimate& e, const std::string& remark) {
  std::string all;
  if (e.calls > 1)
    all = compose("all {} calls of simulate()\n  time     {} for {} steps\n", e.calls,
                  seconds_text(e.seconds), e.steps);
  if (!remark.empty()) all += compose("  {}\n", remark);
  return all;
}

}  // namespace talus::detail
