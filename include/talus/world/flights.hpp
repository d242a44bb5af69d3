#pragma once
// What bodies can reach in a step lies in domains that theirs is connected to. Farther away, they
// would meet bodies that nobody there or here has heard of, and contacts would be lost.
#include <string>

#include "talus/world/coverage.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

/// Throws runtime_error for a body that left this domain in the step under way, for one that is
/// farther away than any connection. (Others were put there by the user, and are on their way.)
template <class Scenario, class Store>
[[gnu::cold]] void refuse_long_flight(const world_state<Scenario>& s, const Store& store,
                                      std::size_t i) {
  const vec3 &p = store.position[i], &v = store.velocity[i];
  vec3 before = p - s.dt * v;
  if constexpr (world_state<Scenario>::periodic) before = s.own.box().wrapped(before);
  if (!s.own.contains(before)) return;
  std::string where = "a domain";
  if constexpr (requires { s.own.partition()->owner(p); })
    if (s.own.partition() != nullptr)
      where = "the domain of rank " + std::to_string(s.own.partition()->owner(p));
  fail<std::runtime_error>(
      "body {} of rank {} flew from {} to {} in step {}, by its velocity {} and dt = {}, into {}, "
      "to "
      "which rank {} is not connected: choose a smaller dt, larger domains, or give the "
      "decomposition a reach",
      store.id[i], s.link->rank(), before, p, s.steps, v, s.dt, where, s.link->rank());
}

/// At the start of a step: throws runtime_error for a body whose way in it leads as far as a domain
/// to which this one is not connected.
template <class Scenario>
void refuse_uncovered_flights(const world_state<Scenario>& s) {
  if constexpr (!world_state<Scenario>::continuous && !world_state<Scenario>::law::soft &&
                requires { s.own.partition()->neighbours(0, real{}); }) {
    if (s.choice.announced <= s.own.covered()) return;
    s.each_finite_shape([&](const auto& b) {
      const auto& store = b.movable;
      for (std::size_t i = 0; i < store.locals; ++i) {
        if (!store.moves(i)) continue;  // a belt has a speed, and stays
        const vec3 &p = store.position[i], &v = store.velocity[i];
        const real radius = store.shape[i].bounding_radius(),
                   way = world_state<Scenario>::steps_of_reach * s.dt * v.norm();
        if (radius + way <= s.own.covered() || !s.own.contains(p)) continue;
        const vec3 middle = p + (real(0.5) * world_state<Scenario>::steps_of_reach * s.dt) * v;
        for (const int other : s.own.partition()->neighbours(s.own.rank(), radius + way)) {
          if (other == s.own.rank() || s.own.find(other) != nullptr || s.own.closed_to(other))
            continue;
          if (-any_geometry(s.own.partition()->geometry(other)).value(middle) >
              radius + real(0.5) * way)
            continue;
          fail<std::runtime_error>(
              "body {} of rank {} at {} would fly {} far in step {}, by its velocity {} and dt = "
              "{}, "
              "into the domain of rank {}, and ranks {} and {} are not connected, so contacts on "
              "its "
              "way would be lost: choose a smaller dt, or connect them ({})",
              store.id[i], s.link->rank(), p, text(way, 4), s.steps, v, s.dt, other, s.link->rank(),
              other, way_to_connect(s, s.own.rank(), other));
        }
      }
    });
  }
}

}  // namespace talus::detail
