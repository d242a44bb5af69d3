#pragma once
// The summary of a run in figures: speed beside error.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "talus/observe/critical_dt.hpp"
#include "talus/observe/digest.hpp"
#include "talus/observe/memory.hpp"
#include "talus/observe/summary_figures.hpp"
#include "talus/observe/summary_json.hpp"
#include "talus/observe/summary_text.hpp"
#include "talus/state/contact_count.hpp"
#include "talus/state/joint_table.hpp"

namespace talus {

namespace detail {

template <class Scenario>
[[nodiscard]] std::string transport_in_use(world<Scenario>& w) {
  if constexpr (requires { w.link().transport_name(); })
    return w.link().transport_name();
  else
    return Scenario::transport::name;
}

/// Collective: the maximum over all ranks, the first of several equal ones.
template <class Scenario>
[[nodiscard, gnu::cold]] speed_leap largest_leap_of(world<Scenario>& w) {
  const speed_leap& mine = view_of(w).driving.leap;
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

/// Collective: the joint that opened farthest on any rank.
template <class Scenario>
[[nodiscard, gnu::cold]] open_joint worst_open_joint(world<Scenario>& w) {
  auto& s = state_of(w);
  const joint_opening& mine = s.joints.opening;
  std::array<double, 2> most{mine.part, 0};
  w.link().reduce(reduction::max, std::span(most).first(1));
  if (most[0] == 0) return {};
  const bool worst = mine.part == most[0];
  most[1] = worst ? w.ranks() - w.rank() : 0;  // the first of several
  w.link().reduce(reduction::max, std::span(most).last(1));
  const bool it = worst && most[1] == w.ranks() - w.rank();
  std::array<std::uint64_t, 4> all{};
  if (it) all = {mine.step, mine.kind, value_of(mine.key.a), value_of(mine.key.b)};
  double gap = it ? mine.gap : 0;
  w.link().reduce(reduction::max, std::span(all));
  w.link().reduce(reduction::max, std::span(&gap, 1));
  const auto name = [](std::uint64_t id) {
    return id == value_of(id_of_world) ? std::string("the world")
                                       : compose("body {}", system_id{id});
  };
  open_joint x{.step = all[0],
               .kind = {},
               .bodies = compose("{} and {}", name(all[2]), name(all[3])),
               .part = most[0],
               .gap = gap};
  std::uint64_t kinds = 0;
  s.joints.each_kind([&](const auto& of_kind) {
    if (kinds++ == all[1]) x.kind = std::remove_cvref_t<decltype(of_kind)>::kind::name;
  });
  return x;
}

/// The number of steps per contact of a soft scenario, and its stability.
template <class Scenario>
[[gnu::cold]] void report_soft_step(world<Scenario>& w, talus::summary& r) {
  const auto& s = view_of(w);
  const auto scales = measure_soft_scales(w);
  r.critical_dt = std::min(longest_stable_step(w, scales), s.soft.step_of_bonds);
  step_lengths lengths = s.lengths;
  lengths.note(s.soft.fastest_approach);
  std::vector<real> fastest;
  for (const auto& x : lengths.all()) fastest.push_back(x.fastest);
  w.link().reduce(reduction::max, std::span(fastest));
  for (std::size_t k = 0; k < fastest.size(); ++k) {
    const real dt = lengths.all()[k].dt, steps = shortest_contact(w, scales, fastest[k]) / dt;
    r.impact_speed_max = std::max(r.impact_speed_max, double{fastest[k]});
    if (!std::isfinite(steps) || (r.steps_per_contact > 0 && steps >= r.steps_per_contact))
      continue;
    r.steps_per_contact = steps;
    r.shortest_contact_dt = dt, r.shortest_contact_speed = fastest[k];
  }
}

/// Collective: the times of single steps on the slowest rank, where they are measured.
template <class Scenario>
[[gnu::cold]] void report_single_steps(world<Scenario>& w, talus::summary& r) {
  if (view_of(w).single_steps == nullptr) return;
  const step_seconds here = view_of(w).single_steps->found();
  std::array<double, 3> most{here.median, here.p99, here.longest};
  w.link().reduce(reduction::max, most);
  std::array<std::uint64_t, 1> step{here.longest == most[2] ? here.slowest_step : 0};
  w.link().reduce(reduction::max, step);
  r.step_cpu = {most[0], most[1], most[2], step[0]};
}

/// Collective: the times of functions of the program, of outputs and of monitors. Where ranks have
/// different functions, all are functions of the program.
template <class Scenario>
[[gnu::cold]] void report_functions(world<Scenario>& w, talus::summary& r) {
  r.functions = view_of(w).functions.all();
  // A hash of the names, and its complement.
  std::array<std::uint64_t, 2> most{1469598103934665603U, 0};
  for (const auto& one : r.functions)
    for (const char c : one.first + "\n")
      most[0] = (most[0] ^ static_cast<unsigned char>(c)) * 1099511628211U;
  most[1] = ~most[0];
  w.link().reduce(reduction::max, most);
  if (most[0] != ~most[1]) {
    double all = 0;
    for (std::size_t k = 1; k < r.functions.size(); ++k) all += r.functions[k].second;
    r.functions = {r.functions.front(), {name_of_program, all}};
  }
  std::vector<double> seconds;
  for (const auto& one : r.functions) seconds.push_back(one.second);
  std::vector<double> sums = seconds;
  w.link().reduce(reduction::max, std::span(seconds));
  w.link().reduce(reduction::sum, std::span(sums));
  r.functions_mean = r.functions;
  for (std::size_t k = 0; k < seconds.size(); ++k)
    r.functions[k].second = seconds[k], r.functions_mean[k].second = sums[k] / r.ranks;
}

}  // namespace detail

/// Collective: the figures of the present world. `cpu_seconds` are those of this rank.
template <class Scenario>
[[nodiscard, gnu::cold]] summary summarize(world<Scenario>& w, double cpu_seconds,
                                           double wall_seconds) {
  w.require_all_ranks("summarize");
  const auto& s = detail::view_of(w);
  auto& link = w.link();
  summary r;
  r.policies = detail::policies_in_use(s);
  r.transport = detail::transport_in_use(w);
  r.units = w.units();
  r.ranks = w.ranks();
  r.steps = w.steps();
  r.restarted_at = w.restarted_at();
  r.dt = r.dt_least = r.dt_most = s.dt;
  if (const auto& lengths = s.lengths.all(); !lengths.empty())
    r.dt_least = lengths.front().dt, r.dt_most = lengths.back().dt;
  r.time = w.time();
  if constexpr (Scenario::contact_law::soft) detail::report_soft_step(w, r);
  r.sleeping = Scenario::template has_feature<talus::sleeping>;
  r.followed = Scenario::template has_feature<continuous_collision>;
  r.may_follow = !Scenario::contact_law::soft;
  if constexpr (detail::world_state<Scenario>::drives) {
    r.leap = detail::largest_leap_of(w);
    r.jump = s.driving.jump;
  }
  if constexpr (detail::world_state<Scenario>::has_joints) r.joint = detail::worst_open_joint(w);
  if (w.materials().rules() != pair_rules{}) r.pair_rules = w.materials().describe_rules();
  r.gravity = w.gravity().norm();
  r.moving = measure_motion(w);
  r.overlap = measure_penetration(w);
  r.balance_of_forces = measure_force_balance(w);
  r.mixed = !std::is_same_v<detail::solved_scalar<Scenario>, real>;
  if constexpr (!Scenario::contact_law::soft) {
    r.residual = measure_residual(w);
    r.solved = w.convergence();
    r.solver = w.solver();
    r.islands = measure_islands(w);
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
  std::array<double, 4> all{slowest[0], slowest[1], slowest[2], slowest[3]};
  link.reduce(reduction::sum, all);
  for (double& seconds : all) seconds /= r.ranks;
  r.seconds_mean = {all[0], all[1], all[2], all[3]};
  link.reduce(reduction::max, slowest);
  r.seconds = {slowest[0], slowest[1], slowest[2], slowest[3]};
  r.wall_seconds = slowest[4];
  link.reduce(reduction::sum, std::span(&cpu_seconds, 1));
  r.cpu_seconds = cpu_seconds;
  detail::report_functions(w, r);
  detail::report_single_steps(w, r);
  return r;
}

}  // namespace talus
