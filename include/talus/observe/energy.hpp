#pragma once
// The sources and sinks of the energy of a run.
#include <cmath>
#include <span>

#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The energy ledger of all bodies that are not global. Units: mass times length^2 over time^2.
/// kinetic + potential + elastic = initial + changes + total.net(), to round-off.
struct energy_balance {
  double kinetic = 0;    ///< of translation and rotation, now
  double potential = 0;  ///< -m g . x, with respect to the origin, now
  double elastic = 0;    ///< in the springs of soft contacts, at the end of the last step
  double initial = 0;    ///< all energy at the start of the first step
  double changes = 0;    ///< by the user between steps: bodies added, removed, moved, pushed; and
                         ///< by bodies that cross a periodic face along gravity
  energy_flows step;     ///< in the last step
  energy_flows total;    ///< in all steps
  double closure = 0;    ///< change of energy in the last step, minus step.net(): round-off
  double scale = 0;      ///< sum over the bodies and contacts of the energies in that step
  double worst = 0;      ///< largest |closure| over scale of any rank in any step

  /// The closure of the last step over the sum of its energies.
  [[nodiscard]] double error() const { return scale > 0 ? std::abs(closure) / scale : 0; }
};

/// Collective: sums the ledger exactly over all ranks. Needs features<energy_ledger>.
template <class Scenario>
[[nodiscard]] energy_balance measure_energy(world<Scenario>& w) {
  energy_balance b;
  if constexpr (detail::require_feature<Scenario, energy_ledger>()) {
    w.require_all_ranks("measure_energy");
    detail::close_ledger(detail::state_of(w));
    detail::energy_entries r = detail::view_of(w).monitors.energy;
    detail::spring_record springs;
    detail::energy_sums now = detail::energy_of(detail::view_of(w));
    if (!r.started)
      r.initial = now.all();
    else
      (r.changes += now.all()) -= r.after.all();
    if constexpr (Scenario::contact_law::soft) springs = detail::view_of(w).monitors.springs;
    springs.work_elsewhere = {};  // 0 in the sum over the ranks
    detail::sum_exactly(w.link(), now.kinetic, now.potential, r.initial, r.changes, r.exchanged);
    for (detail::energy_sums* x : {&r.before, &r.after})
      detail::sum_exactly(w.link(), x->kinetic, x->potential, x->scale);
    for (detail::flow_sums* x : {&r.step, &r.total})
      x->each([&](auto&... sums) { detail::sum_exactly(w.link(), sums...); });
    detail::sum_exactly(w.link(), springs.start, springs.stored, springs.moved);
    b.kinetic = now.kinetic.value(), b.potential = now.potential.value();
    b.elastic = springs.stored.value();
    b.initial = r.initial.value(), b.changes = r.changes.value();
    b.step = r.step.value(), b.total = r.total.value();
    detail::signed_sum left = detail::closure_of(r, springs);
    if constexpr (detail::world_state<Scenario>::has_joints) {
      detail::drive_record drives = detail::view_of(w).monitors.drives;
      for (detail::drive_sums* x : {&drives.step, &drives.total})
        x->each([&](auto&... sums) { detail::sum_exactly(w.link(), sums...); });
      drives.step.add_to(b.step), drives.total.add_to(b.total);
      left -= drives.step.net();
    }
    b.closure = left.value(), b.scale = detail::scale_of(r, springs);
    b.worst = r.worst;
    w.link().reduce(reduction::max, std::span(&b.worst, 1));
  }
  return b;
}

}  // namespace talus
