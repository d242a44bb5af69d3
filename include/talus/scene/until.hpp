#pragma once
// --until: conditions of observe/run_ends.hpp by their names.
#include <array>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "talus/observe/motion.hpp"
#include "talus/observe/run_ends.hpp"
#include "talus/scene/options.hpp"
#include "talus/scene/run_log.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// The observable of --until steady:NAME.
template <class Scenario>
[[nodiscard, gnu::cold]] real observable_of(world<Scenario>& w, const std::string& name) {
  if (name == "kinetic_energy") return measure_motion(w).kinetic_energy;
  if (name == "potential_energy") return measure_motion(w).potential_energy;
  if (name == "max_speed") return measure_motion(w).max_speed;
  // Only rank 0 has to record.
  std::array<double, 2> found{0, -std::numeric_limits<double>::max()};
  if (w.rank() == 0)
    for (const recorded_value& one : w.records().all())
      if (one.name == name) found = {1, one.value};
  w.link().reduce(reduction::max, std::span<double>(found));
  if (found[0] == 0)
    fail<std::runtime_error>(
        "--until steady:{}: nothing is recorded under that name; call world.record(\"{}\", value) "
        "in world.observe(...), or name kinetic_energy, potential_energy or max_speed",
        name, name);
  return found[1];
}

/// Ends calls of simulate() as --until says. (The conditions without the function objects of
/// at_rest() and steady(), which would be compiled into every program.)
class until_option {
 public:
  explicit until_option(const options& o)
      : options_(o),
        rest_{o.until_speed, o.until_time},
        watch_(steadiness{o.until_time, o.until_within}) {}

  /// A call of simulate() begins. The first time this adds an observer, after those of the set-up,
  /// which may record the observable.
  template <class Scenario>
  [[gnu::cold]] void begin(world<Scenario>& w, run_log& log) {
    if (options_.until.empty()) return;
    ended_.clear(), watch_.clear();
    if (std::exchange(added_, true)) return;
    w.monitor_each_step(name_of_conditions, [this, &w, &log] {
      if (w.steps() % options_.until_every != 0 || !holds(w)) return;
      ended_ = options_.until;
      if (w.rank() == 0)
        log.say(compose("ended by --until {} in step {}\n", ended_, w.steps()), options_.quiet);
      w.stop();  // alike on all ranks
    });
  }
  /// What ended the last call of simulate(); empty: its steps were made.
  [[nodiscard]] const std::string& ended() const { return ended_; }

 private:
  template <class Scenario>
  [[nodiscard, gnu::cold]] bool holds(world<Scenario>& w) {
    if (options_.until == "rest") return all_rest(w, rest_, watch_);
    return watch_.take(w.time(), observable_of(w, options_.until.substr(7)));
  }

  const options& options_;
  rest rest_;
  end_watch watch_;
  std::string ended_{};
  bool added_ = false;
};

}  // namespace talus::detail
