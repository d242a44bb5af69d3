#pragma once
// The position correction: displacements of bodies that never enter their velocities.
#include <tuple>
#include <type_traits>

#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/each.hpp"
#include "talus/solver/direct/exact_joints.hpp"
#include "talus/solver/island_groups.hpp"

namespace talus::detail {

/// The joints of a solver that sweeps joints together with contacts.
struct swept_joints {
  static constexpr bool at_once = false;
};

/// Gauss-Seidel on the contacts' `relax_correction`; between ranks simultaneously, with divided
/// masses, as the contacts are prepared. Joints that are solved at once follow after each sweep: no
/// mass is divided for them. `ranks` has shared corrections of zero.
template <class Lists, class State, class Ranks, class Joints = swept_joints>
void correct_overlaps(Lists& lists, State& s, const solver_settings& settings, Ranks&& ranks,
                      const Joints& joints = {}) {
  constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
  const auto each = [&](auto&& f) {
    if constexpr (Joints::at_once)
      each_swept(lists, ranks, f);
    else
      each_of(lists, f);
  };
  if (island_groups<Lists, State, alone>::correct(lists, s, settings.correction_iterations)) return;
  for (int k = 0; k < settings.correction_iterations; ++k) {
    const bool shares = !alone && k + 1 < settings.correction_iterations;
    if constexpr (!alone) {
      each([&](auto& list) { list.relax_boundary_correction(s); });
      each([&](auto& list) { list.apply_boundary_correction(s); });
      each([&](auto& list) { list.correct_border(s); });
      if (shares && !Joints::at_once) ranks.start_corrections();
    }
    each([&](auto& list) { list.correct_inner(s); });
    if constexpr (Joints::at_once) joints.correct();
    if constexpr (!alone)
      if (shares) {
        if (Joints::at_once) ranks.start_corrections();
        ranks.finish_corrections();
      }
  }
}

}  // namespace talus::detail
