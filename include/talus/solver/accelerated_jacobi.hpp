#pragma once
// Accelerated Jacobi iterations with mass splitting: all contacts simultaneously, so that ranks
// need no order.
#include <algorithm>
#include <cstddef>
#include <tuple>
#include <type_traits>

#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/each.hpp"
#include "talus/core/policy.hpp"
#include "talus/solver/contact_list.hpp"
#include "talus/solver/convergence.hpp"
#include "talus/solver/correct_overlaps.hpp"

namespace talus {

/// A first-order method: all contacts are solved simultaneously, each exactly for its cone, with
/// the mass of each body split among its contacts so that their sum cannot overshoot (Tonge,
/// Benevolenski, Voroshilov 2012). The next iteration starts ahead of the impulses, by a part of
/// their last change: Nesterov's momentum as in APGD (Mazhar, Heyn, Negrut, Tasora 2015), with the
/// gradient restart of O'Donoghue and Candes (2015) applied contact by contact, so that ranks need
/// not agree on it. As each contact is solved for Coulomb's law itself, De Saxce's term is always
/// that of the present velocities, and the iteration solves Coulomb's problem instead of a convex
/// relaxation. That problem has no potential, which full momentum would require, so the momentum is
/// bounded; if the residual stops falling (known only with a tolerance), the momentum is reduced.
///
/// Ranks exchange velocities once per iteration, and only the order of sums depends on the
/// distribution of contacts. Gauss-Seidel is better up to about 20 iterations; at 50 they are equal
/// (docs/architecture.md).
struct accelerated_jacobi final {
  using talus_part_of = roles::solver;
  static constexpr const char* name = "accelerated_jacobi";

  /// Solves the contacts as nonlinear_gauss_seidel::solve does.
  template <class Lists, class Ranks>
  static detail::solved solve(Lists& lists, detail::solver_state& s,
                              const solver_settings& settings, bool correct, Ranks&& ranks) {
    const auto each = [&](auto&& f) { detail::each_of(lists, f); };
    constexpr bool alone = std::remove_cvref_t<Ranks>::alone;

    detail::convergence_watch<Lists, Ranks> watch(lists, s, settings, ranks, 6);
    each([&](auto& list) { list.warm_start(s); });
    s.boundary_contacts.assign(s.bodies.size(), 0);
    each([&](auto& list) { list.count_all(s); });
    if constexpr (!alone) ranks.share_velocities_and_counts();
    each([&](auto& list) { list.prepare_all(s), list.start_ahead(); });

    momentum ahead;
    int k = 0;
    for (; k < watch.limit(); ++k) {
      if constexpr (!alone)
        if (k > 0) ranks.share_velocities();
      if (watch.reached(k)) break;
      ahead.adapt(watch.residual());
      // Impulses that are checked or kept lie in their cones: without momentum.
      const bool kept = k + 1 == watch.limit() || watch.due(k + 1);
      const real part = kept ? 0 : ahead.part(k);
      each([&](auto& list) { list.relax_ahead(s, part); });
      each([&](auto& list) { list.apply_all(s); });
      watch.poll(1);
    }
    const detail::solved done = watch.end(k, [&] { ranks.share_velocities(); });

    if (correct) {
      each([&](auto& list) { list.prepare_interior(s); });
      detail::correct_overlaps(lists, s, settings, ranks);
    }
    return done;
  }

 private:
  /// How far ahead of the impulses an iteration starts, as a fraction of their last change.
  class momentum {
   public:
    [[nodiscard]] real part(int k) const { return std::min(most_, k / (k + real{3})); }
    /// `residual` is the last known one, the same on all ranks.
    void adapt(double residual) {
      if (residual == last_ || !(residual >= 0)) return;  // nothing new
      last_ = residual;
      failures_ = residual < best_ ? 0 : failures_ + 1;
      best_ = std::min(best_, residual);
      if (failures_ < 3) return;
      most_ *= real{0.8};
      failures_ = 0;
    }

   private:
    real most_ = 0.9;
    double best_ = 1e300, last_ = -1;
    int failures_ = 0;
  };
};

}  // namespace talus
