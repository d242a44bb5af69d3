#pragma once
// --dry-run: what a run will need, from its bodies and a short trial.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "talus/core/clock.hpp"
#include "talus/observe/memory.hpp"
#include "talus/scene/options.hpp"
#include "talus/state/contact_count.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// A dry run makes no outputs, and no limit of time ends its trials.
[[gnu::cold]] inline void write_nothing(options& o) {
  for (std::string* const file :
       {&o.json, &o.csv, &o.frames, &o.checkpoint, &o.output, &o.view, &o.log})
    file->clear();
  o.checkpoint_every = 0;
  o.time_limit.clear();
}

/// Contacts per body of a packing at rest: spheres with friction have five to six contacts each,
/// and each belongs to two bodies.
inline constexpr double contacts_per_body_at_rest = 3;
/// Time of a contact in a step over that of a body, where the trial does not show it: measured with
/// spheres and ten iterations (examples well and hopper: 5 to 7).
inline constexpr double time_of_contact_over_body = 5;
/// Bytes of a contact in the solver, in what is remembered of it, and in the list of pairs. With
/// friction, of spheres, in double.
inline constexpr double bytes_per_contact = 400;

/// Some steps of the trial.
struct trial_part {
  std::uint64_t steps = 0;
  double seconds = 0;          ///< of wall time, on the slowest rank
  std::uint64_t contacts = 0;  ///< after them, on all ranks
};

/// What a run will need.
struct run_estimate {
  int ranks = 1;
  std::uint64_t bodies = 0, movable = 0;
  std::uint64_t bodies_max = 0;     ///< on the rank that has most
  double bytes = 0, bytes_max = 0;  ///< of bodies and contacts after the trial; of the largest rank
  double process_bytes_max = 0;  ///< that the largest process has had, with programs and libraries
  /// To be made by this call of simulate(), and by those before it.
  std::uint64_t steps = 0, first_step = 0;
  bool ends_early = false;            ///< the program ended the call within the trial
  std::string pair_rules;             ///< in words; empty: of one material
  std::vector<std::string> forces{};  ///< names of fields of force and fluids
  bool gravity = false;
  bool falls = false;        ///< bodies can move, and come to rest on each other
  double steps_of_fall = 0;  ///< in which the body at the top falls to the bottom and comes to rest
  std::vector<trial_part> trial;  ///< in the order of time, without the first step, which allocates

  [[nodiscard]] std::uint64_t trial_steps() const;
  [[nodiscard]] double trial_seconds() const;
  [[nodiscard]] std::uint64_t contacts() const { return trial.empty() ? 0 : trial.back().contacts; }
  /// Whether all bodies have had the time to fall under gravity, and the number of contacts stays
  /// as it is.
  [[nodiscard]] bool settled() const;
  /// Contacts of the bodies when they have come to rest on each other.
  [[nodiscard]] double contacts_at_rest() const;
  /// Bytes of bodies and contacts then.
  [[nodiscard]] double bytes_at_rest() const;
  /// Seconds of a step at the end of the trial, and when the bodies rest on each other.
  [[nodiscard]] double step_at_end() const;
  [[nodiscard]] double step_at_rest() const;
  /// Seconds of all steps.
  [[nodiscard]] double seconds() const;
};

/// Calls of simulate() that a dry run tries, at most: programs may call it until something holds.
inline constexpr int most_tried_calls = 20;

/// What all calls of simulate() will need.
struct total_estimate {
  int calls = 0;
  std::uint64_t steps = 0;
  double seconds = 0;
  void add(const run_estimate& e) { ++calls, steps += e.steps, seconds += e.seconds(); }
};

/// The most memory that this process has had.
[[nodiscard, gnu::cold]] double bytes_of_process();
/// Without a program, of a later call.
[[nodiscard, gnu::cold]] std::string to_text(const run_estimate& e, const std::string& program);
/// Empty for one call, unless there is a `remark`.
[[nodiscard, gnu::cold]] std::string to_text(const total_estimate& e, const std::string& remark);

/// Collective: the bodies of a run, and the steps in which they fall.
template <class Scenario>
[[gnu::cold]] void count_bodies(world<Scenario>& w, run_estimate& e) {
  const vec3 g = w.gravity();
  const real size = g.norm();
  constexpr double none = -std::numeric_limits<double>::max();
  std::array<double, 3> largest{0, none, none};  // bodies, highest, lowest
  std::array<std::uint64_t, 2> sums{};
  w.for_each_local([&](const auto& b) {
    ++sums[0], sums[1] += b.is_fixed() ? 0 : 1;
    const double height = size > 0 ? -b.position().dot(g) / size : 0;
    largest[1] = std::max(largest[1], height), largest[2] = std::max(largest[2], -height);
  });
  largest[0] = static_cast<double>(sums[0]);
  w.link().reduce(reduction::sum, std::span<std::uint64_t>(sums));
  w.link().reduce(reduction::max, std::span<double>(largest));
  e.bodies = sums[0], e.movable = sums[1];
  e.bodies_max = static_cast<std::uint64_t>(largest[0]);
  // Bodies that have reached the bottom take half as long again to come to rest.
  const real dt = state_of(w).dt;
  e.gravity = size > 0;
  e.falls = e.gravity && e.movable > 0;
  if (e.falls && dt > 0)
    e.steps_of_fall = 1.5 * std::sqrt(2 * (largest[1] + largest[2]) / size) / dt;
}

/// The trial of a call of simulate(). It measures steps which that call makes, with all functions
/// that act after them, for a second, and up to ten seconds while the bodies still come to rest.
template <class Scenario>
class call_trial {
 public:
  /// Collective: a call of simulate() begins. `before`: the steps of the earlier calls, of which
  /// trials may have made fewer.
  void begin(world<Scenario>& w, std::uint64_t before = 0) {
    e_ = {};
    e_.ranks = w.ranks();
    e_.first_step = std::max<std::uint64_t>(w.steps(), before);
    e_.steps = w.last_step() - w.steps();
    if (w.materials().size() > 1) e_.pair_rules = w.materials().describe_rules();
    e_.forces = w.acting();
    count_bodies(w, e_);
    over_ = false;
    made_ = in_batch_ = 0, batch_ = 1;
    start_ = wall_seconds();
  }
  /// Collective: the call has made a step. Returns whether the trial ends with it.
  [[nodiscard]] bool end_step(world<Scenario>& w) {
    constexpr double long_enough = 1, longest = 10, part = 0.2;
    const bool last = w.steps() >= w.last_step();
    if (over_ || (++in_batch_ < batch_ && !last)) return false;
    double seconds = wall_seconds() - start_;
    w.link().reduce(reduction::max, std::span(&seconds, 1));
    std::uint64_t contacts = count_contacts(view_of(w));
    w.link().reduce(reduction::sum, std::span(&contacts, 1));
    if (made_ == 1) e_.trial.clear();  // the first step
    made_ += in_batch_;
    e_.trial.push_back({in_batch_, seconds, contacts});
    if (!e_.falls) count_bodies(w, e_);  // an inflow may have added the first that can
    const double passed = e_.trial_seconds();
    const bool changes = (e_.falls || !e_.forces.empty()) && !e_.settled();
    over_ = last || passed > longest || (passed > long_enough && !changes);
    if (made_ > 1 && seconds < part) batch_ *= 2;
    if (seconds > 2 * part) batch_ = std::max<std::uint64_t>(1, batch_ / 2);
    in_batch_ = 0;
    start_ = wall_seconds();
    return over_;
  }
  /// Collective: what the run will need.
  [[nodiscard]] run_estimate estimate(world<Scenario>& w) {
    if (w.stopped() && made_ > 0) e_.ends_early = true, e_.steps = made_;
    e_.bytes = static_cast<double>(bytes_in_use(w));
    std::array<double, 2> largest{e_.bytes, bytes_of_process()};
    w.link().reduce(reduction::sum, std::span(&e_.bytes, 1));
    w.link().reduce(reduction::max, std::span<double>(largest));
    e_.bytes_max = largest[0];
    e_.process_bytes_max = largest[1];
    return e_;
  }

 private:
  run_estimate e_;
  std::uint64_t made_ = 0, in_batch_ = 0, batch_ = 1;
  double start_ = 0;
  bool over_ = false;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/dry_run_definitions.hpp"
#endif
