#pragma once
// The end of a run in figures: speed beside error.
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/observe/balance.hpp"
#include "talus/observe/critical_dt.hpp"
#include "talus/observe/digest.hpp"
#include "talus/observe/doubts.hpp"
#include "talus/observe/memory.hpp"
#include "talus/observe/monitors.hpp"
#include "talus/observe/motion.hpp"
#include "talus/observe/penetration.hpp"
#include "talus/observe/residual.hpp"
#include "talus/world/contact_count.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// What a scenario measured by itself, by name; the same on all ranks.
using results = std::vector<std::pair<std::string, double>>;

/// What the last line of a run and its JSON file say. Lengths in radii where said so.
struct summary {
  std::string scenario;
  std::string policies;
  std::string transport;
  int ranks = 1;
  std::uint64_t steps = 0;         ///< from the beginning
  std::uint64_t restarted_at = 0;  ///< step of the checkpoint that this run went on from
  double dt = 0;
  /// Of soft contacts, at the end: the step beyond which they are not stable; 0: they are hard.
  double critical_dt = 0;
  double impact_speed_max = 0;   ///< of soft contacts: the fastest approach in any step
  double steps_per_contact = 0;  ///< at that speed, of the shortest contact; 0: no impacts
  std::uint64_t contacts = 0;    ///< considered in the last step
  bool sleeping = false;         ///< whether islands may go to sleep
  bool followed = false;         ///< whether fast bodies are followed: continuous_collision
  bool may_follow = false;       ///< whether the scenario could name that
  detail::speed_leap leap;       ///< where contacts made a body much faster than anything was
  double gravity = 0;            ///< its size
  motion moving;
  penetration overlap;
  contact_residual residual;  ///< of the last step
  talus::convergence solved;  ///< of all steps
  solver_settings solver;     ///< as they are now
  double cpu_seconds = 0;     ///< of all ranks together
  double wall_seconds = 0;
  stage_seconds seconds;                    ///< of the slowest rank
  std::uint64_t messages_per_step_max = 0;  ///< sent by one rank in one step
  std::uint64_t bytes_per_step_max = 0;
  double collectives_per_step = 0;
  double bytes_per_body = 0;
  bool balancing = false;  ///< whether cuts between domains may move
  load_balance balance;
  std::string digest;
  detail::plain_vector<measured> monitors;  ///< of the last step, or of all where the name says so
  results own;                              ///< of the scenario
};

namespace detail {

template <class Scenario>
[[nodiscard]] std::string transport_in_use(world<Scenario>& w) {
  if constexpr (requires { w.link().transport_name(); })
    return w.link().transport_name();
  else
    return Scenario::transport::name;
}

/// By this run, at least one.
[[nodiscard]] inline double steps_taken(std::uint64_t steps, std::uint64_t restarted_at) {
  return steps > restarted_at ? static_cast<double>(steps - restarted_at) : 1;
}

/// One flat JSON object, field by field.
class json_object {
 public:
  [[gnu::cold]] void add(std::string_view key, std::string_view text) {
    std::string quoted = "\"";
    for (const char c : text) {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    put(key, quoted + '"');
  }
  void add(std::string_view key, const std::string& text) { add(key, std::string_view(text)); }
  /// JSON has no NaN and no infinity: they become null.
  [[gnu::cold]] void add(std::string_view key, double value) {
    put(key, std::isfinite(value) ? detail::text(value) : "null");
  }
  void add(std::string_view key, std::uint64_t value) { put(key, std::to_string(value)); }
  void add(std::string_view key, int value) { put(key, std::to_string(value)); }
  void add(std::string_view key, std::same_as<bool> auto value) {
    put(key, value ? "true" : "false");
  }
  [[nodiscard]] std::string str() const { return "{\n" + text_ + "\n}\n"; }

 private:
  [[gnu::cold]] void put(std::string_view key, const std::string& value) {
    if (!text_.empty()) text_ += ",\n";
    ((((text_ += "  \"") += key) += "\": ") += value);
  }
  std::string text_;
};

/// Collective: of all ranks, and of several as large the first.
template <class Scenario>
[[nodiscard, gnu::cold]] speed_leap largest_leap_of(world<Scenario>& w) {
  const speed_leap& mine = w.state().driving.leap;
  const auto largest = [&](double value) {
    w.link().reduce(reduction::max, std::span(&value, 1));
    return value;
  };
  constexpr double none = -std::numeric_limits<double>::max();
  const double ratio = largest(mine.ratio());
  if (ratio == 0) return {};
  const bool as_large = mine.ratio() == ratio;
  const double first = -largest(as_large ? -static_cast<double>(mine.step) : none);
  const bool it = as_large && static_cast<double>(mine.step) == first;
  return {static_cast<std::uint64_t>(first), largest(it ? mine.before : 0),
          largest(it ? mine.after : 0)};
}

/// What the time step of a soft scenario means for its contacts.
template <class Scenario>
[[gnu::cold]] void report_soft_step(world<Scenario>& w, talus::summary& r) {
  using law = typename Scenario::contact_law;
  const auto& s = w.state();
  const auto scales = measure_soft_scales(w);
  real fastest = s.soft.fastest_approach;
  w.link().reduce(reduction::max, std::span(&fastest, 1));
  r.critical_dt = longest_stable_step<law>(scales, s.materials);
  r.impact_speed_max = fastest;
  const real shortest = shortest_contact<law>(scales, s.materials, fastest);
  if (std::isfinite(shortest) && s.dt > 0) r.steps_per_contact = shortest / s.dt;
}

}  // namespace detail

/// Collective: the figures of the world as it is now. `cpu_seconds` are those of this rank.
template <class Scenario>
[[nodiscard, gnu::cold]] summary summarize(world<Scenario>& w, double cpu_seconds,
                                           double wall_seconds) {
  w.require_all_ranks("summarize");
  const auto& s = w.state();
  auto& link = w.link();
  summary r;
  r.policies = describe<Scenario>();
  r.transport = detail::transport_in_use(w);
  r.ranks = w.ranks();
  r.steps = w.steps();
  r.restarted_at = w.restarted_at();
  r.dt = s.dt;
  if constexpr (Scenario::contact_law::soft) detail::report_soft_step(w, r);
  r.sleeping = Scenario::template has_feature<talus::sleeping>;
  r.followed = Scenario::template has_feature<continuous_collision>;
  r.may_follow =
      !Scenario::contact_law::soft && !r.sleeping && !detail::world_state<Scenario>::drives &&
      !detail::world_state<Scenario>::periodic && !detail::world_state<Scenario>::by_colours;
  if constexpr (detail::world_state<Scenario>::drives) r.leap = detail::largest_leap_of(w);
  r.gravity = w.gravity().norm();
  r.moving = measure_motion(w);
  r.overlap = measure_penetration(w);
  if constexpr (!Scenario::contact_law::soft) {
    r.residual = measure_residual(w);
    r.solved = w.convergence();
    r.solver = w.solver();
  }
  r.digest = state_digest(w);
  r.monitors = measure_monitors(w).values;
  if constexpr (Scenario::template has_feature<talus::balancing>) {
    r.balancing = true;
    r.balance = measure_balance(w);
  }

  std::array<std::uint64_t, 2> sums{detail::count_contacts(s), bytes_in_use(w)};
  link.reduce(reduction::sum, sums);
  r.contacts = sums[0];
  r.bytes_per_body = static_cast<double>(sums[1]) /
                     static_cast<double>(std::max<std::uint64_t>(1, r.moving.bodies));
  std::array<std::uint64_t, 3> most{s.sent.messages_max, s.sent.bytes_max, s.sent.collectives};
  link.reduce(reduction::max, most);
  r.messages_per_step_max = most[0];
  r.bytes_per_step_max = most[1];
  r.collectives_per_step =
      static_cast<double>(most[2]) / detail::steps_taken(r.steps, r.restarted_at);
  std::array<double, 5> slowest{s.seconds.detect, s.seconds.respond, s.seconds.integrate,
                                s.seconds.exchange, wall_seconds};
  link.reduce(reduction::max, slowest);
  r.seconds = {slowest[0], slowest[1], slowest[2], slowest[3]};
  r.wall_seconds = slowest[4];
  link.reduce(reduction::sum, std::span(&cpu_seconds, 1));
  r.cpu_seconds = cpu_seconds;
  return r;
}

/// Iterations of the contact solver per step.
[[nodiscard]] inline double mean_iterations(const summary& r) {
  return static_cast<double>(r.solved.iterations) /
         static_cast<double>(std::max<std::uint64_t>(1, r.steps));
}

/// Whether a run that was asked for a residual ended above it.
[[nodiscard]] inline bool above_tolerance(const summary& r) {
  return r.solver.tolerance > 0 && !(r.residual.value <= r.solver.tolerance);
}

/// Whether the contacts are soft: then there is a critical time step, and nothing to solve.
[[nodiscard]] inline bool soft(const summary& r) { return r.critical_dt > 0; }

/// Whether the run was too coarse for its soft contacts, so that they gained energy.
[[nodiscard]] inline bool dt_above_critical(const summary& r) {
  return soft(r) && r.dt > r.critical_dt;
}

/// Whether the shortest soft contact of the run took fewer steps than accuracy asks for.
[[nodiscard]] inline bool contacts_unresolved(const summary& r) {
  return r.steps_per_contact > 0 && r.steps_per_contact < detail::steps_of_contact;
}

/// The figures as one flat JSON object.
[[nodiscard, gnu::cold]] inline std::string to_json(const summary& r) {
  detail::json_object o;
  o.add("scenario", r.scenario);
  o.add("policies", r.policies);
  o.add("transport", r.transport);
  o.add("ranks", r.ranks);
  o.add("steps", r.steps);
  if (r.restarted_at > 0) o.add("restarted_at", r.restarted_at);
  o.add("dt", r.dt);
  if (soft(r)) {
    o.add("critical_dt", r.critical_dt);
    o.add("dt_above_critical", int{dt_above_critical(r)});
    o.add("impact_speed_max", r.impact_speed_max);
    if (r.steps_per_contact > 0) o.add("steps_per_contact", r.steps_per_contact);
  }
  o.add("bodies", r.moving.bodies);
  o.add("bodies_movable", r.moving.movable);
  if (r.sleeping) o.add("bodies_asleep", r.moving.asleep);
  o.add("contacts", r.contacts);
  o.add("touching_contacts", r.overlap.touching);
  o.add("penetration_mean", r.overlap.mean);
  o.add("penetration_max", r.overlap.max);
  o.add("gap_mean_loaded", r.overlap.gap_mean_loaded);
  o.add("mean_radius", r.overlap.mean_radius);
  if (!soft(r)) {
    o.add("residual", r.residual.value);
    o.add("residual_max", r.residual.max);
    o.add("residual_worst", r.solved.residual_worst);
    o.add("tolerance", r.solver.tolerance);
    o.add("residual_above_tolerance", above_tolerance(r));
    o.add("steps_above_tolerance", r.solved.steps_above);
    o.add("iterations_mean", mean_iterations(r));
    o.add("iterations_max", r.solved.iterations_max);
  }
  o.add("kinetic_energy", r.moving.kinetic_energy);
  o.add("potential_energy", r.moving.potential_energy);
  o.add("max_speed", r.moving.max_speed);
  o.add("momentum", r.moving.momentum.norm());
  const char* axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) o.add(std::string("momentum_") + axes[k], r.moving.momentum[k]);
  for (int k = 0; k < 3; ++k)
    o.add(std::string("angular_momentum_") + axes[k], r.moving.angular_momentum[k]);
  o.add("cpu_seconds", r.cpu_seconds);
  o.add("wall_seconds", r.wall_seconds);
  o.add("seconds_detect", r.seconds.detect);
  o.add("seconds_respond", r.seconds.respond);
  o.add("seconds_integrate", r.seconds.integrate);
  o.add("seconds_exchange", r.seconds.exchange);
  o.add("messages_per_step_max", r.messages_per_step_max);
  o.add("bytes_per_step_max", r.bytes_per_step_max);
  o.add("collectives_per_step", r.collectives_per_step);
  o.add("bytes_per_body", r.bytes_per_body);
  if (r.balancing) {
    o.add("balance_moves", r.balance.moved);
    o.add("imbalance_bodies_before", r.balance.before.bodies);
    o.add("imbalance_bodies_after", r.balance.after.bodies);
    o.add("imbalance_contacts_before", r.balance.before.contacts);
    o.add("imbalance_contacts_after", r.balance.after.contacts);
    o.add("imbalance_time_before", r.balance.before.time);
    o.add("imbalance_time_after", r.balance.after.time);
  }
  o.add("state_digest", r.digest);
  for (const measured& m : r.monitors) o.add(m.name, m.value);
  for (const auto& [name, value] : r.own) o.add(name, value);
  return o.str();
}

/// The figures as a person reads them.
[[nodiscard, gnu::cold]] inline std::string to_text(const summary& r) {
  const double steps = detail::steps_taken(r.steps, r.restarted_at);
  const auto percent = [&](double seconds) {
    return std::lround(100 * seconds / std::max(r.wall_seconds, 1e-9));
  };
  using detail::text;
  std::string own;
  for (const auto& [name, value] : r.own)
    ((((own += own.empty() ? "  results  " : ", ") += name) += " ") += text(value, 5));
  if (!own.empty()) own += "\n";
  std::string monitors;
  for (const measured& m : r.monitors)
    ((((monitors += monitors.empty() ? "  monitors " : ", ") += m.name) += " ") +=
     text(m.value, 3));
  if (!monitors.empty()) own = monitors + "\n" + own;
  std::string tolerance;
  if (r.solver.tolerance > 0)
    tolerance = detail::compose(" (asked for {})", text(r.solver.tolerance, 2));
  std::string warning;
  if (above_tolerance(r) || r.solved.steps_above > 0)
    warning = detail::compose(
        "  warning  the contact residual stayed above {} in {} of {} steps{}: allow more than {} "
        "iterations, or take a smaller dt\n",
        text(r.solver.tolerance, 2), r.solved.steps_above, r.steps,
        above_tolerance(r) ? ", the last among them" : "", r.solver.max_iterations);
  if (dt_above_critical(r))
    warning += detail::compose(
        "  warning  dt {} is above the critical time step {} of the soft contacts: the results "
        "mean "
        "nothing; take a fifth of it or less\n",
        r.dt, text(r.critical_dt, 4));
  else if (contacts_unresolved(r))
    warning += detail::compose(
        "  warning  the shortest contact, at the impact speed {} that occurred, takes {} steps of "
        "{}, and 20 to 50 are needed: take critical_dt(world, {}) / 5\n",
        text(r.impact_speed_max, 3), text(r.steps_per_contact, 3), r.dt,
        text(r.impact_speed_max, 3));
  warning += detail::doubts({.bodies = r.moving.bodies,
                             .movable = r.moving.movable,
                             .steps = r.steps,
                             .dt = r.dt,
                             .gravity = r.gravity,
                             .radius = r.overlap.mean_radius,
                             .fastest = r.moving.max_speed,
                             .followed = r.followed,
                             .may_follow = r.may_follow,
                             .soft = soft(r),
                             .leap = r.leap});
  const std::string asleep =
      r.sleeping ? detail::compose(", {} of them asleep", r.moving.asleep) : std::string();
  if (r.balancing)
    own = detail::compose(
              "  balance  cuts moved {} times; largest share over the mean one before and after: "
              "bodies {} and {}, contacts {} and {}, time {} and {}\n",
              r.balance.moved, text(r.balance.before.bodies, 3), text(r.balance.after.bodies, 3),
              text(r.balance.before.contacts, 3), text(r.balance.after.contacts, 3),
              text(r.balance.before.time, 3), text(r.balance.after.time, 3)) +
          own;
  const std::string solving =
      soft(r) ? detail::compose("           dt is {} of the critical time step {}\n",
                                text(r.dt / r.critical_dt, 3), text(r.critical_dt, 3))
              : detail::compose(
                    "           residual {} at the end, {} for the worst contact, {} for the worst "
                    "step measured{}; {} iterations per step, {} at most\n",
                    text(r.residual.value, 2), text(r.residual.max, 2),
                    text(r.solved.residual_worst, 2), tolerance, text(mean_iterations(r), 3),
                    r.solved.iterations_max);
  return detail::compose(
      "{}: {} bodies ({} movable{}) on {} rank(s), {}, {} steps of {}\n"
      "  speed    {} ms of processor per step, {} s in all; detect {} %, respond {} %, exchange {} "
      "%\n"
      "  error    overlap {} of the radius on average, {} at most; {} of {} contacts touch\n"
      "{}"
      "  motion   kinetic energy {}, fastest {}, momentum {}\n"
      "  traffic  {} messages and {} bytes per step and rank at most, {} collectives per step\n"
      "  memory   {} bytes per body; state {}\n{}{}",
      r.scenario, r.moving.bodies, r.moving.movable, asleep, r.ranks, r.transport, r.steps, r.dt,
      text(1e3 * r.cpu_seconds / steps, 3), text(r.wall_seconds, 3), percent(r.seconds.detect),
      percent(r.seconds.respond), percent(r.seconds.exchange), text(r.overlap.mean, 2),
      text(r.overlap.max, 2), r.overlap.touching, r.contacts, solving,
      text(r.moving.kinetic_energy, 3), text(r.moving.max_speed, 3), r.moving.momentum,
      r.messages_per_step_max, r.bytes_per_step_max, text(r.collectives_per_step, 6),
      std::lround(r.bytes_per_body), r.digest, own, warning);
}

}  // namespace talus
