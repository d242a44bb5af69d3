#pragma once
// Likely mistakes in a run, detected from figures of its summary: inconsistent units, a step that
// is too long, bodies that do not move.
#include <cstdint>
#include <string>

#include "talus/core/error.hpp"
#include "talus/state/speed_leap.hpp"

namespace talus::detail {

/// The joint that opened farthest in a run, if by more than a hundredth of its arm.
struct open_joint {
  std::uint64_t step = 0;  ///< 0: none
  std::string kind;
  std::string bodies;  ///< as "body 3 and the world"
  double part = 0;     ///< the gap over the arm, or the error of an angle
  double gap = 0;      ///< length
};

/// The scales of a run. Lengths and times in the units of the scene.
struct run_scales {
  std::uint64_t bodies = 0, movable = 0, steps = 0;
  double dt = 0, dt_most = 0;  ///< of the last step, and of the longest one
  double time = 0;             ///< at the end; 0: all steps had that dt
  double gravity = 0;          ///< its size
  double radius = 0;           ///< mean bounding radius of the movable bodies
  double fastest = 0;          ///< speed at the end
  bool followed = false;       ///< fast bodies are followed: continuous_collision
  bool may_follow = false;     ///< or could be, with the other policies of the scenario
  bool soft = false;           ///< the step follows from stiffness
  speed_leap leap{};           ///< the largest of all ranks; a step of 0: none
  driven_jump jump{};          ///< the longest; a step of 0: none
  open_joint joint{};
};

/// Fractions of the mean radius by which gravity, and the fastest body, may move a body in a step.
inline constexpr double longest_fall = 0.1, longest_way = 1;
/// Steps after which gravity should have moved a body from rest by a radius.
inline constexpr std::uint64_t many_steps = 1000;

/// Lines of a summary, each with advice; empty if nothing looks wrong.
[[nodiscard, gnu::cold]] std::string warnings_of_scales(const run_scales& r);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/observe/warnings_of_scales_definitions.hpp"
#endif
