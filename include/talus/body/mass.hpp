#pragma once
// The mass of a body: of its description, and of a body in a store.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "talus/body/body.hpp"
#include "talus/body/material.hpp"
#include "talus/shape/frame.hpp"

namespace talus::detail {

/// Whether bodies of the shape can have a centre and an inertia of their own.
template <class Shape>
inline constexpr bool takes_inertia = requires(const Shape& s, const vec3& x, const mat3& m) {
  s.with_centre(x);
  s.with_inertia(x, m);
};

/// The mass that a description asks for.
template <class Shape>
[[nodiscard]] real mass_of(const body<Shape>& b, const material_table& materials) {
  if (b.mass) return b.mass.value();
  return (b.density ? b.density.value() : materials[b.material].density) * b.shape.volume();
}

/// The mass of body i of a store, also of a fixed one; 0 of a shape that has none.
template <class Store>
[[nodiscard]] real mass_of(const Store& store, std::size_t i, const material_table& materials) {
  using shape = typename Store::shape_type;
  if constexpr (!shape::finite || requires { shape::immovable; }) {
    return 0;
  } else {
    const real by_volume = materials[store.material[i]].density * store.shape[i].volume();
    const real inverse =
        store.keeps_mass(i) ? store.kept.inverse_of(store.id[i]) : store.inverse_mass[i];
    return inverse == 0 || inverse == 1 / by_volume ? by_volume : 1 / inverse;
  }
}

/// The inertia per unit mass, rounded to 7e-15 of its largest number, so that bodies of one form
/// and different masses share one union although divisions round.
[[nodiscard]] inline mat3 inertia_per_mass(const mat3& inertia, real mass) {
  real largest = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) largest = std::max(largest, std::abs(inertia(i, j) / mass));
  int exponent = 0;
  (void)std::frexp(largest, &exponent);
  mat3 rounded = inertia;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      rounded(i, j) = std::ldexp(std::nearbyint(std::ldexp(inertia(i, j) / mass, 47 - exponent)),
                                 exponent - 47);
  return rounded;
}

/// A description that was checked, with centre and inertia in its shape, and the pose of the frame
/// of the body. The shape stays where it is.
template <class Shape>
[[nodiscard]] decltype(auto) with_own_inertia(const body<Shape>& b,
                                              const material_table& materials) {
  if constexpr (takes_inertia<Shape>) {
    body<Shape> own = b;
    if (b.inertia || b.centre) {
      const vec3 centre = b.centre ? b.centre.value() : b.shape.frame().position;
      own.shape = b.inertia ? b.shape.with_inertia(centre, inertia_per_mass(b.inertia.value(),
                                                                            mass_of(b, materials)))
                            : b.shape.with_centre(centre);
      const pose coordinates = given_frame(b.shape, {b.position, b.orientation.normalized()});
      const pose at = placed(own.shape, coordinates);
      own.position = at.position, own.orientation = at.orientation;
      own.inertia = {}, own.centre = {};
    }
    return own;
  } else {
    return (b);
  }
}

}  // namespace talus::detail
