#pragma once
// The definitions of warnings_of_scales.hpp, in the compiled part or in each program.
#include <algorithm>

#include "talus/core/linkage.hpp"
#include "talus/observe/warnings_of_scales.hpp"

namespace talus::detail {

TALUS_INLINE std::string warnings_of_scales(const run_scales& r) {
  if (r.bodies == 0)
    return "  warning  there is no body: make some by world.fill, add_if_local or add before "
           "world.simulate\n";
  if (r.movable == 0 || r.steps == 0) return {};
  if (r.gravity == 0 && r.fastest == 0)
    return "  warning  nothing moves, and there is no gravity: call world.gravity({0, 0, -9.81}) "
           "before world.simulate\n";
  std::string all;
  const double longest = std::max(r.dt, r.dt_most);
  const double fall = r.gravity * longest * longest / r.radius, way = r.fastest * r.dt / r.radius;
  const double time = r.time > 0 ? r.time : static_cast<double>(r.steps) * r.dt;
  const double whole = 0.5 * r.gravity * time * time / r.radius;
  if (fall > longest_fall)
    all += compose(
        "  warning  in one step of {} gravity moves a body by {} of the mean radius {}: take a "
        "smaller dt, or see whether lengths, gravity and dt have units that fit together\n",
        text(longest, 6), text(fall, 2), text(r.radius, 3));
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
  if (r.jump.step > 0 && r.jump.way > longest_way * r.radius)
    all += compose(
        "  warning  in step {}, from time {} on, driven {} {} went {}, {} times the mean radius "
        "{}: "
        "contacts take such a jump for a velocity of {}, and bodies within it are passed; let its "
        "motion go on from where the body is, or take a smaller dt\n",
        r.jump.step, text(r.jump.time, 6), std::string(r.jump.shape), r.jump.body,
        text(r.jump.way, 3), text(r.jump.way / r.radius, 3), text(r.radius, 3),
        text(r.jump.way / r.jump.dt, 3));
  if (r.joint.step > 0)
    all += compose(
        "  warning  in step {} the {} of {} was open by {}, {} of its arm or as an angle: joints "
        "or "
        "driven bodies may contradict each other, or bodies turn too far in one step; remove a "
        "joint, or take a smaller dt\n",
        r.joint.step, r.joint.kind, r.joint.bodies, text(r.joint.gap, 3), text(r.joint.part, 3));
  return all;
}

}  // namespace talus::detail
