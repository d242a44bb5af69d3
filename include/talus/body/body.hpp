#pragma once
// The description with which a user creates a body.
#include <cstdint>

#include "talus/body/given.hpp"
#include "talus/body/material.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"

namespace talus {

inline namespace a_body_has_shape_position_material_velocity_angular_velocity_orientation_user_id_fixed_density_mass_inertia_and_centre {

/// Description of a rigid body to be created: `body{.shape = sphere{0.5}, .position = {0, 0, 1}}`.
/// Its mass is the density of its material times the volume of the shape, and the shape gives
/// centre and inertia, unless the last four fields say otherwise. A body with a centre or an
/// inertia of its own is a union, of one part if need be: `body{.shape =
/// union_of<sphere>{sphere{1}}, .centre = {0, 0, -0.3}}`. Position and orientation are always those
/// of the frame of the shape: of the centre of mass and the principal axes that it has by density
/// and volume. So `.mass`, `.inertia` and `.centre` move no point of the body. After it is added,
/// its position is that of its own centre of mass.
template <class Shape>
struct body {
  /// form and size, such as sphere{0.5}
  Shape shape;
  vec3 position{0, 0, 0};          ///< of the centre of mass of the shape
  material_id material{};          ///< from world.material(...); the first one by default
  vec3 velocity{0, 0, 0};          ///< of the centre of mass
  vec3 angular_velocity{0, 0, 0};  ///< radians per unit of time, world frame
  quat orientation{1, 0, 0, 0};    ///< of the axes of the shape; ignored if none is stored
  std::uint32_t user_id = 0;       ///< any number, need not be unique; features<user_ids>
  bool fixed = false;              ///< immovable, as if of infinite mass
  given_number density{};          ///< instead of that of the material
  given_number mass{};             ///< instead of density times volume; scales the inertia
  /// The inertia about the centre of mass, along the axes of the shape; if left out, that of the
  /// shape about its own centre
  given_inertia inertia{};
  /// The centre of mass, in the coordinates of the shape (length)
  given_point centre{};
};

/// The shape alone determines the type, so that the compiler reports a field that does not exist.
template <class Shape>
body(Shape, ...) -> body<Shape>;

}  // namespace
   // a_body_has_shape_position_material_velocity_angular_velocity_orientation_user_id_fixed_density_mass_inertia_and_centre

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
