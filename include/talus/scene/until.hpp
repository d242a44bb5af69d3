#pragma once
// --until: conditions of observe/run_ends.hpp by their names.
#include <array>
#include <functional>
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
        "in "
        "world.observe(...), or name kinetic_energy, potential_energy or max_speed",
        name, name);
  return found[1];
}

/// Ends calls of simulate() as --until says. Collective.
template <class Scenario>
[[gnu::cold]] void attach_end(world<Scenario>& w, const options& options, run_log& log,
                              std::string& ended) {
  if (options.until.empty()) return;
  const std::function<bool()> over =
      options.until == "rest"
          ? at_rest(w, {.speed = options.until_speed, .time = options.until_time})
          : steady(w, {.time = options.until_time, .within = options.until_within},
                   [name = options.until.substr(7)](auto& of) { return observable_of(of, name); });
  // After the functions of the set-up, which may record the observable.
  w.before_simulating([&w, &options, &log, &ended, over, first = true]() mutable {
    ended.clear();
    if (!std::exchange(first, false)) return;
    w.after_each_step([&w, &options, &log, &ended, over] {
      if (w.steps() % options.until_every != 0 || !over()) return;
      ended = options.until;
      if (w.rank() == 0)
        log.say(compose("ended by --until {} in step {}\n", options.until, w.steps()),
                options.quiet);
      w.stop();  // alike on all ranks
    });
  });
}

}  // namespace talus::detail
