#pragma once
// Kinematic bodies: global bodies that features<driven> moves, as the search for pairs and the
// contacts use them. For the solver such a body equals a fixed one: zero inverse mass, and a
// velocity. If it rotates, contacts use bodies of their own, one for each pair and normal:
// isotropic bodies have no lever arm on the other side.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "talus/core/portable_trigonometry.hpp"
#include "talus/state/bodies_of_shape.hpp"
#include "talus/state/candidate_pairs.hpp"
#include "talus/state/driven_bodies.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

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
  bool found = d.listed == d.all.size();
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
  d.listed = d.all.size();
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

/// With hard contacts the mass of a servo is a multiple of that of its contact partners: large
/// enough to move them, and small enough that sweeps converge.
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
    v += (s.dt * one.force / one.state.mass) * one.holds.axis;
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

/// Whether the pairs of a driven surface are those of its parts: its skin then includes its
/// rotation. (For hard contacts that would change the steps of searches, and so their order.)
template <class Shape, class Scenario>
inline constexpr bool follows_turns =
    world_state<Scenario>::law::soft && !world_state<Scenario>::sleeps && requires {
  typename Shape::near_lists;
};

/// Records the poses of driven bodies at a pair search, and the reach of the search: unlimited for
/// a rotating plane, marked by a negative skin.
template <class Scenario>
void give_skins(world_state<Scenario>& s, real mean) {
  each_driven(s, [&](auto& b, std::size_t i, driven_body& one) {
    const auto& store = b.global;
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    one.searched_at = one.state.at.point;
    real speed = store.velocity[i].norm();
    const bool turns = store.angular_velocity[i] != vec3(0, 0, 0);
    if constexpr (shape::finite) {
      if constexpr (follows_turns<shape, Scenario>) {
        one.searched_turn = store.pose(i).orientation;
        speed += store.shape[i].bounding_radius() * store.angular_velocity[i].norm();
      }
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
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    const vec3 way = one.state.at.point - one.searched_at;
    if constexpr (shape::finite) {
      b.global_reach[i] = reach_of(store, i, s.dt);
      real left = one.skin - b.global_reach[i];
      if constexpr (follows_turns<shape, Scenario>) {
        const quat turn = store.pose(i).orientation * one.searched_turn.conjugate();
        left -= 2 * vec3(turn.x(), turn.y(), turn.z()).norm() * store.shape[i].bounding_radius();
      }
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
