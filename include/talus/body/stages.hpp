#pragma once
// The stages of a time step at which features act, by name; docs/features.md lists them in order.
// A feature has a nested struct `hooks` with a static function for each stage at which it acts.
#include "talus/core/type_list.hpp"

namespace talus::stages {

/// Before anything moves. Shadow copies equal their owners' bodies.
struct at_start {
  static constexpr const char* name = "at_start";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::at_start(s)) {
    Hooks::at_start(s);
  }
};
/// Before each search for contacts: twice in a step in which islands wake.
struct before_detect {
  static constexpr const char* name = "before_detect";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::before_detect(s)) {
    Hooks::before_detect(s);
  }
};
/// Contacts are known, but not their forces.
struct after_detect {
  static constexpr const char* name = "after_detect";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::after_detect(s)) {
    Hooks::after_detect(s);
  }
};
/// The forces of contacts are known. Bodies are at the positions where the contacts were found, on
/// all ranks.
struct after_solve {
  static constexpr const char* name = "after_solve";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::after_solve(s)) {
    Hooks::after_solve(s);
  }
};
/// Own bodies are at their positions at the end of the step.
struct after_move {
  static constexpr const char* name = "after_move";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::after_move(s)) {
    Hooks::after_move(s);
  }
};
/// Positions and velocities are those of the end of the step.
struct at_close {
  static constexpr const char* name = "at_close";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::at_close(s)) {
    Hooks::at_close(s);
  }
};
/// Right before bodies migrate, and shadow copies are refreshed.
struct before_share {
  static constexpr const char* name = "before_share";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::before_share(s)) {
    Hooks::before_share(s);
  }
};
/// Right after that.
struct after_share {
  static constexpr const char* name = "after_share";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::after_share(s)) {
    Hooks::after_share(s);
  }
};
/// The step is over, and counted.
struct at_end {
  static constexpr const char* name = "at_end";
  template <class Hooks, class Stage>
  static auto call(Stage& s) -> decltype(Hooks::at_end(s)) {
    Hooks::at_end(s);
  }
};

/// In the order of a step. integrator<velocity_verlet> shares bodies between its two halves: there
/// before_share and after_share come before before_detect, and at_close after after_solve.
using all = type_list<at_start, before_detect, after_detect, after_solve, after_move, at_close,
                      before_share, after_share, at_end>;

}  // namespace talus::stages
