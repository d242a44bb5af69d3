#pragma once
// Bodies that are held at a force. Rigid contacts have no stiffness that could determine the gain
// of a controller: a wall that moves at any speed into a jammed packing meets an unbounded force.
// So a servo is a piston. At rest the contacts bear its force exactly, and over a time they bear it
// but for the change of its momentum. With soft contacts it has the mass of the bodies that it
// touches. With hard ones it consists of parts, one for each pair of bodies that touches it, with a
// multiple of the mass of the other body; each part presses with its share of the force, and its
// contacts move it like any body. At the end of the step all parts move at their mean velocity, and
// by the mean of their position corrections. (Splitting a body into parts that are averaged: Tonge,
// Benevolenski, Voroshilov 2012.) The distribution of contacts over ranks has no effect.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "talus/constraint/contact_work.hpp"
#include "talus/core/error.hpp"
#include "talus/features/driven/plane_area.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/state/kinematic_bodies.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The force that a servo holds in the step that begins: that of its end. Throws runtime_error if
/// it makes no sense.
template <class Bodies, class Scenario>
[[nodiscard]] real force_of_servo(const world_state<Scenario>& s, const Bodies& b, std::size_t i,
                                  const driven_body& one) {
  const bool presses = one.holds.pressure.given();
  const real time = s.time + s.dt;
  const real value = presses ? one.holds.pressure(time) : one.holds.force(time);
  if (!(value >= 0) || !std::isfinite(value))
    fail<std::runtime_error>(
        "the {} of servo {} is {} at time {}: let its function return a finite value of 0 or more",
        presses ? "pressure" : "force", one.id, value, time);
  if constexpr (!Bodies::shape_type::finite)
    if (presses) {
      const real area = area_of_plane(s, i);
      if (!std::isfinite(area))
        fail<std::runtime_error>(
            "servo {} holds a pressure, but other planes do not bound its plane {} on all sides, "
            "so it has no area: add the missing walls, or give .force instead",
            one.id, b.global.shape[i].unit_normal());
      return value * area;
    }
  return value;
}

[[nodiscard]] inline driven_step step_of_servo(const driven_state& s, const vec3& axis, real dt) {
  driven_step step{.end = s.at, .v = s.speed * axis};
  step.end.point += dt * step.v;
  return step;
}

template <class Scenario>
[[nodiscard]] bool any_servo(const world_state<Scenario>& s) {
  return std::any_of(s.driving.all.begin(), s.driving.all.end(),
                     [](const auto& one) { return one->is_servo; });
}
template <class Scenario>
void forget_forces(world_state<Scenario>& s) {
  for (auto& one : s.driving.all) one->sums = {};
}

/// Over all ranks, exactly, so that the bits do not depend on them: one reduction per step and
/// servo. Then calls f(servo, mass of its parts).
template <class Scenario, class F>
void agree_on_servos(world_state<Scenario>& s, F&& f) {
  for (auto& one : s.driving.all) {
    if (!one->is_servo) continue;
    servo_sums& mine = one->sums;
    {
      const stage_clock clock(s.seconds.exchange);
      sum_exactly(*s.link, mine.force, mine.momentum, mine.shift, mine.mass);
    }
    const real most = one->holds.max_speed;
    driven_state& state = one->state;
    state.force = mine.force.value();
    f(*one, mine.mass.value());
    // A servo without contacts so far has no mass.
    state.speed = state.mass > 0 ? std::clamp(state.speed, -most, most) : most;
  }
}

/// After the response of hard contacts.
template <class Scenario>
void settle_servos(world_state<Scenario>& s) {
  if (!any_servo(s)) return;
  forget_forces(s);
  const auto& d = s.driving;
  const auto servo_of = [&](std::size_t k) -> driven_body* {
    const auto n = d.owners[k - d.first];
    if (n < 0 || !d.all[static_cast<std::size_t>(n)]->is_servo) return nullptr;
    return d.all[static_cast<std::size_t>(n)].get();
  };
  plain_vector<char> presses(d.owners.size(), 0);
  s.each_contact_list([&](const auto& list) {
    list.each_acting([&](const auto& c, bool, bool) {
      const auto k = static_cast<std::size_t>(c.b);
      if (c.b < 0 || k < d.first) return;
      driven_body* const one = servo_of(k);
      if (one == nullptr) return;
      const split_impulse p = impulse_in_parts(c);
      if (p.normal == vec3(0, 0, 0)) return;
      presses[k - d.first] = 1;
      one->sums.force += (p.normal + p.tangential).dot(one->holds.axis) / s.dt;
    });
  });
  for (std::size_t k = d.first; k < s.solver.bodies.size(); ++k) {
    if (!presses[k - d.first]) continue;
    driven_body& one = *servo_of(k);
    const auto& part = s.solver.bodies[k];
    const real mass = 1 / static_cast<real>(part.inverse_mass);
    one.sums.mass += mass;
    one.sums.momentum += mass * v_of(part).dot(one.holds.axis);
    real shift = 0;
    if constexpr (world_state<Scenario>::law::correction)
      shift += in_scalar<real>(s.solver.shift[k].v).dot(one.holds.axis);
    if constexpr (uses_substeps<typename Scenario::solver>)
      shift += s.solver.drift[k].v.dot(one.holds.axis);
    one.sums.shift += mass * shift;
  }
  agree_on_servos(s, [&](driven_body& one, real mass) {
    driven_state& state = one.state;
    const servo& how = one.holds;
    real shift = 0;
    if (mass > 0) {
      state.mass = mass;
      state.speed = one.sums.momentum.value() / mass;
      shift = one.sums.shift.value() / mass;
    } else {
      state.speed = state.mass > 0 ? state.speed + s.dt * one.force / state.mass : how.max_speed;
    }
    // With the midpoint it has already moved by half of its step.
    const real left = world_state<Scenario>::midpoint ? real(0.5) : real(1);
    const real way = std::clamp(left * state.speed + shift, -how.max_speed, how.max_speed);
    one.next.end.point = state.at.point + (s.dt * way) * how.axis;
  });
}

/// The force of a soft contact on the contact partner of global body j of a shape.
template <class Shape, class Scenario>
void press(world_state<Scenario>& s, std::size_t j, const vec3& force, real inverse_mass) {
  const auto n = s.driving.numbers[index_of<typename Scenario::shapes, Shape>][j];
  if (n < 0 || inverse_mass == 0) return;
  driven_body& one = *s.driving.all[static_cast<std::size_t>(n)];
  if (!one.is_servo) return;
  one.sums.force += force.dot(one.holds.axis);
  one.sums.mass += 1 / inverse_mass;
}
/// After the forces of soft contacts.
template <class Scenario>
void push_servos(world_state<Scenario>& s) {
  if (!any_servo(s)) return;
  agree_on_servos(s, [&](driven_body& one, real mass) {
    driven_state& state = one.state;
    if (mass > 0) state.mass = mass;
    if (state.mass > 0) state.speed += s.dt * (one.force - state.force) / state.mass;
  });
}

}  // namespace talus::detail
