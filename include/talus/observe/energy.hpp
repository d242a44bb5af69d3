#pragma once
// The sources and sinks of the energy of a run.
#include <array>
#include <cmath>

#include "talus/world/world.hpp"

namespace talus {

/// The energy ledger of all bodies that are not global. Units: mass times length^2 over time^2.
/// kinetic + potential + elastic = initial + changes + total.net(), to round-off.
struct energy_balance {
  double kinetic = 0;    ///< of translation and rotation, now
  double potential = 0;  ///< -m g . x, with respect to the origin, now
  double elastic = 0;    ///< in the springs of soft contacts, at the end of the last step
  double initial = 0;    ///< all energy at the start of the first step
  double changes = 0;    ///< by the user between steps: bodies added, removed, moved, pushed
  energy_flows step;     ///< in the last step
  energy_flows total;    ///< in all steps
  double closure = 0;    ///< change of energy in the last step, minus step.net(): round-off
  double scale = 0;      ///< sum over the bodies and contacts of the energies in that step
  double worst = 0;      ///< largest |closure| over scale of any rank in any step

  /// The closure of the last step over the sum of its energies.
  [[nodiscard]] double error() const { return scale > 0 ? std::abs(closure) / scale : 0; }
};

/// Collective: sums the ledger over all ranks. Needs features<energy_ledger>.
template <class Scenario>
[[nodiscard]] energy_balance measure_energy(world<Scenario>& w) {
  energy_balance b;
  if constexpr (detail::require_feature<Scenario, energy_ledger>()) {
    w.require_all_ranks("measure_energy");
    const auto& r = detail::view_of(w).monitors.energy;
    const detail::energy_sums now = detail::energy_of(detail::view_of(w));
    const double energy = now.kinetic + now.potential, then = r.after.kinetic + r.after.potential;
    std::array<double, 21> sums{now.kinetic,
                                now.potential,
                                r.started ? r.initial : energy,
                                r.started ? r.changes + (energy - then) : 0,
                                r.closure,
                                r.scale,
                                r.step.work,
                                r.step.friction,
                                r.step.impact,
                                r.step.damping,
                                r.step.correction,
                                r.step.scheme,
                                r.total.work,
                                r.total.friction,
                                r.total.impact,
                                r.total.damping,
                                r.total.correction,
                                r.total.scheme,
                                0,
                                r.step.sleep,
                                r.total.sleep};
    if constexpr (Scenario::contact_law::soft)
      sums[18] = detail::view_of(w).monitors.springs.stored;
    w.link().reduce(reduction::sum, sums);
    b.worst = r.worst;
    w.link().reduce(reduction::max, std::span(&b.worst, 1));
    b.kinetic = sums[0], b.potential = sums[1], b.initial = sums[2], b.changes = sums[3];
    b.closure = sums[4], b.scale = sums[5], b.elastic = sums[18];
    b.step = {sums[6], sums[7], sums[8], sums[9], sums[10], sums[11], sums[19]};
    b.total = {sums[12], sums[13], sums[14], sums[15], sums[16], sums[17], sums[20]};
  }
  return b;
}

}  // namespace talus
