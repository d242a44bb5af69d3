#pragma once
// The definitions of summary_text.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/observe/summary_text.hpp"

namespace talus::detail {

TALUS_INLINE std::string counted(std::uint64_t n, const char* one, const char* many) {
  return compose("{} {}", n, n == 1 ? one : many);
}

TALUS_INLINE time_shares::time_shares(const stage_seconds& s, double wall) {
  const double unit = 100 / std::max({wall, s.detect + s.respond + s.exchange, 1e-9});
  detect = std::lround(unit * s.detect);
  respond = std::lround(unit * (s.detect + s.respond)) - detect;
  exchange = std::lround(unit * (s.detect + s.respond + s.exchange)) - detect - respond;
}

TALUS_INLINE std::string balance_text(const talus::summary& r) {
  const force_balance& b = r.balance_of_forces;
  std::string line = "           ";
  if (b.known) {
    line += compose("what is fixed bears {} of the weight", text(b.borne, 3));
    if (!soft(r))
      line += compose(
          ", momentum changes by {} of it, contacts leave {} of it unstopped (balance to {})",
          text(b.change, 3), text(b.unstopped, 2), text(b.error, 1));
    line += "; ";
  }
  return line +
         compose("largest overlap {} of the radius of its body\n", text(r.overlap.deepest, 2));
}

TALUS_INLINE std::string balance_warnings(const talus::summary& r) {
  const force_balance& b = r.balance_of_forces;
  const char* const cure = soft(r) ? "take stiffer contacts with a smaller dt"
                                   : "allow more iterations (--iterations, or --tolerance), take a "
                                     "smaller dt, or put less weight on light bodies";
  std::string all;
  if (overlap_beyond_bound(r))
    all += compose(
        "  warning  bodies overlap by up to {} of their radius, more than {}, whatever the "
        "residual says: {}\n",
        text(r.overlap.deepest, 2), text(overlap_bound(r), 2), cure);
  if (!balance_beyond_bound(r)) return all;
  if (!(b.unstopped <= unstopped_bound))
    all += compose(
        "  warning  the momentum balance is wrong: bodies go on into those that they touch, with "
        "{} times the impulse of the weight in a step (at most {}), while what is fixed bears {} "
        "of the weight, whatever the residual says: {}\n",
        text(b.unstopped, 2), text(unstopped_bound, 2), text(b.borne, 3), cure);
  else
    all += compose(
        "  warning  the momentum balance does not close: contacts gave the bodies {} of the weight "
        "more or less than came from what is fixed: this is a fault of talus, please report it\n",
        text(b.error, 2));
  return all;
}

}  // namespace talus::detail

namespace talus {

TALUS_INLINE std::string to_text(const summary& r) {
  const double steps = detail::steps_taken(r.steps, r.restarted_at);
  const detail::time_shares percent(r.seconds_mean, r.wall_seconds);
  using detail::counted, detail::text;
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
        "  warning  the contact residual stayed above {} in {} of {}{}: allow more than {} "
        "iterations, or take a smaller dt\n",
        text(r.solver.tolerance, 2), r.solved.steps_above, counted(r.steps, "step", "steps"),
        above_tolerance(r) ? ", the last among them" : "", r.solver.max_iterations);
  if (dt_above_critical(r))
    warning += detail::compose(
        "  warning  dt {} is above the critical time step {} of the soft contacts: the results "
        "mean nothing; take a fifth of it or less\n",
        text(longest_step(r), 6), text(r.critical_dt, 4));
  else if (contacts_unresolved(r))
    warning += detail::compose(
        "  warning  the shortest contact, at the impact speed {} that occurred, takes {} steps of "
        "{}, and 20 to 50 are needed: take critical_dt(world, {}) / 5\n",
        text(r.shortest_contact_speed, 3), text(r.steps_per_contact, 3),
        text(r.shortest_contact_dt, 6), text(r.shortest_contact_speed, 3));
  warning += detail::balance_warnings(r);
  warning += detail::warnings_of_scales({.bodies = r.moving.bodies,
                                         .movable = r.moving.movable,
                                         .steps = r.steps,
                                         .dt = r.dt,
                                         .dt_most = r.dt_most,
                                         .time = r.time,
                                         .gravity = r.gravity,
                                         .radius = r.overlap.mean_radius,
                                         .fastest = r.moving.max_speed,
                                         .followed = r.followed,
                                         .may_follow = r.may_follow,
                                         .soft = soft(r),
                                         .leap = r.leap,
                                         .joint = r.joint});
  warning += detail::islands_warning(r.islands);
  own = detail::islands_line(r.islands) + own;
  if (!r.pair_rules.empty()) own = detail::compose("  contacts {}\n", r.pair_rules) + own;
  const std::string asleep =
      r.sleeping ? detail::compose(", {} of them asleep", r.moving.asleep) : std::string();
  if (r.balancing)
    own = detail::compose(
              "  balance  cuts moved {}; largest share over the mean one before and after: "
              "bodies {} and {}, contacts {} and {}, time {} and {}\n",
              counted(r.balance.moved, "time", "times"), text(r.balance.before.bodies, 3),
              text(r.balance.after.bodies, 3), text(r.balance.before.contacts, 3),
              text(r.balance.after.contacts, 3), text(r.balance.before.time, 3),
              text(r.balance.after.time, 3)) +
          own;
  const std::string lengths =
      r.dt_least < r.dt_most ? text(r.dt_least, 6) + " to " + text(r.dt_most, 6) : text(r.dt, 6);
  const std::string solving =
      soft(r) ? detail::compose("           dt is {} of the critical time step {}\n",
                                text(longest_step(r) / r.critical_dt, 3), text(r.critical_dt, 3))
              : detail::compose(
                    "           residual {} at the end, {} for the worst contact, {} for the worst "
                    "step measured{}; iterations per step: {} on average, {} at most\n",
                    text(r.residual.value, 2), text(r.residual.max, 2),
                    text(r.solved.residual_worst, 2), tolerance, text(mean_iterations(r), 3),
                    r.solved.iterations_max);
  return detail::compose(
      "{}: {} ({} movable{}) on {}, {}, {} of {}\n"
      "  speed    {} ms of processor per step, {} s in all; of the time of a rank: detect {} %, "
      "respond {} %, exchange {} %\n"
      "  error    overlap {} of the radius on average, {} at most; {} at the end, {} in the last "
      "step\n"
      "{}{}"
      "  motion   kinetic energy {}, fastest {}, momentum {}\n"
      "  traffic  {} and {} per step and rank at most, {} collectives per step\n"
      "  memory   {} per body\n"
      "  state    digest {}\n{}{}",
      r.scenario, counted(r.moving.bodies, "body", "bodies"), r.moving.movable, asleep,
      counted(static_cast<std::uint64_t>(r.ranks), "rank", "ranks"), r.transport,
      counted(r.steps, "step", "steps"), lengths, text(1e3 * r.cpu_seconds / steps, 3),
      text(r.wall_seconds, 3), percent.detect, percent.respond, percent.exchange,
      text(r.overlap.mean, 2), text(r.overlap.max, 2),
      counted(r.overlap.touching, "contact touches", "contacts touch"),
      counted(r.contacts, "contact was considered", "contacts were considered"), solving,
      detail::balance_text(r), text(r.moving.kinetic_energy, 3), text(r.moving.max_speed, 3),
      r.moving.momentum, counted(r.messages_per_step_max, "message", "messages"),
      counted(r.bytes_per_step_max, "byte", "bytes"), text(r.collectives_per_step, 6),
      counted(static_cast<std::uint64_t>(std::lround(r.bytes_per_body)), "byte", "bytes"), r.digest,
      own, warning);
}

}  // namespace talus
