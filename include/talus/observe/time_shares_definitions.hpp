#pragma once
// The definitions of time_shares.hpp, in the compiled part or in each program.
#include <algorithm>
#include <cmath>

#include "talus/core/linkage.hpp"
#include "talus/observe/time_shares.hpp"

namespace talus::detail {

TALUS_INLINE results time_shares(const talus::summary& r, std::string& small) {
  const stage_seconds& s = r.seconds_mean;
  results all{{"search for contacts", s.detect},
              {soft(r) ? "contact forces" : "contact solver", s.respond},
              {"integration", s.integrate}};
  if (r.ranks > 1) all.emplace_back("messages between ranks", s.exchange);
  const std::size_t stages = all.size();
  all.insert(all.end(), r.functions_mean.begin(), r.functions_mean.end());
  // One rank has nobody to exchange bodies with: that is the first entry, other work of steps.
  if (r.ranks == 1 && all.size() > stages) all[stages].second += s.exchange;
  double sum = 0;
  for (const auto& one : all) sum += one.second;
  const double unit = 100 / std::max({r.wall_seconds, sum, 1e-9});
  results shares;
  double exact = 0;  // of those that are listed
  long listed = 0;
  for (const auto& [name, seconds] : all) {
    const double part = unit * seconds;
    if (part < 1) {
      if (seconds > 0) (small += small.empty() ? "" : ", ") += name;
      continue;
    }
    exact += part;
    const long share = std::lround(exact) - listed;
    listed += share;
    shares.emplace_back(name, static_cast<double>(share));
  }
  shares.emplace_back("set-up and the rest", static_cast<double>(100 - listed));
  return shares;
}

TALUS_INLINE std::string time_text(const talus::summary& r) {
  const double steps = steps_taken(r.steps, r.restarted_at);
  const auto per_step = [&](double seconds) {
    return made_steps(r) ? compose(", {} ms per step", text(1e3 * seconds / steps, 3)) : "";
  };
  std::string lines =
      compose("  time     {} s of wall time{}; {} s of CPU time{}{}\n", text(r.wall_seconds, 3),
              per_step(r.wall_seconds), text(r.cpu_seconds, 3), r.ranks > 1 ? " of all ranks" : "",
              per_step(r.cpu_seconds));
  if (const step_seconds& one = r.step_cpu; one.longest > 0)
    lines += compose(
        "           CPU time of a step{}: {} ms in the median, at most {} ms in 99 of 100, {} ms "
        "in "
        "the slowest (step {})\n",
        r.ranks > 1 ? " on the slowest rank" : "", text(1e3 * one.median, 3),
        text(1e3 * one.p99, 3), text(1e3 * one.longest, 3), one.slowest_step);
  std::string small, line = "           ";
  line += r.ranks > 1 ? "wall time of a rank:" : "wall time:";
  constexpr std::size_t widest = 100;
  const auto add = [&](const std::string& words) {
    if (line.size() + words.size() >= widest) lines += line + "\n", line = "          ";
    (line += " ") += words;
  };
  const results shares = time_shares(r, small);
  for (const auto& share : shares)
    add(compose("{} {} %{}", share.first, static_cast<long>(share.second),
                &share == &shares.back() ? "" : ","));
  if (!small.empty()) add("(less than 1 % each: " + small + ")");
  return lines + line + "\n";
}

}  // namespace talus::detail
