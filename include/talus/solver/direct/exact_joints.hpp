#pragma once
// The joints of a solver's lists, as sweeps over contacts see them: all are solved at once.
#include <cstdint>
#include <type_traits>

#include "talus/constraint/joint_in_list.hpp"
#include "talus/core/each.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/articulations.hpp"
#include "talus/solver/sweep.hpp"

namespace talus::detail {

/// Whether a solver with these ranks leaves joints to exact_joints.
template <class Lists, class Ranks>
inline constexpr bool solves_joints_at_once = has_joints<Lists>&& requires {
  requires std::remove_cvref_t<Ranks>::solves_joints;
};

/// Calls f(list) for the lists that sweeps solve: all but those of joints that are solved at once.
template <class Lists, class Ranks, class F>
void each_swept(Lists& lists, const Ranks&, F&& f) {
  each_of(lists, [&](auto& list) {
    if constexpr (!solves_joints_at_once<Lists, Ranks> ||
                  !is_joint<typename std::remove_cvref_t<decltype(list)>::contact_type>)
      f(list);
  });
}

/// Takes the place of the sweeps over joints. Without joints it is nothing. An island of joints on
/// several ranks is solved on each of these alike.
template <class Lists, class State, class Ranks, bool Coloured = false,
          bool = solves_joints_at_once<Lists, Ranks>>
class exact_joints {
 public:
  static constexpr bool at_once = false;
  exact_joints(State&, Ranks&) {}
  void solve(State&) {}
  void share_loads(Lists&, State&) {}
  void sweep(Lists& lists, State& s, bool forward, bool more, Ranks& ranks) {
    sweep_interior(lists, s, forward, more, ranks);
  }
};
template <class Lists, class State, class Ranks, bool Coloured>
class exact_joints<Lists, State, Ranks, Coloured, true> {
 public:
  static constexpr bool at_once = true;
  /// After the impulses of the last step have been applied.
  exact_joints(State& s, Ranks& ranks) : ranks_(ranks) {
    ranks.share_jointed(true);
    const plain_vector<joint_view> views = ranks.template joint_views<Coloured>();
    joints_.gather({views.data(), views.size()}, solver_bodies(s));
    s.jointed.clear();
    for (const joint_view& joint : views)
      for (const std::int32_t end : {joint.a, joint.b})
        if (end >= 0) s.jointed.push_back(static_cast<std::uint32_t>(end));
  }
  /// All joints. If there are other ranks, they have the new velocities of bodies here afterwards,
  /// unless the solver shares them by colours.
  void solve(State& s) {
    ranks_.share_jointed(false);
    joints_.solve(solver_bodies(s));
    if constexpr (!std::remove_cvref_t<Ranks>::alone && !Coloured) ranks_.share_velocities();
  }
  /// One sweep of the position correction over all joints.
  void correct() const { ranks_.correct_joints(); }
  /// After the last of these in a step.
  void share_loads(Lists& lists, State& s) {
    if (!ranks_.with_supports(lists, joints_.may_need_supports(), [&](auto& supports) {
          joints_.share_loads(solver_bodies(s), {supports.data(), supports.size()});
        }))
      joints_.share_loads();
  }
  /// Sweeps as sweep_interior does: the contacts one after the other, and then the joints.
  void sweep(Lists& lists, State& s, bool forward, bool, Ranks& ranks) {
    each_swept(lists, ranks,
               [&](auto& list) { list.sweep_border(s, forward), list.sweep_inner(s, forward); });
    solve(s);
  }

 private:
  Ranks& ranks_;
  articulations joints_;
};

}  // namespace talus::detail
