#pragma once
// The definitions of summary_json.hpp, in the compiled part or in each program.
#include <algorithm>

#include "talus/core/linkage.hpp"
#include "talus/core/shown_text.hpp"
#include "talus/observe/summary_json.hpp"

namespace talus::detail {

TALUS_INLINE void json_object::add(std::string_view key, std::string_view text) {
  put(key, detail::quoted_text(text));
}

TALUS_INLINE void json_object::add(std::string_view key, double value) {
  put(key, std::isfinite(value) ? detail::text(value) : "null");
}

TALUS_INLINE void json_object::add(std::string_view key, std::same_as<bool> auto value) {
  put(key, value ? "true" : "false");
}

TALUS_INLINE void json_object::put(std::string_view key, const std::string& value) {
  if (!text_.empty()) text_ += ",\n";
  ((((text_ += "  \"") += key) += "\": ") += value);
  keys_.emplace_back(key);
}

TALUS_INLINE bool json_object::has(std::string_view key) const {
  return std::find(keys_.begin(), keys_.end(), key) != keys_.end();
}

}  // namespace talus::detail

namespace talus {

TALUS_INLINE std::string to_json(const summary& r) {
  detail::json_object o;
  o.add("scenario", r.scenario);
  o.add("policies", r.policies);
  o.add("transport", r.transport);
  o.add("ranks", r.ranks);
  o.add("steps", r.steps);
  if (!r.units.length.empty()) o.add("unit_length", r.units.length);
  if (!r.units.mass.empty()) o.add("unit_mass", r.units.mass);
  if (!r.units.time.empty()) o.add("unit_time", r.units.time);
  if (!r.ended.empty()) o.add("ended_by", r.ended);
  if (r.restarted_at > 0) o.add("restarted_at", r.restarted_at);
  o.add("dt", r.dt);
  if (r.dt_least < r.dt_most) o.add("dt_least", r.dt_least), o.add("dt_most", r.dt_most);
  if (soft(r)) {
    o.add("critical_dt", r.critical_dt);
    o.add("dt_above_critical", int{dt_above_critical(r)});
    o.add("impact_speed_max", r.impact_speed_max);
    if (r.steps_per_contact > 0) o.add("steps_per_contact", r.steps_per_contact);
  }
  o.add("bodies", r.moving.bodies);
  o.add("bodies_movable", r.moving.movable);
  if (r.sleeping) o.add("bodies_asleep", r.moving.asleep);
  if (made_steps(r)) o.add("contacts", r.contacts);
  o.add("touching_contacts", r.overlap.touching);
  o.add("penetration_mean", r.overlap.mean);
  o.add("penetration_max", r.overlap.max);
  o.add("gap_mean_loaded", r.overlap.gap_mean_loaded);
  o.add("mean_radius", r.overlap.mean_radius);
  o.add("overlap_over_radius", r.overlap.deepest);
  o.add("overlap_beyond_bound", overlap_beyond_bound(r));
  if (r.balance_of_forces.known) {
    o.add("balance_borne_weight", r.balance_of_forces.borne);
    if (!soft(r)) {
      o.add("balance_momentum_change", r.balance_of_forces.change);
      o.add("balance_momentum_error", r.balance_of_forces.error);
      o.add("balance_unstopped", r.balance_of_forces.unstopped);
    }
    o.add("balance_beyond_bound", balance_beyond_bound(r));
  }
  if (!soft(r)) {
    if (made_steps(r)) o.add("residual", r.residual.value), o.add("residual_max", r.residual.max);
    o.add("residual_worst", r.solved.residual_worst);
    o.add("tolerance", r.solver.tolerance);
    o.add("residual_above_tolerance", above_tolerance(r));
    o.add("steps_above_tolerance", r.solved.steps_above);
    o.add("iterations_mean", mean_iterations(r));
    o.add("iterations_max", r.solved.iterations_max);
    o.add("islands_solved", r.islands.solved);
    o.add("islands_skipped", r.islands.skipped);
    o.add("islands_skipped_contacts", r.islands.skipped_contacts);
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
  if (r.step_cpu.longest > 0) {
    o.add("cpu_seconds_per_step_median", r.step_cpu.median);
    o.add("cpu_seconds_per_step_p99", r.step_cpu.p99);
    o.add("cpu_seconds_per_step_longest", r.step_cpu.longest);
    o.add("slowest_step", r.step_cpu.slowest_step);
  }
  o.add("seconds_detect", r.seconds.detect);
  o.add("seconds_respond", r.seconds.respond);
  o.add("seconds_integrate", r.seconds.integrate);
  o.add("seconds_exchange", r.seconds.exchange);
  for (const auto& [name, seconds] : r.functions) {
    std::string key = "seconds";
    bool joint = true;
    for (const char c : name) {
      const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
      if (plain && joint) key += '_';
      joint = !plain;
      if (plain) key += c;
    }
    while (o.has(key)) key += '_';
    o.add(key, seconds);
  }
  if (made_steps(r)) {
    o.add("messages_per_step_max", r.messages_per_step_max);
    o.add("bytes_per_step_max", r.bytes_per_step_max);
    o.add("collectives_per_step", r.collectives_per_step);
  }
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
  for (const auto& [name, value] : r.own) {
    std::string key = name;
    while (o.has(key)) key = "result_" + key;
    o.add(key, value);
  }
  return o.str();
}

}  // namespace talus
