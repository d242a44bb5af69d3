#pragma once
// The definitions of summary_figures.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/observe/summary_figures.hpp"

namespace talus::detail {

TALUS_INLINE double steps_taken(std::uint64_t steps, std::uint64_t restarted_at) {
  return steps > restarted_at ? static_cast<double>(steps - restarted_at) : 1;
}

}  // namespace talus::detail

namespace talus {

TALUS_INLINE double mean_iterations(const summary& r) {
  return static_cast<double>(r.solved.iterations) /
         static_cast<double>(std::max<std::uint64_t>(1, r.steps));
}

TALUS_INLINE bool above_tolerance(const summary& r) {
  return r.solver.tolerance > 0 && !(r.residual.value <= r.solver.tolerance);
}

TALUS_INLINE bool contacts_unresolved(const summary& r) {
  return r.steps_per_contact > 0 && r.steps_per_contact < detail::steps_of_contact;
}

TALUS_INLINE bool balance_beyond_bound(const summary& r) {
  const force_balance& b = r.balance_of_forces;
  return b.known && (!(b.unstopped <= unstopped_bound) ||
                     !(b.error <= (r.mixed ? balance_bound_mixed : balance_bound)));
}

}  // namespace talus
