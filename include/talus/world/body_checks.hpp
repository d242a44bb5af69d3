#pragma once
// Requirements on a body that is added.
#include <cmath>

#include "talus/body/body.hpp"
#include "talus/body/material.hpp"
#include "talus/core/error.hpp"

namespace talus::detail {

void require_finite(const char* what, const vec3& v);

/// Throws invalid_argument, with the value, for a body with values out of range or not finite.
template <class Shape>
void require_sane(const body<Shape>& b, const material_table& materials) {
  b.shape.validate();
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
  const real density = materials[b.material].density;
  if constexpr (Shape::finite) {
    const real mass = density * b.shape.volume();
    if (!std::isnormal(mass) || !std::isnormal(1 / mass))
      fail<std::invalid_argument>(
          "the mass of a {}, density times volume, is {}, beyond what numbers can hold: choose "
          "units in which it is nearer to 1",
          Shape::name, mass);
    const vec3 moments = mass * b.shape.inertia();
    for (int k = 0; k < 3; ++k)
      if (!std::isnormal(moments[k]) || !std::isnormal(1 / moments[k]))
        fail<std::invalid_argument>(
            "a moment of inertia of a {} is {}, beyond what numbers can hold: choose units in "
            "which its size is nearer to 1",
            Shape::name, moments[k]);
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
