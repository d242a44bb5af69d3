#pragma once
// The figures of the summary of a run, and conclusions from them.
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/interaction/time_step.hpp"
#include "talus/observe/balance.hpp"
#include "talus/observe/force_balance.hpp"
#include "talus/observe/islands.hpp"
#include "talus/observe/monitors.hpp"
#include "talus/observe/motion.hpp"
#include "talus/observe/penetration.hpp"
#include "talus/observe/residual.hpp"
#include "talus/observe/warnings_of_scales.hpp"
#include "talus/state/speed_leap.hpp"
#include "talus/state/step_times.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Values that a scenario measured itself, by name; the same on all ranks.
using results = std::vector<std::pair<std::string, double>>;

/// The figures of the last lines of a run and its JSON file. Lengths in radii where stated.
struct summary {
  std::string scenario;
  unit_names units;  ///< of the program
  std::string policies;
  std::string transport;
  int ranks = 1;
  std::uint64_t steps = 0;  ///< from the beginning
  std::string ended;        ///< what ended the run early, as "rest"; empty: all steps are made
  std::uint64_t restarted_at = 0;    ///< step of the checkpoint from which this run continued
  double dt = 0;                     ///< of the last step
  double dt_least = 0, dt_most = 0;  ///< of all steps of this run
  double time = 0;                   ///< at the end
  /// The step beyond which soft contacts are not stable, at the end of the run; 0 for hard
  /// contacts.
  double critical_dt = 0;
  double impact_speed_max = 0;  ///< of soft contacts: the fastest approach in any step
  /// Least number of steps in a contact: the shortest one, at the fastest approach in steps of that
  /// length; 0: no impacts.
  double steps_per_contact = 0;
  double shortest_contact_dt = 0, shortest_contact_speed = 0;  ///< that length, and that speed
  std::uint64_t contacts = 0;                                  ///< considered in the last step
  bool sleeping = false;     ///< whether islands may be put to sleep
  bool followed = false;     ///< whether fast bodies are followed: continuous_collision
  bool may_follow = false;   ///< whether the scenario could name that feature
  detail::speed_leap leap;   ///< the largest leap of a body's speed by contacts
  detail::driven_jump jump;  ///< the farthest that a driven body went in a step
  detail::open_joint joint;  ///< the joint that opened farthest
  std::string pair_rules;    ///< of materials, in words; empty: means
  double gravity = 0;        ///< its size
  motion moving;
  penetration overlap;
  force_balance balance_of_forces;
  bool mixed = false;         ///< whether contacts are solved in float
  contact_residual residual;  ///< of the last step
  talus::convergence solved;  ///< of all steps
  solver_settings solver;     ///< as they are now
  islands_solved islands;     ///< of this run
  double cpu_seconds = 0;     ///< of all ranks together
  double wall_seconds = 0;
  step_seconds step_cpu;       ///< CPU time of single steps; only run() measures it
  stage_seconds seconds;       ///< of each stage, on the slowest rank
  stage_seconds seconds_mean;  ///< of each stage, the mean over the ranks
  results functions;       ///< wall time of functions, outputs and monitors, on the slowest rank
  results functions_mean;  ///< the same, the mean over the ranks
  std::uint64_t messages_per_step_max = 0;  ///< sent by one rank in one step
  std::uint64_t bytes_per_step_max = 0;
  double collectives_per_step = 0;
  double bytes_per_body = 0;
  bool balancing = false;  ///< whether cuts between domains may move
  load_balance balance;
  std::string digest;
  detail::plain_vector<measured> monitors;  ///< of the last step, or of all if the name says so
  results own;                              ///< of the scenario
};

namespace detail {

/// The steps of this run, since its restart, at least one.
[[nodiscard]] double steps_taken(std::uint64_t steps, std::uint64_t restarted_at);

}  // namespace detail

/// Whether this run made a step, since its restart: figures of a step are there then.
[[nodiscard]] inline bool made_steps(const summary& r) { return r.steps > r.restarted_at; }
/// Iterations of the contact solver per step.
[[nodiscard]] double mean_iterations(const summary& r);

/// Whether a run with a tolerance ended above it.
[[nodiscard]] bool above_tolerance(const summary& r);

/// Whether the contacts are soft: then there is a critical time step, and nothing to solve.
[[nodiscard]] inline bool soft(const summary& r) { return r.critical_dt > 0; }

/// The longest step of the run.
[[nodiscard]] inline double longest_step(const summary& r) { return std::max(r.dt, r.dt_most); }

/// Whether the time step of the run was too large for its soft contacts, so that they gained
/// energy.
[[nodiscard]] inline bool dt_above_critical(const summary& r) {
  return soft(r) && longest_step(r) > r.critical_dt;
}

/// Whether the shortest soft contact of the run took fewer steps than needed for accuracy.
[[nodiscard]] bool contacts_unresolved(const summary& r);

/// Bounds for the warnings of the summary. Overlap over the radius of the thinner body, of hard and
/// of soft contacts; momentum that contacts do not stop, over the impulse of the weight in a step;
/// and the closure of the balance of momentum, in double and with float contacts.
inline constexpr double overlap_bound_hard = 0.05, overlap_bound_soft = 0.2;
inline constexpr double unstopped_bound = 1;
inline constexpr double balance_bound = 1e-8, balance_bound_mixed = 1e-4;

[[nodiscard]] inline double overlap_bound(const summary& r) {
  return soft(r) ? overlap_bound_soft : overlap_bound_hard;
}
/// Whether bodies overlap by more than the bound.
[[nodiscard]] inline bool overlap_beyond_bound(const summary& r) {
  return !(r.overlap.deepest <= overlap_bound(r));
}
/// Whether contacts leave more momentum than the bound, or do not balance.
[[nodiscard]] bool balance_beyond_bound(const summary& r);

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/summary_figures_definitions.hpp"
#endif
