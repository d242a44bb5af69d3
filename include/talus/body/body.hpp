#pragma once
// The description with which a user creates a body.
#include <cstdint>

#include "talus/body/material.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"

namespace talus {

inline namespace a_body_has_shape_position_material_velocity_angular_velocity_orientation_user_id_and_fixed {

/// Description of a rigid body to be created: `body{.shape = sphere{0.5}, .position = {0, 0, 1}}`.
template <class Shape>
struct body {
  /// form and size, such as sphere{0.5}
  Shape shape;
  vec3 position{0, 0, 0};          ///< of the centre of mass
  material_id material{};          ///< from world.material(...); the first one by default
  vec3 velocity{0, 0, 0};          ///< of the centre of mass
  vec3 angular_velocity{0, 0, 0};  ///< radians per unit of time, world frame
  quat orientation{1, 0, 0, 0};    ///< ignored if the scenario stores none
  std::uint32_t user_id = 0;       ///< any number, need not be unique; features<user_ids>
  bool fixed = false;              ///< immovable, as if of infinite mass
};

/// The shape alone determines the type, so that the compiler reports a field that does not exist.
template <class Shape>
body(Shape, ...) -> body<Shape>;

}  // namespace
   // a_body_has_shape_position_material_velocity_angular_velocity_orientation_user_id_and_fixed

/// Refers to a body on any rank; stays valid when the body migrates to another rank.
template <class Shape>
struct handle {
  /// the same on all ranks
  system_id id = no_id;

  /// Refuses what only the view of a body has; the other members of a view get the compiler's
  /// message.
  template <class S = Shape>
  vec3 position() const {
    return refuse<S>();
  }
  /// Refuses it likewise.
  template <class S = Shape>
  vec3 velocity() const {
    return refuse<S>();
  }

  friend bool operator==(handle, handle) = default;

 private:
  template <class S>
  static vec3 refuse() {
    static_assert(sizeof(S) == 0,
                  "a handle is the number of a body: write world[handle].position() and the like, "
                  "on a rank that has the body or a copy of it");
    return {};
  }
};

}  // namespace talus
