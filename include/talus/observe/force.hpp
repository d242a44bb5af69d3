#pragma once
// What contacts do to one body.
#include <algorithm>
#include <array>

#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/world/world.hpp"

namespace talus {

namespace detail {

/// Of hard contacts: their impulses over the length of the step.
template <class Scenario, class Shape>
[[nodiscard]] vec3 force_of_impulses(world<Scenario>& w, handle<Shape> h) {
  auto& s = w.state();
  // The contacts of a body that moves are all known to its owner; others are counted by the owners
  // of the bodies that meet it. (More ranks may remember them.)
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
  vec3 impulse{0, 0, 0};
  const auto add = [&](const detail::remembered_contact& c) {
    if (c.key.a != h.id && c.key.b != h.id) return;
    const bool first = c.key.a == h.id;
    const bool counts =
        fixed != 0 ? std::binary_search(own.begin(), own.end(), first ? c.key.b : c.key.a) : owned;
    if (counts) impulse += first ? c.memory : vec3(-c.memory);
  };
  for (const detail::remembered_contact& c : s.history.entries()) add(c);
  if constexpr (detail::world_state<Scenario>::sleeps) detail::each_frozen_contact(s, add);
  std::array<double, 3> sum{impulse[0], impulse[1], impulse[2]};
  w.link().reduce(reduction::sum, sum);
  return s.dt > 0 ? vec3(vec3(sum[0], sum[1], sum[2]) / s.dt) : vec3(0, 0, 0);
}

}  // namespace detail

/// Collective: the force of all contacts on the body: their impulse in the last step over its
/// length, or, where contacts are soft, their force in the present state; on a floor, it is the
/// weight above it. Every rank names the same body, which may be global or live on any rank. Zero
/// before the first step.
template <class Scenario, class Shape>
[[nodiscard]] vec3 contact_force(world<Scenario>& w, handle<Shape> h) {
  w.require_all_ranks("contact_force");
  auto& s = w.state();
  if constexpr (Scenario::contact_law::soft) {
    std::array<double, 3> sum{};
    detail::observe_forces(
        s, [&](const detail::contact_key& key, const vec3& force, bool on_a, bool on_b) {
          const int sign = (on_a && key.a == h.id) - (on_b && key.b == h.id);
          for (int k = 0; k < 3; ++k) sum[k] += sign * force[k];
        });
    w.link().reduce(reduction::sum, sum);
    return vec3(sum[0], sum[1], sum[2]);
  } else {
    return detail::force_of_impulses(w, h);
  }
}

}  // namespace talus
