#pragma once
// The contacts of the present state that carry a force, for outputs and observers: alike for hard
// and soft ones, and each of them once, on any ranks of its bodies.
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "talus/contact/acting_memory.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/features/sleeping/sleeping_islands.hpp"
#include "talus/step/soft_step.hpp"
#include "talus/world/body_places.hpp"
#include "talus/world/fresh_start.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// A contact that carries a force. For a hard one the force is its impulse in the last step over
/// the length of that step, and point and normal are those of the present surfaces, after the step;
/// for a soft one everything is of the present state.
struct loaded_contact {
  system_id a = no_id, b = no_id;         ///< the bodies; b may be global
  std::uint64_t feature = 0;              ///< identifies the point within the pair
  vec3 point{0, 0, 0};                    ///< midway between the surfaces, in the world
  vec3 normal{0, 0, 1};                   ///< unit, from b towards a
  real gap = 0;                           ///< signed distance of the surfaces; overlap < 0
  vec3 force{0, 0, 0};                    ///< on a; on b its opposite
  vec3 centre_a{0, 0, 0};                 ///< centre of mass of a
  vec3 centre_b{0, 0, 0};                 ///< of b; the point itself if b is infinite
  bool moves_a = true, moves_b = true;    ///< whether the body can move: neither fixed nor global
  bool owned_a = false, owned_b = false;  ///< whether this rank owns the body; false if global

  /// Positive if the bodies push each other apart.
  [[nodiscard]] real normal_force() const { return normal.dot(force); }
  /// Force of friction on a.
  [[nodiscard]] vec3 tangential_force() const { return force - normal_force() * normal; }
};

namespace detail {

/// The position of a body as its owner has it. That of a shadow copy may be an image.
template <class State, class Store>
[[nodiscard]] vec3 position_of_owner(const State& s, const Store& store, std::size_t i,
                                     bool global) {
  if constexpr (State::periodic && Store::shape_type::finite)
    if (!global)
      if (const auto* copy = copy_of<typename Store::shape_type>(s, i);
          copy != nullptr && copy->image != 0)
        return copy->home;
  return (void)s, (void)global, store.position[i];
}

/// Fills in the data of the contact's bodies, and whether b has a centre; false if one of them no
/// longer exists.
template <class Scenario>
[[nodiscard]] bool add_ends(const body_places<Scenario>& places, loaded_contact& c, bool& bounded) {
  bool images = false;
  const auto add = [&](system_id id, vec3& centre, bool& moves, bool& owned) {
    return places.visit(id, [&](const auto& store, std::size_t i, bool global) {
      bounded = std::remove_cvref_t<decltype(store)>::shape_type::finite;
      images = !global;
      centre = position_of_owner(places.state(), store, i, global);
      moves = !global && !store.fixed(i);
      owned = !global && i < store.locals;
    });
  };
  if (!add(c.a, c.centre_a, c.moves_a, c.owned_a) || !add(c.b, c.centre_b, c.moves_b, c.owned_b))
    return false;
  if (images) c.centre_b = seen_from(places.state(), c.centre_a, c.centre_b);
  return true;
}

/// How far the surfaces of a pair may have separated in the last step.
template <class Store>
[[nodiscard]] real way_of_surface(const Store& s, std::size_t i, real dt) {
  if constexpr (!Store::shape_type::finite)
    return 0;
  else
    return 2 * (reach_of(s, i, dt) - s.shape[i].bounding_radius());
}

/// The contact points of one pair after another, computed at the present poses.
template <class Scenario>
class pair_points {
 public:
  pair_points(const world_state<Scenario>& s, const body_places<Scenario>& places)
      : s_(s), places_(places) {}

  /// Point and normal of a contact with known key and force. If the surfaces have separated or
  /// rotated since, the nearest point of the pair; if there is none, the line of the force through
  /// the centre of a. Hard contacts never pull: if this one would, the force defines the normal.
  void place(loaded_contact& c) {
    if (c.a != a_ || c.b != b_) find(c.a, c.b);
    const contact_geometry* best = nullptr;
    for (const contact_geometry& g : points_) {
      if (g.feature == c.feature) {
        best = &g;
        break;
      }
      if (best == nullptr || g.gap < best->gap) best = &g;
    }
    c.normal = best != nullptr && best->normal.dot(c.force) > 0 ? best->normal : unit(c.force);
    c.point = best != nullptr ? best->point : vec3(centre_ - radius_ * c.normal);
    c.gap = best != nullptr ? best->gap : 0;
  }

 private:
  void find(system_id a, system_id b) {
    a_ = a, b_ = b;
    points_.clear();
    places_.visit(a, [&](const auto& one, std::size_t i, bool global_a) {
      using A = typename std::remove_cvref_t<decltype(one)>::shape_type;
      if constexpr (A::finite) {
        centre_ = position_of_owner(s_, one, i, global_a);
        radius_ = one.shape[i].bounding_radius();
        places_.visit(b, [&](const auto& other, std::size_t j, bool global) {
          using B = typename std::remove_cvref_t<decltype(other)>::shape_type;
          if constexpr (collidable<A, B>) {
            const vec3 place = position_of_owner(s_, other, j, global);
            collide_pair(
                one.shape[i], {centre_, one.pose(i).orientation}, other.shape[j],
                {global ? place : seen_from(s_, centre_, place), other.pose(j).orientation},
                way_of_surface(one, i, s_.dt) + way_of_surface(other, j, s_.dt),
                [&](const contact_geometry& g) { points_.push_back(g); });
          }
        });
      }
    });
  }

  const world_state<Scenario>& s_;
  const body_places<Scenario>& places_;
  system_id a_ = no_id, b_ = no_id;
  vec3 centre_{0, 0, 0};
  real radius_ = 0;
  plain_vector<contact_geometry> points_;
};

/// The observer of soft forces that calls f(contact, counts_here) for those that are not zero.
template <class Scenario, class F>
[[nodiscard]] auto soft_reporter(const world_state<Scenario>& s,
                                 const body_places<Scenario>& places, F& f) {
  return [&](const contact_key& key, const contact_geometry& g, const vec3& force, bool counts) {
    if (force[0] == 0 && force[1] == 0 && force[2] == 0) return;
    loaded_contact c{.a = key.a, .b = key.b, .feature = key.feature};
    c.point = g.point, c.normal = g.normal, c.force = force, c.gap = g.gap;
    bool bounded = true;
    if (!add_ends(places, c, bounded)) return;
    c.point = seen_from(s, c.centre_a, c.point);
    if (!bounded) c.centre_b = c.point;
    f(std::as_const(c), counts);
  };
}

struct all_contacts {
  bool operator()(const contact_key&) const { return true; }
};

/// Collective: calls f(contact, counts_here) for the contacts that carry a force and have a body
/// owned here: over all ranks each counts once. Of hard contacts only those for whose key
/// select(key) holds. At a stage of the step no rank waits for another.
template <bool AtStage = false, class Scenario, class F, class Select = all_contacts>
void each_loaded_contact(world_state<Scenario>& s, const body_places<Scenario>& places, F&& f,
                         [[maybe_unused]] Select select = {}) {
  if constexpr (Scenario::contact_law::soft) {
    auto report = soft_reporter(s, places, f);
    if constexpr (AtStage)
      observe_contacts(s, report);
    else
      observe_forces(s, report);
  } else {
    if (!(s.dt > 0)) return;
    pair_points<Scenario> points(s, places);
    const auto tell = [&](const stored_contact& r) {
      if (!has_acted(r.memory) || !select(r.key)) return;
      loaded_contact c{.a = r.key.a, .b = r.key.b, .feature = r.key.feature};
      c.force = r.memory / s.dt;
      bool bounded = true;
      if (!add_ends(places, c, bounded)) return;
      // Both owners of a movable body store its contacts; other ranks may, too.
      if (!(c.owned_a && c.moves_a) && !(c.owned_b && c.moves_b)) return;
      points.place(c);
      if (!bounded) c.centre_b = c.point;
      f(std::as_const(c), c.moves_a ? c.owned_a : c.owned_b);
    };
    for (const stored_contact& r : s.history.entries()) tell(r);
    if constexpr (world_state<Scenario>::sleeps) each_frozen_contact(s, tell);
  }
}
template <class Scenario, class F>
void each_loaded_contact(world_state<Scenario>& s, F&& f) {
  each_loaded_contact(s, body_places<Scenario>(s), f);
}

}  // namespace detail

/// Collective: calls f(contact) for the contacts of the present state that carry a force: over all
/// ranks once for each, on the rank that owns its body a, or b if a cannot move. With
/// integrator<velocity_verlet> neighbours exchange velocities first. There are none before the
/// first step.
template <class Scenario, class F>
void for_each_contact(world<Scenario>& w, F&& f) {
  w.require_all_ranks("for_each_contact");
  detail::each_loaded_contact(detail::state_of(w), [&](const loaded_contact& c, bool counts) {
    if (counts) f(c);
  });
}

}  // namespace talus
