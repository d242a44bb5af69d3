#pragma once
// The stages of the exchange of ghosts (shadow copies) at which built-in features act. Like
// the stages of a step (body/stages.hpp), each calls the function of its name in the nested struct
// `hooks` of every feature that has one.
#include <concepts>
#include <utility>

#include "talus/core/math.hpp"

namespace talus::detail::ghost_stages {

/// How far ahead the neighbours of a body must hold a copy of it.
struct horizon {
  real time = 0;     ///< of its present motion
  real further = 0;  ///< beyond it, a length
};

/// Adapts the horizon: ghost_reach(state, horizon).
struct ghost_reach {
  template <class Hooks, class State>
  static auto call(State& s, horizon& h) -> decltype(Hooks::ghost_reach(s, h)) {
    Hooks::ghost_reach(s, h);
  }
};
/// Before bodies migrate and copies are refreshed, in a step and before its start.
struct before_ghosts {
  template <class Hooks, class State>
  static auto call(State& s) -> decltype(Hooks::before_ghosts(s)) {
    Hooks::before_ghosts(s);
  }
};
/// Other copies are here than before, or their flags have changed.
struct ghosts_renewed {
  template <class Hooks, class State>
  static auto call(State& s) -> decltype(Hooks::ghosts_renewed(s)) {
    Hooks::ghosts_renewed(s);
  }
};
/// Migration and refresh are complete.
struct after_ghosts {
  template <class Hooks, class State>
  static auto call(State& s) -> decltype(Hooks::after_ghosts(s)) {
    Hooks::after_ghosts(s);
  }
};
/// Sets `changed` if the feature has changed own bodies, so that copies must be sent again.
struct flags_changed {
  template <class Hooks, class State>
  static auto call(State& s, bool& changed) -> decltype(Hooks::flags_changed(s, changed)) {
    Hooks::flags_changed(s, changed);
  }
};
/// Writes a part of the message with copies.
struct pack_notice {
  template <class Hooks, class State, class Out>
  static auto call(State& s, Out& out) -> decltype(Hooks::pack_notice(s, out)) {
    Hooks::pack_notice(s, out);
  }
};
/// Reads the same part of the neighbour's message.
struct unpack_notice {
  template <class Hooks, class State, class In>
  static auto call(State& s, In& in) -> decltype(Hooks::unpack_notice(s, in)) {
    Hooks::unpack_notice(s, in);
  }
};
/// Calls f(history) for contact histories that migrate with their bodies beside the one of the
/// solver.
struct each_history {
  template <class Hooks, class State, class F>
  static auto call(State& s, F& f) -> decltype(Hooks::each_history(s, f)) {
    Hooks::each_history(s, f);
  }
};

}  // namespace talus::detail::ghost_stages
