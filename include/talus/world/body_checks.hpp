#pragma once
// Requirements on a body that is added.
#include <cmath>

#include "talus/body/body.hpp"
#include "talus/body/mass.hpp"
#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/shape/support_check.hpp"

namespace talus::detail {

void require_finite(const char* what, const vec3& v);

/// The mass properties that a description gives beside its shape.
struct own_mass {
  given_number density, mass;
  given_inertia inertia;
  given_point centre;
  bool global, immovable, takes_inertia;
  vec3 middle{0, 0,
              0};   ///< of the ball around a shape with a centre of its own, in its coordinates
  real radius = 0;  ///< of that ball
};
template <class Shape>
[[nodiscard]] own_mass own_mass_of(const body<Shape>& b, bool global) {
  constexpr bool immovable = !Shape::finite || requires { Shape::immovable; };
  own_mass own{b.density, b.mass, b.inertia, b.centre, global, immovable, takes_inertia<Shape>};
  if constexpr (takes_inertia<Shape>)
    own.middle = b.shape.frame().position, own.radius = b.shape.bounding_radius();
  return own;
}
/// Throws invalid_argument, with the values, for what no body can have, and for what bodies of the
/// shape cannot have.
[[gnu::cold]] void require_own_mass(const own_mass& own, const char* shape, const vec3& position);

/// Throws invalid_argument, with the values, unless a distribution of mass can have the tensor.
[[gnu::cold]] void require_inertia(const mat3& tensor, const char* shape, const vec3& position);

/// Throws invalid_argument, with the value, for a mass or principal moments that are not normal
/// numbers.
[[gnu::cold]] void require_normal_mass(const char* shape, real mass, const vec3& moments);

/// Throws invalid_argument, with the value, for a body with values out of range or not finite.
template <class Shape>
void require_sane(const body<Shape>& b, const material_table& materials, bool global = false) {
  b.shape.validate();
  if constexpr (has_tested_shape<Shape>) require_convex(b.shape);
  require_finite("the position of a body", b.position);
  require_finite("the velocity of a body", b.velocity);
  require_finite("the angular velocity of a body", b.angular_velocity);
  if (!(std::abs(b.orientation.norm() - 1) < 1e-6))
    fail<std::invalid_argument>(
        "the orientation of a body must be a unit quaternion, but its norm is {}",
        b.orientation.norm());
  if (materials.size() == 0)
    fail<std::invalid_argument>(
        "the world has no material yet: make one with world.material(...) before adding bodies");
  if (b.density || b.mass || b.inertia || b.centre)
    require_own_mass(own_mass_of(b, global), Shape::name, b.position);
  if constexpr (takes_inertia<Shape>)
    if (b.inertia) require_inertia(b.inertia.value(), Shape::name, b.position);
  if constexpr (Shape::finite) {
    const real mass = mass_of(b, materials);
    const vec3 moments = mass * b.shape.inertia();
    bool normal = std::isnormal(mass) && std::isnormal(1 / mass);
    for (int k = 0; k < 3; ++k)
      normal = normal && std::isnormal(moments[k]) && std::isnormal(1 / moments[k]);
    if (!normal) require_normal_mass(Shape::name, mass, moments);
  }
}

/// Throws logic_error for a movable body without mass.
template <class Shape>
void require_movable(const body<Shape>& b, int rank) {
  if constexpr (requires { Shape::immovable; })
    if (!b.fixed)
      fail<std::logic_error>(
          "a {} has no mass, so nothing can move it, but rank {} added one to the bodies that "
          "move: add it in world.global(...), or with .fixed = true; to make it move, build it of "
          "convex parts, as a convex_polyhedron or a union_of<convex_polyhedron>",
          Shape::name, rank);
}

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/world/body_checks_definitions.hpp"
#endif
