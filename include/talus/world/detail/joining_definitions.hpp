#pragma once
// Joints between bodies. Member functions of world.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>

#include "talus/world/world.hpp"

namespace talus {

namespace detail {

/// A body that a rank names for a joint: some ranks have no handle of it.
template <class Shape>
struct named_body {
  using shape = Shape;
  system_id id = no_id;
};
template <class Shape>
[[nodiscard]] named_body<Shape> body_named(handle<Shape> h) {
  return {h.id};
}
template <class Shape>
[[nodiscard]] named_body<Shape> body_named(const std::optional<handle<Shape>>& h) {
  return {h ? h->id : no_id};
}

/// The frame of the world in the place of a body.
struct no_shape {
  static constexpr const char* name = "frame of the world";
};
[[nodiscard]] inline named_body<no_shape> body_named(world_frame_t) { return {id_of_world}; }

/// The island of a joint that the user makes, changes or removes wakes.
template <class Scenario>
void wake_jointed(world_state<Scenario>& s, const joint_key& key) {
  if constexpr (world_state<Scenario>::sleeps)
    s.each_finite_shape([&](auto& b) {
      for (std::size_t i = 0; i < b.movable.locals; ++i)
        if (b.movable.id[i] == key.a || b.movable.id[i] == key.b) disturb(s, b.movable, i);
    });
  else
    (void)s, (void)key;
}

/// The data of a body that a joint needs, alike on all ranks.
struct body_to_join {
  system_id id = no_id;
  bool known = false, movable = false, global = false;
  pose at;
};

}  // namespace detail

/// Collective: the ranks that have a handle agree on the body, and its owner tells where it is.
template <class Scenario>
template <class Shape>
detail::body_to_join world<Scenario>::agree_on_body(system_id named, const char* which) {
  // The largest id that a rank names, and the least one by its complement.
  std::array<std::uint64_t, 3> ids{};
  if (named != no_id) ids = {1, value_of(named), ~value_of(named)};
  state_.link->reduce(reduction::max, std::span(ids));
  if (ids[0] == 0)
    detail::fail<std::invalid_argument>(
        "join was called without {} body: no rank has passed a handle of it", which);
  if (ids[1] != ~ids[2])
    detail::fail<std::invalid_argument>(
        "join was called with different handles of {} body: pass the same handle on all ranks, or "
        "none; this rank has passed {}",
        which, named == no_id ? std::string("none") : detail::text(named));
  detail::body_to_join one;
  one.id = system_id{ids[1]};
  auto& bodies = state_.template of<Shape>();
  std::array<double, 9> facts{};  // owners, whether it can move, position, orientation
  const auto tell = [&](const auto& store, std::size_t end) {
    for (std::size_t i = 0; i < end; ++i) {
      if (store.id[i] != one.id) continue;
      const pose at = store.pose(i);
      const quat& q = at.orientation;
      facts = {1.0,
               double(store.inverse_mass[i] != 0),
               at.position[0],
               at.position[1],
               at.position[2],
               q.w(),
               q.x(),
               q.y(),
               q.z()};
      return true;
    }
    return false;
  };
  one.global = tell(bodies.global, bodies.global.size());
  if (!one.global) {
    (void)tell(bodies.movable, bodies.movable.locals);
    state_.link->reduce(reduction::sum, std::span(facts));
    for (double& x : facts) x += 0.0;  // -0 becomes 0, as in a sum over ranks
  }
  if (facts[0] != 1)
    detail::fail<std::invalid_argument>(
        "no rank knows the {} {}, {} body of a joint: it was destroyed, or is of another world",
        Shape::name, one.id, which);
  one.known = true, one.movable = facts[1] != 0;
  one.at = {{facts[2], facts[3], facts[4]}, quat(facts[5], facts[6], facts[7], facts[8])};
  return one;
}

template <class Scenario>
template <class A, class B, class Kind>
joint_handle<Scenario, Kind> world<Scenario>::join(const A& a, const B& b, const Kind& how) {
  detail::joint_key key;
  if constexpr (detail::require_joint<Scenario, Kind>()) {
    sections_.require_all_ranks("join", rank());
    how.validate();
    using shape_a = typename decltype(detail::body_named(a))::shape;
    using shape_b = typename decltype(detail::body_named(b))::shape;
    const auto agree = [&]<class Shape>(const detail::named_body<Shape>& x, const char* which) {
      if constexpr (std::is_same_v<Shape, detail::no_shape>) {
        return detail::body_to_join{.id = x.id, .known = true, .global = true, .at = {}};
      } else {
        return agree_on_body<Shape>(x.id, which);
      }
    };
    const auto first = agree(detail::body_named(a), "the first");
    const auto second = agree(detail::body_named(b), "the second");
    if (first.id == second.id)
      detail::fail<std::invalid_argument>(
          "join was called with the {} {} as both bodies: a joint needs two", shape_a::name,
          first.id);
    if (!first.movable && !second.movable)
      detail::fail<std::invalid_argument>(
          "join was called with two bodies that cannot move, the {} {} and the {} {}: one of them "
          "must be neither fixed nor global",
          shape_a::name, first.id, shape_b::name, second.id);
    key = {first.id, second.id, state_.joints.made++};
    auto& of_kind = state_.joints.template of<Kind>();
    const bool owns_a = owns_body<shape_a>(first), owns_b = owns_body<shape_b>(second);
    if (owns_a || owns_b) {
      detail::joint_record<Kind> record{};
      record.key = key;
      record.acts = (owns_a && first.movable) || (owns_b && second.movable);
      // The second body is seen as the image next to the first one, but at its own place from the
      // frame of the world.
      pose at_b = second.at;
      if (first.id != detail::id_of_world)
        at_b.position = detail::seen_from(state_, first.at.position, at_b.position);
      record.anchors = how.fix(first.at, at_b);
      of_kind.add(record);
      state_.joints.changed();
    }
    state_.changed = true;
    detail::wake_jointed(state_, key);
  }
  return {*this, key};
}

template <class Scenario>
template <class Shape>
bool world<Scenario>::owns_body(const detail::body_to_join& one) const {
  if constexpr (std::is_same_v<Shape, detail::no_shape>) {
    return false;
  } else {
    if (one.global) return false;
    const auto& store = state_.template of<Shape>().movable;
    for (std::size_t i = 0; i < store.locals; ++i)
      if (store.id[i] == one.id) return true;
    return false;
  }
}

template <class Scenario>
template <class Kind, class Motor>
void world<Scenario>::set_motor(const joint_handle<Scenario, Kind>& joint, const Motor& motor) {
  sections_.require_all_ranks("set_motor", rank());
  detail::require_motor(Kind::name, detail::motor_of(motor));
  auto* r = state_.joints.template of<Kind>().find(joint.key());
  if (r == nullptr) return;
  Kind::drive(r->anchors, motor);
  detail::wake_jointed(state_, joint.key());
}

template <class Scenario>
template <class Kind>
void world<Scenario>::release(const joint_handle<Scenario, Kind>& joint) {
  sections_.require_all_ranks("release", rank());
  auto& of_kind = state_.joints.template of<Kind>();
  if (auto* r = of_kind.find(joint.key())) {
    of_kind.records.erase(r), state_.joints.changed();
    detail::wake_jointed(state_, joint.key());
  }
  state_.changed = true;
}

template <class Scenario>
template <class Kind>
const detail::joint_record<Kind>* world<Scenario>::find_joint(
    const joint_handle<Scenario, Kind>& joint) {
  note_reading("a joint_handle");
  const auto* r = state_.joints.template of<Kind>().find(joint.key());
  return r != nullptr && r->acts ? r : nullptr;
}

}  // namespace talus
