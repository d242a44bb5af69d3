#pragma once
// The definitions of summary_text.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/observe/summary_text.hpp"

namespace talus::detail {

TALUS_INLINE std::string counted(std::uint64_t n, const char* one, const char* many) {
  return compose("{} {}", n, n == 1 ? one : many);
}

TALUS_INLINE std::string error_text(const talus::summary& r) {
  const force_balance& b = r.balance_of_forces;
  const char* const more = "           ";
  std::string lines = compose(
      "  error    largest overlap at the end {} of the radius of the smaller body; on average {} "
      "of "
      "the mean radius; {}\n",
      text(r.overlap.deepest, 2), text(r.overlap.mean, 2),
      counted(r.overlap.touching, "contact touches", "contacts touch"));
  if (soft(r)) {
    lines += compose("{}dt is {} of the step beyond which soft contacts gain energy\n", more,
                     text(longest_step(r) / r.critical_dt, 3));
  } else if (made_steps(r)) {
    std::string worst;
    if (r.solved.residual_worst > r.residual.value)
      worst = compose(", by {} in the worst step measured", text(r.solved.residual_worst, 2));
    const double most = static_cast<double>(r.solved.iterations_max);
    lines += compose(
        "{}contact law missed by {} of the impulses in the last step (0: it holds), by {} at the "
        "worst contact{}; {} iterations per step{}\n",
        more, text(r.residual.value, 2), text(r.residual.max, 2), worst,
        text(mean_iterations(r), 3),
        mean_iterations(r) == most ? std::string()
                                   : compose(" on average, {} at most", r.solved.iterations_max));
  }
  if (!b.known) return lines;
  lines += compose("{}fixed bodies bear {} of the weight of the others (1 at rest)", more,
                   text(b.borne, 3));
  if (!soft(r))
    lines += compose(
        "; touching bodies still approach with {} of the momentum that gravity gives in a step",
        text(b.unstopped, 2));
  return lines + "\n";
}

TALUS_INLINE std::string monitors_text(const talus::summary& r) {
  const auto value = [&](std::string_view name) {
    for (const measured& m : r.monitors)
      if (m.name == name) return m.value;
    return std::nan("");
  };
  const auto there = [&](std::string_view name) {
    for (const measured& m : r.monitors)
      if (m.name == name) return true;
    return false;
  };
  std::string lines;
  if (there("overlap_worst"))
    lines +=
        compose("  overlap  deepest in any step: {}{}\n",
                text(value("overlap_worst") * r.overlap.mean_radius, 3), unit_behind("L", r.units));
  if (soft(r) && there("contact_residual"))
    lines += compose(
        "  forces   on a body leave {} of the contact forces unbalanced at the end (0 at rest), {} "
        "in the worst step\n",
        text(value("contact_residual"), 2), text(value("contact_residual_worst"), 2));
  if (there("momentum_error"))
    lines += compose(
        "  momentum all that bodies gained in the last step is accounted for, but for {} of it\n",
        text(value("momentum_error"), 2));
  if (!there("energy_error")) return lines;
  const auto part = [&](std::string_view name) { return text(value(name), 3); };
  const auto if_there = [&](const char* words, std::string_view name) {
    return there(name) ? words + part(name) : std::string();
  };
  return lines +
         compose(
             "  energy   {}{} at the start; since then work on bodies {}{}{}, changes by the "
             "program {}, added by the correction of overlaps {}, by the time stepping {}\n"
             "           lost by friction {}{}, impacts {}, damping {}{}; all is accounted for, "
             "but "
             "for {} of what a step exchanges\n",
             part("energy_initial"), unit_behind("M L^2/T^2", r.units), part("energy_work"),
             if_there(", by motors ", "energy_motors"),
             if_there(", by springs of joints ", "energy_springs"), part("energy_changes"),
             part("energy_correction"), part("energy_scheme"), part("energy_friction"),
             if_there(", friction in joints ", "energy_joint_friction"), part("energy_impact"),
             part("energy_damping"), if_there(", sleep ", "energy_sleep"),
             text(value("energy_error_worst"), 2));
}

TALUS_INLINE std::string ranks_text(const talus::summary& r) {
  if (r.ranks == 1) return {};
  std::string lines;
  if (made_steps(r))
    lines = compose(
        "  traffic  a rank sends at most {} and {} in a step; all ranks together make {} "
        "reductions "
        "per step\n",
        counted(r.messages_per_step_max, "message", "messages"),
        counted(r.bytes_per_step_max, "byte", "bytes"), text(r.collectives_per_step, 6));
  if (r.balancing)
    lines += compose(
        "  balance  cuts moved {}; largest share of a rank over the mean one before and after: "
        "bodies {} and {}, contacts {} and {}, time {} and {}\n",
        counted(r.balance.moved, "time", "times"), text(r.balance.before.bodies, 3),
        text(r.balance.after.bodies, 3), text(r.balance.before.contacts, 3),
        text(r.balance.after.contacts, 3), text(r.balance.before.time, 3),
        text(r.balance.after.time, 3));
  return lines;
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
  using detail::counted, detail::text, detail::unit_behind;
  std::string own;
  for (const auto& [name, value] : r.own)
    ((((own += own.empty() ? "  results  " : ", ") += name) += " ") += text(value, 5));
  if (!own.empty()) own += "\n";
  std::string warning;
  if (above_tolerance(r) || r.solved.steps_above > 0)
    warning = detail::compose(
        "  warning  the contact residual stayed above {} in {} of {}{}: allow more than {} "
        "iterations, or take a smaller dt\n",
        text(r.solver.tolerance, 2), r.solved.steps_above, counted(r.steps, "step", "steps"),
        above_tolerance(r) ? ", the last among them" : "", r.solver.max_iterations);
  if (dt_above_critical(r))
    warning += detail::compose(
        "  warning  dt {}{} is above the critical time step {}{} of the soft contacts: the results "
        "mean nothing; take a fifth of it or less\n",
        text(longest_step(r), 6), unit_behind("T", r.units), text(r.critical_dt, 4),
        unit_behind("T", r.units));
  else if (contacts_unresolved(r))
    warning += detail::compose(
        "  warning  the shortest contact, at the impact speed {}{} that occurred, takes {} steps "
        "of "
        "{}{}, and 20 to 50 are needed: take critical_dt(world, {}) / 5\n",
        text(r.shortest_contact_speed, 3), unit_behind("L/T", r.units),
        text(r.steps_per_contact, 3), text(r.shortest_contact_dt, 6), unit_behind("T", r.units),
        text(r.shortest_contact_speed, 3));
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
                                         .jump = r.jump,
                                         .joint = r.joint});
  warning += detail::islands_warning(r.islands);
  const std::string rules =
      r.pair_rules.empty() ? std::string() : detail::compose("  contacts {}\n", r.pair_rules);
  const std::string asleep =
      r.sleeping ? detail::compose(", {} of them asleep", r.moving.asleep) : std::string();
  const std::string ranks =
      r.ranks > 1 ? detail::compose(" on {} ranks, {}", r.ranks, r.transport) : std::string();
  const std::string lengths =
      r.dt_least < r.dt_most ? text(r.dt_least, 6) + " to " + text(r.dt_most, 6) : text(r.dt, 6);
  const std::string restarted = r.restarted_at > 0
                                    ? detail::compose(", restarted at step {}", r.restarted_at)
                                    : std::string();
  return detail::compose("{}: {} ({} movable{}){}, {} of {}{}{}\n", r.scenario,
                         counted(r.moving.bodies, "body", "bodies"), r.moving.movable, asleep,
                         ranks, counted(r.steps, "step", "steps"), lengths,
                         unit_behind("T", r.units), restarted) +
         detail::time_text(r) + detail::error_text(r) + detail::islands_line(r.islands) + rules +
         detail::compose(
             "  motion   kinetic energy {}{}, fastest body {}{}, momentum of all {}{}\n",
             text(r.moving.kinetic_energy, 3), unit_behind("M L^2/T^2", r.units),
             text(r.moving.max_speed, 3), unit_behind("L/T", r.units), r.moving.momentum,
             unit_behind("M L/T", r.units)) +
         detail::monitors_text(r) + detail::ranks_text(r) +
         detail::compose(
             "  memory   {} per body\n"
             "  state    digest {}: runs that end alike to the last bit have the same\n",
             counted(static_cast<std::uint64_t>(std::lround(r.bytes_per_body)), "byte", "bytes"),
             r.digest) +
         own + warning;
}

}  // namespace talus
