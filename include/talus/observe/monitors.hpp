#pragma once
// The values of all monitors of a scenario, by name: for the progress line, the JSON file and time
// series.
#include <string>
#include <string_view>

#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/observe/energy.hpp"
#include "talus/observe/momentum.hpp"
#include "talus/observe/overlaps.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// One number, and its dimension: M mass, L length, T time, 1 for a dimensionless number.
struct measured {
  std::string_view name;
  std::string_view dimension;
  double value = 0;
};

/// The values of the monitors, and a short text.
struct monitor_values {
  detail::plain_vector<measured> values;
  std::string text;  ///< as in ", energy closes to 1e-16"; empty without monitors
};

/// Whether the scenario names a monitor.
template <class Scenario>
inline constexpr bool has_monitors = Scenario::template has_feature<energy_ledger> ||
                                     Scenario::template has_feature<momentum_balance> ||
                                     Scenario::template has_feature<penetration_monitor> ||
                                     Scenario::template has_feature<residual_monitor>;

/// Collective: reads every monitor of the scenario, and costs nothing without monitors.
template <class Scenario>
[[nodiscard, gnu::cold]] monitor_values measure_monitors(world<Scenario>& w) {
  monitor_values m;
  const auto add = [&](std::string_view name, std::string_view dimension, double value) {
    m.values.push_back({name, dimension, value});
  };
  const auto say = [&](std::string_view what, double value) {
    ((((m.text += ", ") += what) += " ") += detail::text(value, 2));
  };
  if constexpr (Scenario::template has_feature<penetration_monitor>) {
    const overlap_account o = measure_overlaps(w);
    add("overlap_mean", "1", o.mean);
    add("overlap_max", "1", o.max);
    add("overlap_worst", "1", o.worst);
    say("overlap", o.mean);
  }
  if constexpr (Scenario::template has_feature<events>) {
    const auto n = total_events(w);
    add("contacts_begun", "1", static_cast<double>(n[0]));
    add("contacts_ended", "1", static_cast<double>(n[1]));
    add("impacts", "1", static_cast<double>(n[2]));
    add("regions_entered", "1", static_cast<double>(n[3]));
    add("regions_left", "1", static_cast<double>(n[4]));
  }
  if constexpr (Scenario::template has_feature<residual_monitor>) {
    const convergence& c = w.convergence();
    add("contact_residual", "1", c.residual);
    add("contact_residual_worst", "1", c.residual_worst);
    say("residual", c.residual);
  }
  if constexpr (Scenario::template has_feature<momentum_balance>) {
    const momentum_account b = measure_momentum(w);
    add("momentum_error", "1", b.error());
    add("borne_weight", "1", b.borne_weight());
    say("momentum", b.error());
  }
  if constexpr (Scenario::template has_feature<energy_ledger>) {
    constexpr std::string_view energy = "M L^2/T^2";
    const energy_balance e = measure_energy(w);
    add("energy_initial", energy, e.initial);
    add("energy_changes", energy, e.changes);
    if constexpr (Scenario::contact_law::soft) add("energy_elastic", energy, e.elastic);
    add("energy_work", energy, e.total.work);
    add("energy_friction", energy, e.total.friction);
    add("energy_impact", energy, e.total.impact);
    add("energy_damping", energy, e.total.damping);
    add("energy_correction", energy, e.total.correction);
    add("energy_scheme", energy, e.total.scheme);
    if constexpr (Scenario::template has_feature<sleeping>)
      add("energy_sleep", energy, e.total.sleep);
    if constexpr (Scenario::joints::size > 0) {
      add("energy_motors", energy, e.total.motors);
      add("energy_springs", energy, e.total.springs);
      add("energy_joint_friction", energy, e.total.joint_friction);
    }
    add("energy_error", "1", e.error());
    add("energy_error_worst", "1", e.worst);
    say("energy", e.error());
  }
  if constexpr (!has_monitors<Scenario>) (void)w, (void)add, (void)say;
  return m;
}

}  // namespace talus
