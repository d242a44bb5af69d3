#pragma once
// Bodies that are held at a force: what their contacts exert in each step, and the speed that
// follows from it.
#include <algorithm>
#include <array>
#include <span>

#include "talus/core/exact_sum.hpp"
#include "talus/response/contact_work.hpp"
#include "talus/world/driven.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

/// Rigid contacts have no stiffness from which a gain would follow, and that of a packing changes
/// with its state. So the gain is found on the way, as the step of Rprop is (Riedmiller, Braun
/// 1993): it grows while the force stays on one side of what is wanted, and is halved when it
/// crosses.
inline void steer(driven_body& one) {
  constexpr real growth = 1.1, cut = 0.5, least = 1e-9;
  driven_state& s = one.state;
  const real error = std::clamp((one.holds.force - s.force) / one.holds.force, real(-1), real(1));
  s.speed *= error * s.last_error < 0 ? cut : growth;
  s.speed = std::clamp(s.speed, least * one.holds.max_speed, one.holds.max_speed);
  s.last_error = error;
}
[[nodiscard]] inline driven_step step_of_servo(const driven_state& s, const vec3& axis, real dt) {
  driven_step step{.end = s.at, .v = (s.speed * s.last_error) * axis};
  step.end.point += dt * step.v;
  return step;
}

/// Of a force on something that a servo meets.
inline void press(driven_body& one, const vec3& force) {
  const real f = force.dot(one.holds.axis);
  if (f >= 0)
    one.with_axis += f;
  else
    one.against += -f;
}
template <class Scenario>
[[nodiscard]] bool any_servo(const world_state<Scenario>& s) {
  return std::any_of(s.driving.all.begin(), s.driving.all.end(),
                     [](const auto& one) { return one->is_servo; });
}
template <class Scenario>
void forget_forces(world_state<Scenario>& s) {
  for (auto& one : s.driving.all) one->with_axis = one->against = {};
}

/// Over all ranks, exactly, so that the bits do not depend on them: one reduction a step where
/// there are servos.
template <class Scenario>
void agree_on_forces(world_state<Scenario>& s) {
  if (!any_servo(s)) return;
  constexpr std::size_t size = exact_sum::digits + 1;
  std::array<double, 2 * size> sums;
  const std::span all(sums);
  for (auto& one : s.driving.all) {
    if (!one->is_servo) continue;
    one->with_axis.write(all.template first<size>());
    one->against.write(all.template last<size>());
    s.link->reduce(reduction::sum, all);
    one->with_axis.read(all.template first<size>());
    one->against.read(all.template last<size>());
    one->state.force = one->with_axis.value() - one->against.value();
    steer(*one);
  }
}

/// After the response of hard contacts.
template <class Scenario>
void weigh_driven(world_state<Scenario>& s) {
  if (!any_servo(s)) return;
  forget_forces(s);
  s.each_contact_list([&](const auto& list) {
    list.each_acting([&](const auto& c, bool, bool) {
      if (c.b < 0 || static_cast<std::size_t>(c.b) < s.driving.first) return;
      const auto n = s.driving.owners[static_cast<std::size_t>(c.b) - s.driving.first];
      if (n < 0) return;
      driven_body& one = *s.driving.all[static_cast<std::size_t>(n)];
      if (!one.is_servo) return;
      const split_impulse p = impulse_in_parts(c);
      press(one, (p.normal + p.tangential) / s.dt);
    });
  });
  agree_on_forces(s);
}

/// The force of a soft contact on what meets global body j of a shape.
template <class Shape, class Scenario>
void weigh_soft(world_state<Scenario>& s, std::size_t j, const vec3& force) {
  const auto n = s.driving.numbers[index_of<typename Scenario::shapes, Shape>][j];
  if (n >= 0 && s.driving.all[static_cast<std::size_t>(n)]->is_servo)
    press(*s.driving.all[static_cast<std::size_t>(n)], force);
}

}  // namespace talus::detail
