#pragma once
// Nonlinear block Gauss-Seidel over ranks: the contact solver.
#include <tuple>

#include "talus/response/contact_list.hpp"
#include "talus/response/solver_state.hpp"

namespace talus {

/// How hard the contact problem is worked on.
struct solver_settings {
  int iterations = 10;            ///< sweeps over all contacts per step; 5 to 50
  int correction_iterations = 3;  ///< sweeps of the correction of overlaps; 1 to 5
  real correction = 0.2;          ///< part of an overlap that is corrected per step, in [0, 1]
};

namespace detail {

/// Solves the contact problem in `lists` (a tuple of contact lists) by sweeps that solve each
/// contact exactly for its cone with all others held (Jourdan, Alart, Jean 1998). Between ranks,
/// momentum is conserved thus: boundary contacts are solved simultaneously, from the velocities
/// that both ranks hold alike, with the mass of each body split among its boundary contacts so
/// that the simultaneous step cannot overshoot (Tonge, Benevolenski, Voroshilov 2012); then each
/// rank sweeps its interior contacts. `ranks` refreshes the shadow copies: share_counts(),
/// share_velocities(), share_corrections().
template <class Lists, class Ranks>
void solve_nonlinear_gauss_seidel(Lists& lists, solver_state& s, const solver_settings& settings,
                                  bool correct, Ranks&& ranks) {
  const auto each = [&](auto&& f) { std::apply([&](auto&... list) { (f(list), ...); }, lists); };
  constexpr bool alone = std::remove_cvref_t<Ranks>::alone;

  each([&](auto& list) { list.weigh_interior(s); });
  each([&](auto& list) { list.apply_remembered(s); });
  if constexpr (!alone) {
    each([&](auto& list) { list.count_boundary(s); });
    ranks.share_velocities_and_counts();
    each([&](auto& list) { list.weigh_boundary(s); });
  }

  for (int k = 0; k < settings.iterations; ++k) {
    if constexpr (!alone) {
      if (k > 0) ranks.share_velocities();
      each([&](auto& list) { list.relax_boundary(s); });
      each([&](auto& list) { list.apply_boundary(s); });
    }
    if (k % 2 == 0)
      each([&](auto& list) { list.sweep_forward(s); });
    else
      each([&](auto& list) { list.sweep_backward(s); });
  }

  for (int k = 0; correct && k < settings.correction_iterations; ++k) {
    if constexpr (!alone) {
      if (k > 0) ranks.share_corrections();
      each([&](auto& list) { list.relax_boundary_push(s); });
      each([&](auto& list) { list.apply_boundary_push(s); });
    }
    each([&](auto& list) { list.sweep_push(s); });
  }
}

}  // namespace detail
}  // namespace talus
