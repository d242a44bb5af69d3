#pragma once
// Bodies must not reach ranks that the decomposition does not connect to theirs on purpose.
#include "talus/state/state.hpp"

namespace talus::detail {

/// Throws runtime_error for the first body owned here whose bounds reach a closed face. Only bodies
/// next to the boundary of the domain are tested exactly, by their shape instead of the ball around
/// it. Bodies whose centre is elsewhere are about to migrate (`departed`: they have just left, and
/// must not have crossed a closed face).
template <class Scenario>
void refuse_closed_faces(const world_state<Scenario>& s, bool departed) {
  using domain_type = typename world_state<Scenario>::domain_type;
  if constexpr (requires { requires domain_type::closing; }) {
    if (s.own.closed().empty()) return;
    s.each_finite_shape([&](const auto& b) {
      const auto& store = b.movable;
      for (std::size_t i = 0; i < store.locals; ++i) {
        const vec3& p = store.position[i];
        const real radius = store.shape[i].bounding_radius();
        if (s.own.interior_distance(p) > radius || !finite(p)) continue;
        const bool inside = s.own.contains(p);
        if (!inside && !departed) continue;
        for (const closed_neighbour& c : s.own.closed()) {
          if (s.own.find(c.rank())) continue;  // connected by hand
          const auto place = c.within(p, inside ? radius : 0);
          if (!place) continue;
          if (place->distance > 0) {
            const vec3 towards = (place->nearest - p) / place->distance;
            const pose at = store.pose(i);
            const vec3 tip = at.to_world(
                store.shape[i].support(pose{{0, 0, 0}, at.orientation}.to_body(towards)));
            if ((tip - p).dot(towards) < place->distance) continue;
          }
          fail<std::runtime_error>(
              "body {} ({}) at {} reaches a closed face in step {}: rank {} owns the body, and is "
              "not connected to rank {}, which begins at {} (where {}); keep bodies away from "
              "there "
              "(a fixed body, or fewer ranks where they are narrow), declare the face open, or "
              "connect the two ranks on both sides",
              store.id[i], std::remove_cvref_t<decltype(store)>::shape_type::name, text(p), s.steps,
              s.link->rank(), c.rank(), text(place->nearest), to_string(place->face));
        }
      }
    });
  }
}

}  // namespace talus::detail
