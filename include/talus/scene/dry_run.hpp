#pragma once
// --dry-run: what a run will need, from its bodies and a short trial.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "talus/core/clock.hpp"
#include "talus/observe/memory.hpp"
#include "talus/scene/options.hpp"
#include "talus/state/contact_count.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// A dry run makes no outputs.
[[gnu::cold]] inline void write_nothing(options& o) {
  for (std::string* const file :
       {&o.json, &o.csv, &o.frames, &o.checkpoint, &o.output, &o.view, &o.log})
    file->clear();
  o.checkpoint_every = 0;
}

/// Contacts per body of a packing at rest: spheres with friction have five to six contacts each,
/// and each belongs to two bodies.
inline constexpr double contacts_per_body_at_rest = 3;

/// What a run will need.
struct run_estimate {
  int ranks = 1;
  std::uint64_t bodies = 0, movable = 0;
  std::uint64_t bodies_max = 0;     ///< on the rank that has most
  std::uint64_t contacts = 0;       ///< after the trial
  double bytes = 0, bytes_max = 0;  ///< of bodies and contacts after the trial; of the largest rank
  double process_bytes_max = 0;   ///< that the largest process has had, with programs and libraries
  std::uint64_t trial_steps = 0;  ///< measured
  double seconds_per_step = 0;    ///< of wall time
  std::uint64_t first_step = 0, steps = 0;  ///< to be made by this call of simulate()
  std::string pair_rules;                   ///< in words; empty: of one material
};

/// Bytes of a contact in the solver, in what is remembered of it, and in the list of pairs. With
/// friction, of spheres, in double.
inline constexpr double bytes_per_contact = 400;

[[nodiscard]] inline double contacts_at_rest(const run_estimate& e) {
  return std::max(static_cast<double>(e.contacts),
                  contacts_per_body_at_rest * static_cast<double>(e.movable));
}
/// Estimated bytes of bodies and contacts after the bodies have come to rest on each other.
[[nodiscard]] inline double bytes_at_rest(const run_estimate& e) {
  return e.bytes + (contacts_at_rest(e) - static_cast<double>(e.contacts)) * bytes_per_contact;
}

/// The most memory that this process has had.
[[nodiscard, gnu::cold]] double bytes_of_process();
[[nodiscard, gnu::cold]] std::string to_text(const run_estimate& e, const std::string& program);

/// Collective: makes a few steps, for about a second, and measures. `steps`: those of simulate().
template <class Scenario>
[[nodiscard, gnu::cold]] run_estimate estimate_run(world<Scenario>& w, std::uint64_t steps) {
  constexpr double long_enough = 1;
  constexpr std::uint64_t most = 512;
  run_estimate e;
  e.ranks = w.ranks();
  e.first_step = w.steps();
  e.steps = steps;
  if (w.materials().size() > 1) e.pair_rules = w.materials().describe_rules();
  const real dt = state_of(w).dt;
  double passed = 0;
  for (std::uint64_t made = 0, batch = 1; made < std::min(steps, most); batch *= 2) {
    const std::uint64_t now = std::min(batch, std::min(steps, most) - made);
    const double start = wall_seconds();
    for (std::uint64_t k = 0; k < now; ++k) w.step(dt);
    double seconds = wall_seconds() - start;
    w.link().reduce(reduction::max, std::span(&seconds, 1));
    // The first step allocates, and is left out if there are others.
    passed = made == 1 ? seconds : passed + seconds;
    made += now;
    e.trial_steps = std::max<std::uint64_t>(1, made - 1);
    e.seconds_per_step = passed / static_cast<double>(e.trial_steps);
    if (2 * passed > long_enough) break;
  }
  const auto& s = view_of(w);
  std::array<std::uint64_t, 4> sums{0, 0, count_contacts(s), bytes_in_use(w)};
  w.for_each_local([&](const auto& b) { ++sums[0], sums[1] += b.is_fixed() ? 0 : 1; });
  std::array<double, 3> largest{static_cast<double>(sums[0]), static_cast<double>(sums[3]),
                                bytes_of_process()};
  w.link().reduce(reduction::sum, std::span<std::uint64_t>(sums));
  w.link().reduce(reduction::max, std::span<double>(largest));
  e.bodies = sums[0], e.movable = sums[1], e.contacts = sums[2];
  e.bytes = static_cast<double>(sums[3]);
  e.bodies_max = static_cast<std::uint64_t>(largest[0]);
  e.bytes_max = largest[1];
  e.process_bytes_max = largest[2];
  return e;
}

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/dry_run_definitions.hpp"
#endif
