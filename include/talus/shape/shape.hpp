#pragma once
// What a shape is to the library: plain data with geometry functions in its own frame, whose
// origin is the centre of mass and whose axes are the principal axes of inertia.
#include <concepts>

#include "talus/core/math.hpp"

namespace talus {

/// Any shape, infinite ones included. `finite` says whether it has a volume (and so a mass);
/// `round` whether its inertia is isotropic and every contact normal passes through its centre, so
/// that orientation never matters to contacts; `name` is how messages call it. `validate` throws
/// invalid_argument that names the wrong value.
template <class T>
concept shape = std::semiregular<T> && requires(const T s) {
  { T::finite } -> std::convertible_to<bool>;
  { T::round } -> std::convertible_to<bool>;
  { T::name } -> std::convertible_to<const char*>;
  { s.validate() } -> std::same_as<void>;
};

/// A shape with a volume. `bounding_radius`: of the smallest ball about the centre of mass;
/// `volume`; `inertia`: principal moments per unit mass (length squared); `support(direction)`: a
/// point furthest along a direction of any length, both in the frame of the body;
/// `half_extents(pose)`: half edges of the axis-aligned box of the posed shape.
template <class T>
concept finite_shape = shape<T> && T::finite && requires(const T s, const vec3 v, const pose p) {
  { s.bounding_radius() } -> std::convertible_to<real>;
  { s.volume() } -> std::convertible_to<real>;
  { s.inertia() } -> std::convertible_to<vec3>;
  { s.support(v) } -> std::convertible_to<vec3>;
  { s.half_extents(p) } -> std::convertible_to<vec3>;
};

}  // namespace talus
