#pragma once
// Gauss-Seidel in an order that depends on ids alone: the same bits on any number of ranks.
#include <cstdint>
#include <type_traits>

#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/each.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/policy.hpp"
#include "talus/solver/coloured_list.hpp"
#include "talus/solver/convergence.hpp"
#include "talus/solver/direct/exact_joints.hpp"
#include "talus/solver/finish_impacts.hpp"

namespace talus {

/// Sweeps over the contacts colour by colour, each solved exactly for its cone with all others held
/// (nonlinear block Gauss-Seidel; Jourdan, Alart, Jean 1998). No two pairs of one colour share a
/// body, so their order has no effect, and colours depend on the ids of the bodies alone (see
/// solver/colouring.hpp). Both ranks compute the contacts between their bodies, equal to the last
/// bit, from velocities that are exchanged before each colour that needs them. So the trajectory
/// does not depend on the number of ranks, on the decomposition, or on the position of bodies in
/// memory, and momentum is conserved as on one rank. Each rank also solves the contacts of other
/// ranks on which its own depend within a sweep (see solver/dependence_cones.hpp), so that mostly
/// one message for each iteration suffices. Joints are solved all at once before the first sweep
/// and after each, those of an island on several ranks on each of them alike (see
/// solver/direct/exact_joints.hpp).
struct coloured_gauss_seidel final {
  using talus_part_of = roles::solver;
  static constexpr const char* name = "coloured_gauss_seidel";
  static constexpr bool by_colours = true;
  static constexpr bool solves_joints = true;

  /// Solves the contacts as nonlinear_gauss_seidel::solve does; the contacts in `lists` are
  /// coloured. `ranks` has the number of colours.
  template <class Lists, class State, class Ranks>
  static detail::solved solve(Lists& lists, State& s, const solver_settings& settings, bool correct,
                              Ranks&& ranks) {
    const auto each = [&](auto&& f) { detail::each_of(lists, f); };
    constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
    const std::uint32_t colours = ranks.colours();

    detail::convergence_watch<Lists, Ranks, State, detail::exact_sum> watch(lists, s, settings,
                                                                            ranks);
    each([&](auto& list) { list.prepare(s); });
    for (std::uint32_t c = 0; c < colours; ++c) each([&](auto& list) { list.warm_start(s, c); });

    detail::exact_joints<Lists, State, std::remove_reference_t<Ranks>, true> joints(s, ranks);
    // Contacts must not meet the impulses that joints have had in an impact of the last step.
    joints.solve(s);
    detail::impact_schedule impacts(settings.iterations, watch.monitored(), s.rebounds);
    const auto sweep = [&] {
      for (std::uint32_t c = 0; c < colours; ++c) {
        if constexpr (!alone) ranks.start_velocities(c);
        detail::each_swept(lists, ranks, [&](auto& list) { list.sweep(s, c, false); });
        if constexpr (alone) continue;
        ranks.finish_velocities(c);
        detail::each_swept(lists, ranks, [&](auto& list) { list.sweep(s, c, true); });
      }
    };
    const bool exact = ranks.find_islands();
    int k = 0;
    for (; k < watch.limit(); ++k) {
      if constexpr (!alone)
        if (watch.due(k)) ranks.share_velocities();
      if (watch.reached(k)) {
        if (!impacts.begins(k)) break;
        watch.look_again();
      }
      if (s.finishes && k == impacts.first())
        detail::finish_impacts(s, ranks, detail::impact_stage::release, [&](int) { sweep(); });
      s.stage = impacts.stage(k);
      if (exact && (watch.monitored() || k + 2 >= watch.limit())) ranks.note_islands(lists);
      sweep();
      joints.solve(s);
      watch.poll();
    }
    if (s.finishes && s.stage == detail::impact_stage::strike)
      detail::finish_impacts(s, ranks, detail::impact_stage::strike, [&](int) { sweep(); });
    s.stage = detail::impact_stage::none;
    if (exact && k > 0) ranks.solve_islands(lists);
    joints.share_loads(lists, s);
    const detail::solved done = watch.end(k, [&] { ranks.share_velocities(); });

    if (correct)
      for (int j = 0; j < settings.correction_iterations; ++j)
        for (std::uint32_t c = 0; c < colours; ++c) {
          const bool first = j == 0 && c == 0;  // all are zero on all ranks
          if constexpr (!alone)
            if (!first) ranks.start_corrections(c);
          each([&](auto& list) { list.correct(s, c, false); });
          if constexpr (alone) continue;
          if (!first) ranks.finish_corrections(c);
          each([&](auto& list) { list.correct(s, c, true); });
        }
    return done;
  }
};

/// The solver for trajectories that are the same to the last bit on any number of ranks.
using reproducible = coloured_gauss_seidel;

}  // namespace talus
