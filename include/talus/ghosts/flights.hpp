#pragma once
// Bodies can reach only domains that are connected to theirs in a step. Farther away, ranks there
// and here do not know each other's bodies, and contacts would be lost.
#include <string>

#include "talus/ghosts/coverage.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Throws runtime_error for a body that left this domain in the step under way to a place farther
/// away than any connection. (Other such bodies were placed by the user, and are migrating.)
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

/// At the start of a step: throws runtime_error for a body whose path in it leads to a domain that
/// is not connected to this one.
template <class Scenario>
void refuse_uncovered_flights(const world_state<Scenario>& s) {
  if constexpr (!world_state<Scenario>::continuous && !world_state<Scenario>::law::soft &&
                requires { s.own.partition()->neighbours(0, real{}); }) {
    if (s.choice.announced <= s.own.covered()) return;
    s.each_finite_shape([&](const auto& b) {
      const auto& store = b.movable;
      for (std::size_t i = 0; i < store.locals; ++i) {
        if (!store.moves(i)) continue;  // a belt has a speed, but stays
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
