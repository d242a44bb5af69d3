#pragma once
// Likely mistakes in a run, detected from figures of its summary: inconsistent units, a step that
// is too long, bodies that do not move.
#include <cstdint>
#include <string>

#include "talus/core/error.hpp"
#include "talus/state/speed_leap.hpp"

namespace talus::detail {

/// The scales of a run. Lengths and times in the units of the scene.
struct run_scales {
  std::uint64_t bodies = 0, movable = 0, steps = 0;
  double dt = 0;
  double gravity = 0;       ///< its size
  double radius = 0;        ///< mean bounding radius of the movable bodies
  double fastest = 0;       ///< speed at the end
  bool followed = false;    ///< fast bodies are followed: continuous_collision
  bool may_follow = false;  ///< or could be, with the other policies of the scenario
  bool soft = false;        ///< the step follows from stiffness
  speed_leap leap;          ///< the largest of all ranks; a step of 0: none
};

/// Fractions of the mean radius by which gravity, and the fastest body, may move a body in a step.
inline constexpr double longest_fall = 0.1, longest_way = 1;
/// Steps after which gravity should have moved a body from rest by a radius.
inline constexpr std::uint64_t many_steps = 1000;

/// Lines of a summary, each with advice; empty if nothing looks wrong.
[[nodiscard, gnu::cold]] inline std::string warnings_of_scales(const run_scales& r) {
  if (r.bodies == 0)
    return "  warning  there is no body: make some by world.fill, add_if_local or add before "
           "world.simulate\n";
  if (r.movable == 0 || r.steps == 0) return {};
  if (r.gravity == 0 && r.fastest == 0)
    return "  warning  nothing moves, and there is no gravity: call world.gravity({0, 0, -9.81}) "
           "before world.simulate\n";
  std::string all;
  const double fall = r.gravity * r.dt * r.dt / r.radius, way = r.fastest * r.dt / r.radius;
  const double time = static_cast<double>(r.steps) * r.dt;
  const double whole = 0.5 * r.gravity * time * time / r.radius;
  if (fall > longest_fall)
    all += compose(
        "  warning  in one step of {} gravity moves a body by {} of the mean radius {}: take a "
        "smaller dt, or see whether lengths, gravity and dt have units that fit together\n",
        text(r.dt, 6), text(fall, 2), text(r.radius, 3));
  else if (way > longest_way && !r.followed)
    all += compose(
        "  warning  in one step of {} the fastest body moves by {} of the mean radius {}: take a "
        "smaller dt{}\n",
        text(r.dt, 6), text(way, 2), text(r.radius, 3),
        r.may_follow ? ", or name features<continuous_collision>" : "");
  if (r.gravity > 0 && whole < 1 && r.steps >= many_steps && !r.soft)
    all += compose(
        "  warning  in all {} steps of {} gravity moves a body by no more than {} of the mean "
        "radius {}: see whether lengths, gravity and dt have units that fit together\n",
        r.steps, text(r.dt, 6), text(whole, 2), text(r.radius, 3));
  if (r.leap.step > 0)
    all += compose(
        "  warning  in step {} contacts made a body as fast as {}, where nothing near was faster "
        "than {}: perhaps something was caught between a driven body and what stands still, and "
        "came free; leave it room (twice the largest body), or press with world.hold_force\n",
        r.leap.step, text(r.leap.after, 3), text(r.leap.before, 3));
  return all;
}

}  // namespace talus::detail
