#pragma once
// The position correction: displacements of bodies that never enter their velocities.
#include <tuple>
#include <type_traits>

#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/each.hpp"

namespace talus::detail {

/// Gauss-Seidel on the contacts' `relax_correction`; between ranks simultaneously, with divided
/// masses, as the contacts are prepared. `ranks` has shared corrections of zero.
template <class Lists, class State, class Ranks>
void correct_overlaps(Lists& lists, State& s, const solver_settings& settings, Ranks&& ranks) {
  const auto each = [&](auto&& f) { each_of(lists, f); };
  constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
  for (int k = 0; k < settings.correction_iterations; ++k) {
    const bool last = k + 1 == settings.correction_iterations;
    if constexpr (!alone) {
      each([&](auto& list) { list.relax_boundary_correction(s); });
      each([&](auto& list) { list.apply_boundary_correction(s); });
      each([&](auto& list) { list.correct_border(s); });
      if (!last) ranks.start_corrections();
    }
    each([&](auto& list) { list.correct_inner(s); });
    if constexpr (!alone)
      if (!last) ranks.finish_corrections();
  }
}

}  // namespace talus::detail
