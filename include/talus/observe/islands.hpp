#pragma once
// Groups of contacts that were solved as one, and those for which that was too expensive.
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "talus/constraint/island_budget.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Statistics of islands (contacts connected through movable bodies) on which sweeps stall, in all
/// steps of this run and on all ranks; see nonlinear_gauss_seidel.
struct islands_solved {
  std::uint64_t solved = 0;            ///< number of islands solved as one problem
  std::uint64_t skipped = 0;           ///< number of islands that were too expensive
  std::uint64_t skipped_contacts = 0;  ///< contacts of the largest of these
};

/// Collective; contacts are hard.
template <class Scenario>
[[nodiscard, gnu::cold]] islands_solved measure_islands(world<Scenario>& w) {
  w.require_all_ranks("measure_islands");
  const detail::island_budget& done = detail::view_of(w).solver.islands;
  std::array<std::uint64_t, 2> sums{done.islands_solved(), done.skipped()};
  std::uint64_t most = done.skipped_contacts();
  w.link().reduce(reduction::sum, sums);
  w.link().reduce(reduction::max, std::span(&most, 1));
  return {sums[0], sums[1], most};
}

namespace detail {

/// A line of the summary; empty if there was nothing to solve.
[[nodiscard, gnu::cold]] inline std::string islands_line(const islands_solved& r) {
  if (r.solved == 0 && r.skipped == 0) return {};
  return compose(
      "  islands  {} {} of contacts on which the iterations stalled, each solved as one{}\n",
      r.solved, r.solved == 1 ? "group" : "groups",
      r.skipped > 0 ? compose("; {} left to the iterations", r.skipped) : std::string());
}
[[nodiscard, gnu::cold]] inline std::string islands_warning(const islands_solved& r) {
  if (r.skipped == 0) return {};
  return compose(
      "  warning  groups of contacts that stall were left to the iterations, because solving one "
      "costs more than a step may spend; times: {}, contacts of the largest: {}; what is heavy on "
      "them may sink: give more iterations\n",
      r.skipped, r.skipped_contacts);
}

}  // namespace detail
}  // namespace talus
