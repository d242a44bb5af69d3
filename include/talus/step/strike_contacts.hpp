#pragma once
// Impacts that others cause within a step: contacts are struck one by one.
#include <array>
#include <type_traits>

#include "talus/solver/direct/exact_joints.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Solves the contacts that impacts have driven together within the step, each alone with all
/// impulses of before held, one after the other, until none approaches faster than at rest. So an
/// impact passes through a row of bodies in one step. No strike adds energy, and with restitution 1
/// none loses any, however many are left for the next step; see impact_terms.hpp. Across ranks,
/// the boundary contacts come first in each pass, simultaneously.
template <class Scenario, class Ranks>
void strike_contacts(world_state<Scenario>& s, Ranks& ranks) {
  constexpr int most_passes = 16;
  constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
  constexpr bool coloured = std::remove_cvref_t<Ranks>::coloured;
  if (!s.materials.rebounds()) return;
  auto& solver = s.solver;
  auto&& lists = solver_lists<coloured>(s);
  const auto each = [&](auto&& f) {
    each_of(lists, [&](auto& list) {
      if constexpr (!is_joint<typename std::remove_cvref_t<decltype(list)>::contact_type>) f(list);
    });
  };
  // On all ranks or on none.
  const auto struck = [&] {
    std::array<double, 1> sum{solver.struck ? 1.0 : 0.0};
    if constexpr (!alone) s.link->reduce(reduction::sum, sum);
    solver.struck = false;
    return sum[0] > 0;
  };
  const auto pass = [&] {
    if constexpr (coloured) {
      for (std::uint32_t c = 0; c < ranks.colours(); ++c) {
        if constexpr (!alone) ranks.start_velocities(c);
        each([&](auto& list) { list.strike(solver, c, false); });
        if constexpr (alone) continue;
        ranks.finish_velocities(c);
        each([&](auto& list) { list.strike(solver, c, true); });
      }
    } else {
      if constexpr (!alone) {
        ranks.share_velocities();
        plain_vector<real> parts(solver.bodies.size(), 0);
        each([&](auto& list) {
          list.each_overlapping_boundary(
              solver, [&](std::int32_t body) { ++parts[static_cast<std::size_t>(body)]; });
        });
        ranks.share_values(parts);
        for (std::size_t k = 0; k < parts.size(); ++k)
          solver.boundary_contacts[k] = static_cast<std::uint32_t>(parts[k]);
        each([&](auto& list) { list.strike_boundary(solver); });
        each([&](auto& list) { list.apply_boundary(solver); });
      }
      each([&](auto& list) { list.strike_interior(solver); });
    }
  };

  if (!struck()) return;
  exact_joints<std::remove_reference_t<decltype(lists)>, std::remove_reference_t<decltype(solver)>,
               Ranks, coloured>
      joints(solver, ranks);
  int left = most_passes;
  do {
    pass();
    joints.solve(solver);
  } while (--left > 0 && struck());
  joints.share_loads();
}

}  // namespace talus::detail
