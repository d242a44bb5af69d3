#pragma once
// The force and torque of contacts on one body.
#include <algorithm>
#include <array>

#include "talus/core/exact_sum.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus {

namespace detail {

/// The force of hard contacts on a body: their impulses over the length of the step.
template <class Scenario, class Shape>
[[nodiscard]] vec3 force_of_impulses(world<Scenario>& w, handle<Shape> h) {
  auto& s = state_of(w);
  // The owner of a movable body knows all its contacts; those of others are counted by the owners
  // of their partners. (More ranks may store them.)
  detail::plain_vector<system_id> own;
  bool owned = false;
  w.for_each_local([&](const auto& b) {
    own.push_back(b.id());
    owned = owned || b.id() == h.id;
  });
  detail::sort_values(own);
  const auto found = w.find(h);
  double fixed = found && found->is_fixed();
  w.link().reduce(reduction::max, std::span(&fixed, 1));
  detail::vector_sum impulse;
  const auto add = [&](const detail::stored_contact& c) {
    if (c.key.a != h.id && c.key.b != h.id) return;
    const bool first = c.key.a == h.id;
    const bool counts =
        fixed != 0 ? std::binary_search(own.begin(), own.end(), first ? c.key.b : c.key.a) : owned;
    if (counts) impulse += first ? c.memory : vec3(-c.memory);
  };
  for (const detail::stored_contact& c : s.history.entries()) add(c);
  if constexpr (detail::world_state<Scenario>::sleeps) detail::each_frozen_contact(s, add);
  sum_exactly(w.link(), impulse);
  return s.dt > 0 ? vec3(impulse.value() / s.dt) : vec3(0, 0, 0);
}

/// Force and torque of all contacts on one body, as this rank counts them.
struct load_about_point {
  system_id body;
  bool global;  ///< its torque is about `about`, that of any other body about its centre
  vec3 about;
  vector_sum force{}, torque{};

  /// A contact of a and b with a force and a moment on a; centres as seen from a.
  void add(system_id a, system_id b, const vec3& point, const vec3& centre_a, const vec3& centre_b,
           const vec3& on_a, const vec3& moment_on_a) {
    if (a != body && b != body) return;
    const real sign = a == body ? 1 : -1;
    const vec3 f = sign * on_a;
    const vec3 arm = point - (global ? about : a == body ? centre_a : centre_b);
    force += f;
    torque += vec3(arm.cross(f) + sign * moment_on_a);
  }
};

}  // namespace detail

/// Collective: the force of all contacts on the body: their impulse in the last step over its
/// length, or, if contacts are soft, their force in the present state; on a floor, it is the weight
/// above it. Every rank names the same body, which may be global or live on any rank. Zero before
/// the first step.
template <class Scenario, class Shape>
[[nodiscard]] vec3 contact_force(world<Scenario>& w,
                                 handle<Shape> h) requires(detail::takes_shape<Scenario, Shape>) {
  if constexpr (detail::require_shape<Scenario, Shape>()) {
    w.require_all_ranks("contact_force");
    auto& s = detail::state_of(w);
    if constexpr (Scenario::contact_law::soft) {
      detail::vector_sum sum;
      detail::observe_forces(
          s, [&](const detail::contact_key& key, const vec3& force, bool on_a, bool on_b) {
            const int sign = (on_a && key.a == h.id) - (on_b && key.b == h.id);
            if (sign != 0) sum += vec3(sign * force);
          });
      detail::sum_exactly(w.link(), sum);
      return sum.value();
    } else {
      return detail::force_of_impulses(w, h);
    }
  } else {
    return (void)w, (void)h, vec3(0, 0, 0);
  }
}

/// Refuses a shape that the scenario does not name.
template <class Scenario, class Shape,
          detail::sentence Says = detail::words_on_missing_shape<Shape>()>
vec3 contact_force(world<Scenario>&,
                   handle<Shape>) requires(!detail::takes_shape<Scenario, Shape>) = delete;

/// Collective: the torque of all contacts on the body about the point `about` of the world, moments
/// of rolling friction included. The forces are those of contact_force(); they act at the present
/// contact points. Every rank names the same body, which may be global or live on any rank. In a
/// periodic box the body counts at its centre. Zero before the first step.
template <class Scenario, class Shape>
[[nodiscard]] vec3 contact_torque(world<Scenario>& w, handle<Shape> h, const vec3& about) requires(
    detail::takes_shape<Scenario, Shape>) {
  if constexpr (detail::require_shape<Scenario, Shape>()) {
    w.require_all_ranks("contact_torque");
    auto& s = detail::state_of(w);
    const auto found = w.find(h);
    detail::load_about_point load{h.id, found && found->is_global(), about};
    if constexpr (Scenario::contact_law::soft) {
      detail::observe_forces(
          s, [&](const detail::contact_key& key, const vec3& point, const vec3& centre_a,
                 const vec3& centre_b, const detail::pair_force& f, bool counts) {
            if (counts) load.add(key.a, key.b, point, centre_a, centre_b, f.force, f.moment);
          });
    } else {
      detail::each_loaded_contact(s, [&](const loaded_contact& c, bool counts) {
        if (counts) load.add(c.a, c.b, c.point, c.centre_a, c.centre_b, c.force, {0, 0, 0});
      });
    }
    // The owner has the position of the centre, for any image of it on other ranks.
    const bool owner = found && !load.global && !found->is_remote();
    detail::vector_sum arm;
    if (owner) arm += vec3(found->position() - about);
    detail::sum_exactly(w.link(), load.force, load.torque, arm);
    return load.torque.value() + arm.value().cross(load.force.value());
  } else {
    return (void)w, (void)h, about;
  }
}
/// Refuses a shape that the scenario does not name.
template <class Scenario, class Shape,
          detail::sentence Says = detail::words_on_missing_shape<Shape>()>
vec3 contact_torque(world<Scenario>&, handle<Shape>,
                    const vec3&) requires(!detail::takes_shape<Scenario, Shape>) = delete;

}  // namespace talus
