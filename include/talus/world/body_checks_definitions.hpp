#pragma once
// The definitions of body_checks.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/shape/principal_axes.hpp"
#include "talus/world/body_checks.hpp"

namespace talus::detail {

TALUS_INLINE void require_finite(const char* what, const vec3& v) {
  if (!finite(v)) fail<std::invalid_argument>("{} must be finite, but is {}", what, text(v));
}

TALUS_INLINE void require_normal_mass(const char* shape, real mass, const vec3& moments) {
  if (!std::isnormal(mass) || !std::isnormal(1 / mass))
    fail<std::invalid_argument>(
        "the mass of a {}, density times volume, is {}, beyond what numbers can hold: choose "
        "units in which it is nearer to 1",
        shape, mass);
  for (int k = 0; k < 3; ++k)
    if (!std::isnormal(moments[k]) || !std::isnormal(1 / moments[k]))
      fail<std::invalid_argument>(
          "a moment of inertia of a {} is {}, beyond what numbers can hold: choose units in "
          "which its size is nearer to 1",
          shape, moments[k]);
}

TALUS_INLINE void require_inertia(const mat3& tensor, const char* shape, const vec3& position) {
  real largest = 0;
  for (int i = 0; i < 3; ++i) {
    if (!finite(tensor.col(i)))
      fail<std::invalid_argument>(
          "the inertia of a {} at {} has a column {}: all its numbers must be finite", shape,
          position, tensor.col(i));
    for (int j = 0; j < 3; ++j) largest = std::max(largest, std::abs(tensor(i, j)));
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j)
      if (!(std::abs(tensor(i, j) - tensor(j, i)) <= real(1e-12) * largest))
        fail<std::invalid_argument>(
            "the inertia of a {} at {} is not symmetric: in rows and columns {} and {} it has {} "
            "and {}, which must be equal",
            shape, position, j, i, tensor(j, i), tensor(i, j));
  const vec3 moments = principal_inertia<real>({0, 0, 0}, tensor).inertia;
  for (int i = 0; i < 3; ++i)
    if (const real one = moments[i]; !(one > 0) || !std::isnormal(one) || !std::isnormal(1 / one))
      fail<std::invalid_argument>(
          "the inertia of a {} at {} has the principal moments {}: each must be a number above 0, "
          "so give .inertia about the centre of mass, or leave it out for that of the shape",
          shape, position, moments);
  for (int i = 0; i < 3; ++i) {
    const real one = moments[i], others = moments[(i + 1) % 3] + moments[(i + 2) % 3];
    if (!(one <= others * (1 + real(1e-9))))
      fail<std::invalid_argument>(
          "the inertia of a {} at {} has the principal moments {}, and {} is more than the sum {} "
          "of the other two, which no distribution of mass has: correct the largest one, or leave "
          ".inertia out for that of the shape",
          shape, position, moments, one, others);
  }
}

TALUS_INLINE void require_own_mass(const own_mass& own, const char* shape, const vec3& position) {
  const auto require_number = [&](const given_number& number, const char* what,
                                  const char* otherwise) {
    if (!number) return;
    const real value = number.value();
    if (!(value > 0) || !std::isfinite(value))
      fail<std::invalid_argument>(
          "the {} of a {} at {} must be a finite number above 0, but is {}: leave .{} out for {}",
          what, shape, position, value, what, otherwise);
    if (!std::isnormal(value) || !std::isnormal(1 / value))
      fail<std::invalid_argument>(
          "the {} of a {} at {} is {}, beyond what numbers can hold: choose units in which it is "
          "nearer to 1",
          what, shape, position, value);
  };
  if (own.immovable && (own.mass || own.density || own.inertia || own.centre))
    fail<std::invalid_argument>(
        "a {} at {} is given {} of its own, but nothing can move a {}: leave it out", shape,
        position,
        own.mass      ? "a .mass"
        : own.density ? "a .density"
        : own.inertia ? "an .inertia"
                      : "a .centre",
        shape);
  require_number(own.mass, "mass", "density times volume");
  require_number(own.density, "density", "that of the material");
  if (own.mass && own.density)
    fail<std::invalid_argument>(
        "a {} at {} is given the mass {} and the density {}: leave one of the two out", shape,
        position, own.mass.value(), own.density.value());
  if (own.global && (own.mass || own.density))
    fail<std::invalid_argument>(
        "a {} at {} is global and is given the {} {}: leave it out, since nothing can ever move "
        "the body",
        shape, position, own.mass ? "mass" : "density",
        own.mass ? own.mass.value() : own.density.value());
  if (!own.takes_inertia && (own.inertia || own.centre))
    fail<std::invalid_argument>(
        "a {} at {} is given {} of its own, and only unions have one: make a union of one part, "
        "union_of<{}>(shape), and name it among the bodies of the scenario",
        shape, position, own.inertia ? "an .inertia" : "a .centre", shape);
  if (own.centre && !finite(own.centre.value()))
    fail<std::invalid_argument>("the centre of mass of a {} at {} must be finite, but is {}", shape,
                                position, own.centre.value());
  if (own.centre) {
    const real distance = (own.centre.value() - own.middle).norm();
    if (!(distance <= own.radius))
      fail<std::invalid_argument>(
          "the centre of mass {} of a {} at {} is {} radii from the middle of the shape, where the "
          "body has no mass: give .centre in the coordinates of the shape, not in those of the "
          "world",
          own.centre.value(), shape, position, distance / own.radius);
  }
}

}  // namespace talus::detail
