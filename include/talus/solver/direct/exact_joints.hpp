#pragma once
// The joints of a solver's lists, as sweeps over contacts see them: all are solved at once.
#include <type_traits>

#include "talus/constraint/joint_in_list.hpp"
#include "talus/core/each.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/articulations.hpp"
#include "talus/solver/sweep.hpp"

namespace talus::detail {

/// The joints between bodies that this rank alone moves.
template <class Lists>
[[nodiscard]] plain_vector<joint_view> views_of_joints(Lists& lists) {
  plain_vector<joint_view> views;
  each_of(lists, [&](auto& list) {
    if constexpr (is_joint<typename std::remove_cvref_t<decltype(list)>::contact_type>)
      list.edit_interior_contacts([&](auto& c) { views.push_back(c.view()); });
  });
  return views;
}

/// Takes the place of the sweeps over joints. Without joints it is nothing.
template <class Lists, class State, bool = has_joints<Lists>>
class exact_joints {
 public:
  exact_joints(Lists&, State&) {}
  void solve(State&) {}
  template <class Ranks>
  void sweep(Lists& lists, State& s, bool forward, bool more, Ranks& ranks) {
    sweep_interior(lists, s, forward, more, ranks);
  }
};
template <class Lists, class State>
class exact_joints<Lists, State, true> {
 public:
  exact_joints(Lists& lists, State& s) {
    const plain_vector<joint_view> views = views_of_joints(lists);
    joints_.gather({views.data(), views.size()}, solver_bodies(s));
  }
  void solve(State& s) { joints_.solve(solver_bodies(s)); }
  /// As sweep_interior: the contacts one after the other, and then the joints.
  template <class Ranks>
  void sweep(Lists& lists, State& s, bool forward, bool more, Ranks& ranks) {
    each_of(lists, [&](auto& list) {
      if constexpr (!is_joint<typename std::remove_cvref_t<decltype(list)>::contact_type>)
        list.sweep_border(s, forward), list.sweep_inner(s, forward);
    });
    solve(s);
    if constexpr (!std::remove_cvref_t<Ranks>::alone)
      if (more) ranks.share_velocities();
  }

 private:
  articulations joints_;
};

}  // namespace talus::detail
