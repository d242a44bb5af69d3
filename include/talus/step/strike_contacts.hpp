#pragma once
// Impacts that others cause within a step: contacts are struck one by one.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/exact_joints.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Solves the contacts that impacts have driven together within the step, each alone with all
/// impulses of before held, one after the other. So an impact passes through a row of bodies in one
/// step. No strike adds energy, and with restitution 1 none loses any, however many are left for
/// the next step; see impact_terms.hpp.
///
/// Passes over the contacts go on until none approaches faster than at rest. Across ranks, the
/// boundary contacts come first in each, simultaneously, where the edge between two ranks is open:
/// one of them has struck in the pass before. It closes for the step when neither has. No call is
/// global, and a step without impacts needs no further message. Bodies of islands of joints on
/// several ranks are not struck, but rebound in the next step.
template <class Scenario, class Ranks>
class contact_strikes {
  static constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
  static constexpr bool coloured = std::remove_cvref_t<Ranks>::coloured;
  static constexpr int most_passes = 16;
  /// By colours their number must not depend on the ranks.
  static constexpr int passes_by_colours = 2;

 public:
  contact_strikes(world_state<Scenario>& s, Ranks& ranks)
      : s_(s), solver_(s.solver), ranks_(ranks), lists_(solver_lists<coloured>(s)) {}

  void strike() {
    if (!s_.materials.rebounds()) return;
    if constexpr (coloured)
      strike_by_colours();
    else
      strike_while_any();
  }

 private:
  using lists_type = decltype(solver_lists<coloured>(std::declval<world_state<Scenario>&>()));
  using joints_type = exact_joints<std::remove_reference_t<lists_type>,
                                   std::remove_reference_t<decltype(world_state<Scenario>::solver)>,
                                   Ranks, coloured>;

  template <class F>
  void each(F&& f) {
    each_of(lists_, [&](auto& list) {
      if constexpr (!is_joint<typename std::remove_cvref_t<decltype(list)>::contact_type>) f(list);
    });
  }
  void note_joints() {
    s_.each_joint_list([&](auto& list) { list_in_use<coloured>(list).note_all(solver_); });
  }

  void strike_by_colours() {
    joints_type joints(solver_, ranks_);
    note_joints();
    for (int k = 0; k < passes_by_colours; ++k) {
      for (std::uint32_t c = 0; c < ranks_.colours(); ++c) {
        if constexpr (!alone) ranks_.start_velocities(c);
        each([&](auto& list) { list.strike(solver_, c, false); });
        if constexpr (alone) continue;
        ranks_.finish_velocities(c);
        each([&](auto& list) { list.strike(solver_, c, true); });
      }
      joints.solve(solver_);
    }
    joints.share_loads();
  }

  void strike_while_any() {
    if constexpr (!alone) ranks_.open_edges();
    bool struck = solver_.struck;
    if (!struck && !any_open()) return;
    if constexpr (!alone) ranks_.each_in_shared_joints([&](std::size_t body) { leave(body); });
    joints_type joints(solver_, ranks_, true);
    note_joints();
    for (int k = 0; k < most_passes; ++k) {
      if constexpr (!alone)
        if (any_open()) ranks_.share_struck(struck, k == 0);
      if (k > 0 && !struck && !any_open()) break;
      solver_.struck = false;
      if constexpr (!alone) strike_boundary();
      each([&](auto& list) { list.strike_interior(solver_); });
      joints.solve_here(solver_);
      struck = solver_.struck;
    }
    joints.share_loads();
  }
  void leave(std::size_t body) {
    if (solver_.still.empty()) solver_.still.resize(solver_.bodies.size());
    solver_.still[body] = true;
  }
  /// Both ranks strike the same contacts, with masses divided into the same parts; those of bodies
  /// that are left as they are count as -1.
  void strike_boundary() {
    if (!any_open()) return;
    ranks_.each_beyond([&](std::size_t copy) { leave(copy); });
    parts_.assign(solver_.bodies.size(), 0);
    each([&](auto& list) {
      list.each_overlapping_boundary(
          solver_, [&](std::int32_t body) { ++parts_[static_cast<std::size_t>(body)]; });
    });
    ranks_.each_in_shared_joints([&](std::size_t body) { parts_[body] = -1; });
    ranks_.share_over_edges(parts_);
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      if (parts_[k] < 0) leave(k);
      solver_.boundary_contacts[k] = static_cast<std::uint32_t>(std::max(parts_[k], real{0}));
    }
    each([&](auto& list) { list.strike_boundary(solver_); });
    each([&](auto& list) { list.apply_boundary(solver_); });
  }
  [[nodiscard]] bool any_open() const {
    if constexpr (alone)
      return false;
    else
      return ranks_.any_open();
  }

  world_state<Scenario>& s_;
  decltype(s_.solver)& solver_;
  Ranks& ranks_;
  lists_type lists_;
  plain_vector<real> parts_;  ///< of the mass of each body, one for each contact to be struck
};

}  // namespace talus::detail
