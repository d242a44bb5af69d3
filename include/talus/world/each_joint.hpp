#pragma once
// The joints of the present state, for outputs and observers: each of them once, on any ranks of
// its bodies.
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/constraint/joint_geometry.hpp"
#include "talus/state/joints.hpp"
#include "talus/world/body_places.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// A joint. Its force and torque are its impulses in the last step over the length of that step;
/// points and centres are those of the present state.
struct joint_in_world {
  const char* name = "";           ///< of its kind
  std::uint32_t kind = 0;          ///< place of its kind in joints<...>, from 0
  system_id a = no_id, b = no_id;  ///< the bodies, as they were joined; no_id is the world frame
  std::uint64_t number = 0;        ///< of the call that joined them
  vec3 point_a{0, 0, 0};           ///< its point on a, in the world
  vec3 point_b{0, 0, 0};           ///< its point on b
  vec3 centre_a{0, 0, 0};          ///< centre of mass of a; its point if a cannot move
  vec3 centre_b{0, 0, 0};          ///< of b
  vec3 force{0, 0, 0};             ///< on a; on b its opposite
  vec3 torque{0, 0, 0};            ///< on a, about its point
  real angle = 0;                  ///< radians, if the kind has an angle
  real travel = 0;                 ///< length, if the kind has a travel
};

/// Calls f(joint) for the joints of the present state: over all ranks once for each, on the rank
/// that owns its body a, or b if a cannot move. No rank waits for another. Forces are 0 before the
/// first step.
template <class Scenario, class F>
void for_each_joint(world<Scenario>& w, F&& f) {
  w.note_reading("for_each_joint");
  auto& s = detail::state_of(w);
  if constexpr (detail::world_state<Scenario>::has_joints) {
    if (s.joints.size() == 0) return;
    const detail::body_places<Scenario> places(s);
    struct seen {
      pose at;
      bool known = false, moves = false, own = false;
    };
    const auto look = [&](system_id id) {
      seen x;
      x.known = id == detail::id_of_world;
      (void)places.visit(id, [&](const auto& store, std::size_t i, bool global) {
        x = {store.pose(i), true, !global && !store.fixed(i), !global && i < store.locals};
      });
      return x;
    };
    std::uint32_t kind_number = 0;
    s.joints.each_kind([&](auto& of_kind) {
      using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
      for (const auto& r : of_kind.records) {
        const seen a = look(r.key.a);
        seen b = look(r.key.b);
        if (!a.known || !b.known || !(a.moves ? a.own : b.own)) continue;
        b.at.position = detail::seen_from(s, r.anchors.frames, a.at, b.at.position);
        const auto g = detail::geometry_of(r.anchors.frames, a.at, b.at);
        joint_in_world x{.name = kind::name, .kind = kind_number, .number = r.key.number};
        if (r.key.a != detail::id_of_world) x.a = r.key.a;
        if (r.key.b != detail::id_of_world) x.b = r.key.b;
        x.point_a = a.at.position + g.arm_a, x.point_b = b.at.position + g.arm_b;
        x.centre_a = a.moves ? a.at.position : x.point_a;
        x.centre_b = b.moves ? b.at.position : x.point_b;
        if (s.dt > 0) x.force = r.load.impulse / s.dt, x.torque = r.load.moment / s.dt;
        constexpr bool turns = requires { requires kind::has_angle; };
        if constexpr (turns) x.angle = r.coordinates[0];
        if constexpr (requires { requires kind::has_travel; }) x.travel = r.coordinates[turns];
        f(static_cast<const joint_in_world&>(x));
      }
      ++kind_number;
    });
  }
}

}  // namespace talus
