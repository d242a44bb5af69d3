#pragma once
// features<driven>: kinematic global bodies. In a step such a body moves from its pose at the start
// to its pose at the end, and contacts use the constant velocity that connects the two poses. So
// bodies that stick to it are carried along, and its motion agrees with the velocity in the
// contacts, for any length of steps.
//
// Every rank has the motion and the body, so no messages are needed.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "talus/core/error.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/features/driven/servo.hpp"
#include "talus/features/sleeping/sleeping_islands.hpp"
#include "talus/shape/frame.hpp"
#include "talus/state/driven_bodies.hpp"
#include "talus/state/kinematic_bodies.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The constant angular velocity that rotates `from` to `to` within `dt`, by less than half a turn.
[[nodiscard]] inline vec3 angular_velocity_between(const quat& from, const quat& to, real dt) {
  const quat by = after(to, inverse({{0, 0, 0}, from}).orientation);
  const vec3 axis = by.w() < 0 ? vec3(-by.x(), -by.y(), -by.z()) : vec3(by.x(), by.y(), by.z());
  const real sine = axis.norm();
  if (sine == 0) return {0, 0, 0};
  return (2 * portable::atan2(sine, std::abs(by.w())) / (sine * dt)) * axis;
}

/// The position of a reference point that starts at `origin`.
[[nodiscard]] inline rigid_place place_of(const vec3& origin, const rigid_displacement& d) {
  return {d.about + rotated(d.turn, vec3(origin - d.about)) + d.shift, d.turn};
}

// The three kinds of motion, for one step.

/// By a function of the time: at the start of the step, a small part of it later, and at its end.
inline constexpr real instant = 1. / 1024;
[[nodiscard]] inline driven_step step_to(const driven_state& s, const rigid_displacement& now,
                                         const rigid_displacement& next,
                                         const rigid_displacement& end, real dt) {
  driven_step step{.end = place_of(s.origin, end)};
  step.v = (step.end.point - s.at.point) / dt;
  step.w = angular_velocity_between(s.at.turn, step.end.turn, dt);
  // A first run may add up its time, a restarted one may not: they differ by rounding, and so do
  // the positions at that time, by a fraction of the motion in a step.
  const rigid_place from = place_of(s.origin, now);
  const real off = (from.point - s.at.point).norm(), way = (step.end.point - from.point).norm();
  const real far = (from.point - s.origin).norm() + (s.at.point - s.origin).norm();
  const real turned = angular_velocity_between(s.at.turn, from.turn, 1).norm();
  const real turns = angular_velocity_between(from.turn, step.end.turn, 1).norm();
  step.goes_on = off <= real(0.01) * way + real(1e-6) * far + real(1e-9) * s.origin.norm() &&
                 turned <= real(0.01) * turns + real(1e-6);
  // The end of a rotation by more than half a turn shows only the remainder, so the rate decides.
  const vec3 rate =
      angular_velocity_between(from.turn, place_of(s.origin, next).turn, instant * dt);
  step.too_fast = rate.norm() * dt > pi;
  return step;
}
[[nodiscard]] inline driven_step step_at(const driven_state& s, const rigid_velocity& u, real dt) {
  driven_step step{.end = s.at, .w = u.angular_velocity};
  const real speed = step.w.norm();
  const quat by = speed > 0 ? rotation(step.w, speed * dt) : quat(1, 0, 0, 0);
  step.end.point = u.about + rotated(by, vec3(s.at.point - u.about)) + dt * u.velocity;
  if (speed > 0) step.end.turn = after(by, s.at.turn).normalized();
  step.v = (step.end.point - s.at.point) / dt;
  step.too_fast = speed * dt > pi;
  return step;
}
[[nodiscard]] inline driven_step step_at(const driven_state& s, const surface_velocity& u, real) {
  return {.end = s.at,
          .v = u.velocity + u.angular_velocity.cross(vec3(s.at.point - u.about)),
          .w = u.angular_velocity};
}

/// Throws invalid_argument if a motion, whose value at the present time is `first`, begins
/// elsewhere than the body is. `mean_radius()` is that of the bodies that move, or 0 if there are
/// none; all ranks call it alike.
template <class Shape, class Radius>
[[gnu::cold]] void require_no_jump(const Shape& shape, const driven_body& body,
                                   const rigid_displacement& first, real time,
                                   const Radius& mean_radius) {
  real radius = 1;
  if constexpr (Shape::finite) radius = shape.bounding_radius();
  const vec3& here = body.state.origin;
  const rigid_place there = place_of(here, first);
  const real jump = (there.point - here).norm() +
                    radius * angular_velocity_between(body.state.at.turn, there.turn, 1).norm();
  if (jump <= real(1e-9) * (radius + here.norm() + first.about.norm())) return;
  const real mean = mean_radius();
  fail<std::invalid_argument>(
      "the motion of {} {} would begin at {} at time {}, and the body is at {}: contacts would "
      "meet the jump of {}{} as a velocity; subtract from the displacement its value at that time, "
      "or return a rigid_velocity",
      Shape::name, body.id, there.point, time, here, text(jump, 3),
      mean > 0 ? ", which is " + text(jump / mean, 3) + " radii of the bodies that move,"
               : std::string());
}

template <class T>
concept value_of_motion = std::same_as<T, rigid_displacement> || std::same_as<T, rigid_velocity> ||
    std::same_as<T, surface_velocity>;
template <class Motion>
inline constexpr bool is_motion = requires(const Motion& m, real t) {
  requires value_of_motion<decltype(m(t))>;
};
/// Whether a motion counts the time from the call of world.drive; a function of the user counts
/// that of the world.
template <class Motion>
inline constexpr bool counts_from_call =
    std::is_same_v<Motion, oscillation> || std::is_same_v<Motion, turning> ||
    std::is_same_v<Motion, gliding>;
template <class Motion>
void motion_of_body() {
  static_assert(is_motion<Motion>,
                "world.drive takes a motion: a function of the time that returns a "
                "rigid_displacement, a rigid_velocity or a surface_velocity, such as oscillation, "
                "turning, gliding and belt, and this type is not one");
}

template <class Bodies>
void put_driven(Bodies& b, std::size_t i, const driven_state& state) {
  auto& store = b.global;
  store.position[i] = state.at.point;
  if constexpr (std::remove_cvref_t<decltype(store)>::oriented)
    store.orientation_of[i] = after(state.at.turn, state.orientation);
  if constexpr (!Bodies::shape_type::finite) {
    auto& plane = store.shape[i];
    const vec3 surface = state.offset * state.normal;  // a point of it
    plane.normal = rotated(state.at.turn, state.normal);
    plane.offset =
        plane.normal.dot(rotated(state.at.turn, vec3(surface - state.origin)) + state.at.point);
  }
}

/// How far a driven body with this bounding radius goes in a step (length). Turning at a steady
/// rate counts as no way, and where bodies are `followed` to their impacts neither does a steady
/// speed.
[[nodiscard]] inline real way_of_driven(const driven_body& one, real radius, bool followed,
                                        real dt) {
  if (one.next.end == one.state.at) return 0;  // a belt
  const real shift = (one.next.end.point - one.state.at.point).norm();
  return (followed ? std::min(shift, one.dv.norm() * dt) : shift) + radius * one.dw.norm() * dt;
}

/// At the start of a step: the motion of all driven bodies in it.
template <class Scenario>
void aim_driven(world_state<Scenario>& s) {
  find_driven(s);
  s.driving.fastest = 0, s.driving.moves = false;
  each_driven(s, [&](auto& b, std::size_t i, driven_body& one) {
    driven_state& state = one.state;
    one.from = state.at.point;
    if (one.is_servo) one.force = force_of_servo(s, b, i, one);
    one.next = one.plan ? one.plan(state, s.time, s.dt) : driven_step{.end = state.at};
    const driven_step& next = one.next;
    if (!finite(next.v) || !finite(next.w) || !finite(next.end.point))
      fail<std::runtime_error>(
          "the motion of driven body {} makes no sense at time {}: it would go from {} to {} "
          "within dt = {}; let its function return finite places and velocities, and give it an "
          "axis that is not zero",
          one.id, s.time, state.at.point, next.end.point, s.dt);
    const bool first = !std::exchange(one.followed, true);
    if (first && state.begun && !next.goes_on)  // begun by the run that wrote the checkpoint
      fail<std::runtime_error>(
          "the checkpoint has driven body {} at {} at time {}, but its motion starts at another "
          "place: "
          "give it the motion of the first run (the same --options), or one "
          "that goes on from there",
          one.id, state.at.point, s.time);
    if (next.too_fast)
      fail<std::runtime_error>(
          "driven body {} turns by half a turn or more within dt = {} at time {}, which contacts "
          "cannot follow: take a smaller dt, or turn it more slowly",
          one.id, s.dt, s.time);
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    real radius = 0;
    if constexpr (shape::finite) {
      radius = b.global.shape[i].bounding_radius();
      s.driving.fastest = std::max(s.driving.fastest, next.v.norm() + radius * next.w.norm());
    }
    one.dv = state.begun ? vec3(next.v - state.v) : vec3(0, 0, 0);
    one.dw = state.begun ? vec3(next.w - state.w) : vec3(0, 0, 0);
    const real way = way_of_driven(one, radius, world_state<Scenario>::continuous, s.dt);
    if (way > s.driving.jump.way)
      s.driving.jump = {s.steps + 1, s.time, s.dt, one.id, shape::name, way};
    s.driving.moves = s.driving.moves || next.v != vec3(0, 0, 0) || next.w != vec3(0, 0, 0);
    state.begun = true;
    state.v = b.global.velocity[i] = next.v;
    state.w = b.global.angular_velocity[i] = next.w;
    if constexpr (world_state<Scenario>::sleeps)
      if (next.v != vec3(0, 0, 0) || next.w != vec3(0, 0, 0)) disturb(s, b.global, i);
  });
}

/// Moves them, together with all other bodies.
template <class Scenario>
void move_driven(world_state<Scenario>& s) {
  each_driven(s, [&](auto& b, std::size_t i, driven_body& one) {
    if (one.next.end == one.state.at) return;
    one.state.at = one.next.end;
    put_driven(b, i, one.state);
  });
}

}  // namespace talus::detail
