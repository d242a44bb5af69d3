#pragma once
// features<driven>: kinematic global bodies. In a step such a body moves from its pose at the start
// to its pose at the end, and contacts use the constant velocity that connects the two poses. So
// bodies that stick to it are carried along, and its motion agrees with the velocity in the
// contacts, for any length of steps.
//
// Every rank knows the motion and the body, so no messages are needed. For the solver a driven body
// equals a fixed one: zero inverse mass, and a velocity. If it rotates, contacts use bodies of
// their own, one for each pair and normal: isotropic bodies have no lever arm on the other side.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "talus/core/error.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/shape/frame.hpp"
#include "talus/world/bodies_of_shape.hpp"
#include "talus/world/candidate_pairs.hpp"
#include "talus/world/driven_bodies.hpp"
#include "talus/world/sleeping_islands.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

/// The product of two rotations.
[[nodiscard]] inline quat after(const quat& second, const quat& first) {
  return combined({{0, 0, 0}, second}, {{0, 0, 0}, first}).orientation;
}

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
  // Of more than half a turn the end shows only the remainder.
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

template <class T>
concept value_of_motion = std::same_as<T, rigid_displacement> || std::same_as<T, rigid_velocity> ||
    std::same_as<T, surface_velocity>;
template <class Motion>
inline constexpr bool is_motion = requires(const Motion& m, real t) {
  requires value_of_motion<decltype(m(t))>;
};
template <class Motion>
void motion_of_body() {
  static_assert(is_motion<Motion>,
                "world.drive takes a motion: a function of the time that returns a "
                "rigid_displacement, a rigid_velocity or a surface_velocity, such as oscillation, "
                "turning, gliding and belt, and this type is none");
}

/// Calls f(bodies of a shape, index among them, driven body) for those that exist.
template <class Scenario, class F>
void each_driven(world_state<Scenario>& s, F&& f) {
  std::size_t k = 0;
  s.each_shape([&](auto& b) {
    const auto& numbers = s.driving.numbers[k++];
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (numbers[i] >= 0) f(b, i, *s.driving.all[static_cast<std::size_t>(numbers[i])]);
  });
}

/// Whether the driven bodies still have their recorded indices among the global ones.
template <class Scenario>
[[nodiscard]] bool driven_are_found(const world_state<Scenario>& s) {
  const auto& d = s.driving;
  bool found = d.looked_for == d.all.size();
  std::size_t k = 0;
  s.each_shape([&](const auto& b) {
    const auto& numbers = d.numbers[k++];
    const auto& ids = b.global.id;
    found = found && numbers.size() == ids.size();
    for (std::size_t i = 0; found && i < ids.size(); ++i)
      found = numbers[i] < 0 || d.all[static_cast<std::size_t>(numbers[i])]->id == ids[i];
  });
  return found;
}
/// Finds them: global bodies may have been added or removed.
template <class Scenario>
void find_driven(world_state<Scenario>& s) {
  if (driven_are_found(s)) return;
  auto& d = s.driving;
  d.looked_for = d.all.size();
  std::size_t k = 0;
  s.each_shape([&](const auto& b) {
    auto& numbers = d.numbers[k++];
    const auto& ids = b.global.id;
    numbers.assign(ids.size(), -1);
    for (std::size_t n = 0; n < d.all.size(); ++n) {
      const auto at = std::find(ids.begin(), ids.end(), d.all[n]->id);
      if (at != ids.end())
        numbers[static_cast<std::size_t>(at - ids.begin())] = static_cast<std::int32_t>(n);
    }
  });
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

/// At the start of a step: the motion of all driven bodies in it.
template <class Scenario>
void aim_driven(world_state<Scenario>& s) {
  find_driven(s);
  s.driving.fastest = 0;
  each_driven(s, [&](auto& b, std::size_t i, driven_body& one) {
    driven_state& state = one.state;
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
          "the checkpoint has driven body {} at {} at time {}, but its motion has it elsewhere, "
          "and it would leap: give it the motion of the first run (the same --options), or one "
          "that goes on from there",
          one.id, state.at.point, s.time);
    if (next.too_fast)
      fail<std::runtime_error>(
          "driven body {} turns by half a turn or more within dt = {} at time {}, which contacts "
          "cannot follow: take a smaller dt, or turn it more slowly",
          one.id, s.dt, s.time);
    if constexpr (std::remove_cvref_t<decltype(b)>::shape_type::finite)
      s.driving.fastest = std::max(
          s.driving.fastest, next.v.norm() + b.global.shape[i].bounding_radius() * next.w.norm());
    one.dv = state.begun ? vec3(next.v - state.v) : vec3(0, 0, 0);
    one.dw = state.begun ? vec3(next.w - state.w) : vec3(0, 0, 0);
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

// For contacts.

/// Makes room for immovable bodies behind all movable ones.
template <class Scenario>
void number_driven(world_state<Scenario>& s) {
  using body = solver_body_of<solved_scalar<Scenario>>;
  auto& d = s.driving;
  auto& bodies = s.solver.bodies;
  d.first = s.solver.first_global = bodies.size();
  d.owners.clear();
  const auto add = [&](const vec3& v, const vec3& w, std::int32_t owner) {
    bodies.push_back(
        body{in_scalar<solved_scalar<Scenario>>(v), 0, in_scalar<solved_scalar<Scenario>>(w), 0});
    d.owners.push_back(owner);
  };
  add({0, 0, 0}, {0, 0, 0}, -1);
  for (std::size_t n = 0; n < d.all.size(); ++n)
    add(d.all[n]->next.v, d.all[n]->next.w, static_cast<std::int32_t>(n));
}

/// A body that sticks to a rotating surface moves along a chord of its circle, but the velocity at
/// the start of the step is tangential. The difference, for a centre at `r` from the reference
/// point, along the surface only: along the normal the contact is with the surface itself.
[[nodiscard]] inline vec3 along_chord(const vec3& w, const vec3& r, const vec3& normal, real dt) {
  const real angle = w.norm() * dt;
  if (angle == 0) return {0, 0, 0};
  const real half = portable::sin(angle / 2) / angle;  // 1 - cos x = 2 sin^2(x/2)
  const vec3 around = w.cross(r);
  const vec3 e =
      (portable::sin(angle) / angle - 1) * around + (2 * half * half * dt) * w.cross(around);
  return e - normal.dot(e) * normal;
}

/// The mass of a servo is a multiple of the mass of its contact partners: large enough to move
/// them, and small enough that sweeps converge.
inline constexpr real servo_ratio = 10;

/// Index in the solver's arrays of global body j of a shape for one contact, or for those of one
/// normal: moving with v and rotating with w about its position. `last` is the index found before
/// for the same two bodies and the same normal, or -1; `inverse_mass` that of the other body.
template <class Shape, class Scenario>
[[nodiscard]] std::int32_t number_of_global(world_state<Scenario>& s, std::size_t j, vec3 v,
                                            const vec3& w, std::int32_t last, real inverse_mass) {
  auto& d = s.driving;
  const std::int32_t n = d.numbers[index_of<typename Scenario::shapes, Shape>][j];
  if (n < 0) return static_cast<std::int32_t>(d.first);
  if (last >= 0) return last;
  const driven_body& one = *d.all[static_cast<std::size_t>(n)];
  if (!one.is_servo) {
    if (v == one.next.v && w == one.next.w) return static_cast<std::int32_t>(d.first) + 1 + n;
    inverse_mass = 0;
  } else if (one.state.mass > 0) {
    v += (s.dt * one.holds.force / one.state.mass) * one.holds.axis;
  }
  using number = solved_scalar<Scenario>;
  s.solver.bodies.push_back({in_scalar<number>(v), static_cast<number>(inverse_mass / servo_ratio),
                             in_scalar<number>(w), 0});
  d.owners.push_back(n);
  return static_cast<std::int32_t>(s.solver.bodies.size() - 1);
}

/// The driven body of global body i of a shape, or null.
template <class Shape, class Scenario>
[[nodiscard]] const driven_body* driven_at(const world_state<Scenario>& s, std::size_t i) {
  const auto& numbers = s.driving.numbers[index_of<typename Scenario::shapes, Shape>];
  if (i >= numbers.size() || numbers[i] < 0) return nullptr;
  return s.driving.all[static_cast<std::size_t>(numbers[i])].get();
}

/// The change of velocity of global body j, at `arm` from its position, since the last step.
template <class Shape, class Scenario>
[[nodiscard]] vec3 change_of_global(const world_state<Scenario>& s, std::size_t j,
                                    const vec3& arm) {
  const driven_body* one = driven_at<Shape>(s, j);
  return one == nullptr ? vec3(0, 0, 0) : vec3(one->dv + one->dw.cross(arm));
}

// For kept pairs.

/// How far the surface of an infinite body moves in this step towards a body at `p`.
template <class Store>
[[nodiscard]] real way_of_plane(const Store& store, std::size_t j, const vec3& p, real dt) {
  return dt * std::abs(store.shape[j].unit_normal().dot(
                  store.velocity[j] + store.angular_velocity[j].cross(p - store.position[j])));
}

/// Records the poses of driven bodies at a pair search, and the reach of the search: unlimited for
/// a rotating plane, marked by a negative skin.
template <class Scenario>
void give_skins(world_state<Scenario>& s, real mean) {
  each_driven(s, [&](auto& b, std::size_t i, driven_body& one) {
    const auto& store = b.global;
    one.looked = one.state.at.point;
    const real speed = store.velocity[i].norm();
    const bool turns = store.angular_velocity[i] != vec3(0, 0, 0);
    if constexpr (std::remove_cvref_t<decltype(b)>::shape_type::finite) {
      one.skin = reach_of(store, i, s.dt);
      if (speed > 0 || turns)
        one.skin += skin_of(store.shape[i].bounding_radius(), mean, speed, s.dt);
    } else {
      const real way = way_of_plane(store, i, store.position[i], s.dt);
      one.skin = turns ? -1 : speed > 0 ? skin_part * mean + (1 + skin_steps) * way : 0;
    }
  });
}
/// Whether the found pairs of driven bodies are complete at present; measures their reach.
template <class Scenario>
[[nodiscard]] bool driven_within_skin(world_state<Scenario>& s) {
  bool hold = true;
  each_driven(s, [&](auto& b, std::size_t i, driven_body& one) {
    const auto& store = b.global;
    const vec3 way = one.state.at.point - one.looked;
    if constexpr (std::remove_cvref_t<decltype(b)>::shape_type::finite) {
      b.global_reach[i] = reach_of(store, i, s.dt);
      const real left = one.skin - b.global_reach[i];
      hold = hold && left >= 0 && way.squaredNorm() <= left * left;
    } else if (one.skin >= 0) {
      const bool turns = store.angular_velocity[i] != vec3(0, 0, 0);
      hold = hold && !turns &&
             std::abs(store.shape[i].unit_normal().dot(way)) +
                     way_of_plane(store, i, store.position[i], s.dt) <=
                 one.skin;
    }
  });
  return hold;
}

}  // namespace talus::detail
