#pragma once
// Nonlinear block Gauss-Seidel over ranks: the default contact solver.
#include <algorithm>
#include <tuple>
#include <type_traits>

#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/each.hpp"
#include "talus/core/policy.hpp"
#include "talus/solver/contact_list.hpp"
#include "talus/solver/convergence.hpp"
#include "talus/solver/correct_overlaps.hpp"
#include "talus/solver/direct/direct_islands.hpp"
#include "talus/solver/direct/exact_joints.hpp"
#include "talus/solver/finish_impacts.hpp"
#include "talus/solver/island_groups.hpp"
#include "talus/solver/sweep.hpp"

namespace talus {

/// Sweeps over the contacts, each solved exactly for its cone with all others held (nonlinear block
/// Gauss-Seidel; Jourdan, Alart, Jean 1998), started from the impulses of the last step. Between
/// ranks, momentum is conserved thus: boundary contacts are solved simultaneously, from the
/// velocities that both ranks hold alike, with the mass of each body split among its boundary pairs
/// so that the simultaneous step cannot overshoot (Tonge, Benevolenski, Voroshilov 2012); then each
/// rank sweeps its interior contacts, those of border bodies first: their velocities are sent while
/// the others are swept. Islands on which sweeps stall, such as a heavy body on light ones or a
/// tall wall, are balanced from the top down or solved by Newton's method after the last of them
/// (see solver/direct/stalled_islands.hpp). Joints are solved all at once, exactly, after each
/// sweep over contacts, those of an island on several ranks on each of them (see
/// solver/direct/exact_joints.hpp). After a step that left nothing to
/// change, a single rank sweeps once, and more often only if that changes anything.
struct nonlinear_gauss_seidel final {
  using talus_part_of = roles::solver;
  static constexpr const char* name = "nonlinear_gauss_seidel";
  static constexpr bool solves_shared_islands = true;
  static constexpr bool solves_joints = true;

  /// Solves the contact problem in `lists` (a tuple of contact lists). `ranks` refreshes the shadow
  /// copies: share_velocities_and_counts(), share_velocities() or its two halves start_velocities()
  /// and finish_velocities(), and likewise for corrections.
  template <class Lists, class State, class Ranks>
  static detail::solved solve(Lists& lists, State& s, const solver_settings& settings, bool correct,
                              Ranks&& ranks) {
    const auto each = [&](auto&& f) { detail::each_swept(lists, ranks, f); };
    constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
    constexpr bool joined = detail::solves_joints_at_once<Lists, Ranks>;

    using groups = detail::island_groups<Lists, State, alone>;

    detail::convergence_watch<Lists, Ranks, State> watch(lists, s, settings, ranks);
    groups::find(lists, s);
    each([&](auto& list) { list.prepare_interior(s); });
    if constexpr (!alone) ranks.look_for_shared_islands(lists);
    each([&](auto& list) { list.warm_start(s); });
    if constexpr (joined) ranks.warm_start_joints();
    if constexpr (!alone) {
      each([&](auto& list) { list.count_boundary(s); });
      ranks.share_velocities_and_counts();
      each([&](auto& list) { list.prepare_boundary(s); });
      ranks.solve_shared_islands(lists);
    }

    detail::exact_joints<Lists, State, std::remove_reference_t<Ranks>> joints(s, ranks);
    if constexpr (joined) ranks.prepare_joints();
    const bool looks = s.islands.due();
    // A step after one that left nothing to change, on one rank, may need a single sweep.
    const bool settled = ranks.single() && !detail::has_joints<Lists> && looks &&
                         s.islands.settled() && !s.impacts && !watch.monitored();
    detail::impact_schedule impacts(settings.iterations, watch.monitored(),
                                    s.rebounds && (!alone || s.impacts));
    // Stalled islands are solved after the last sweep that does not strike.
    const int exact =
        s.impacts ? std::min(impacts.first(), settings.iterations) : settings.iterations;
    const auto relax_boundary = [&] {
      if constexpr (alone) return;
      each([&](auto& list) { list.relax_boundary(s); });
      each([&](auto& list) { list.apply_boundary(s); });
    };
    // Sweeps before this one follow each other without anything between them.
    const int plain = watch.monitored() || s.impacts ? 0 : looks ? exact - 1 : settings.iterations;
    const auto sweep = [&](int j) {
      relax_boundary();
      joints.sweep(lists, s, j % 2 == 0, true, ranks);
    };
    int k = 0;
    for (; k < watch.limit(); ++k) {
      if (k < plain && (k > 0 || !settled) && groups::sweep(lists, s, k, plain)) {
        k = plain;
        if (k == watch.limit()) break;
      }
      if (watch.reached(k)) {
        if (!impacts.begins(k)) break;
        watch.look_again();
      }
      if (k == impacts.first()) {
        if (s.finishes) detail::finish_impacts(s, ranks, detail::impact_stage::release, sweep);
        if constexpr (!alone) ranks.before_strikes(), ranks.share_velocities();
      }
      s.stage = impacts.stage(k);
      relax_boundary();
      // Velocities are shared once before the first strike, after before_strikes().
      const bool more = k + 1 < watch.limit() && (s.finishes || k + 1 != impacts.first());
      const bool first = settled && k == 0;
      if (first || (looks && k + 1 == exact)) {
        const bool done =
            detail::solve_stalled_islands<State>(detail::access_to<State>(lists), s, first);
        s.islands.settle(done);
        if (first && done) {
          k = 1;
          break;
        }
        joints.solve(s);
        if constexpr (!alone && !joined)
          if (more) ranks.share_velocities();
      } else {
        joints.sweep(lists, s, k % 2 == 0, more, ranks);
      }
      watch.poll();
    }
    if (s.finishes && s.stage == detail::impact_stage::strike) {
      if constexpr (!alone) ranks.share_velocities();
      detail::finish_impacts(s, ranks, detail::impact_stage::strike, sweep);
    }
    s.stage = detail::impact_stage::none;
    joints.share_loads(lists, s);
    const detail::solved done = watch.end(k, [&] { ranks.share_velocities(); });
    if constexpr (!alone)  // on all ranks or on none
      if (!(settings.tolerance > 0 && done.residual <= settings.tolerance))
        ranks.solve_gathered_islands(lists);

    if (correct && s.islands.stands())
      detail::correct_stacks<State>(detail::access_to<State>(lists), s);
    if (correct) detail::correct_overlaps(lists, s, settings, ranks, joints);
    return done;
  }
};

}  // namespace talus
