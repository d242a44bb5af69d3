#pragma once
// The flat faces and straight edges of a convex shape, as the general contact search needs them.
// The member `form()` of a shape returns one of them, as that of convex_polyhedron does with the
// mesh_form of polyhedron_mesh.hpp; a shape without that member is smooth: its support function is
// all that is known of it.
#include <utility>

#include "talus/core/math.hpp"
#include "talus/shape/surface_level.hpp"

namespace talus {

/// A cuboid about the origin, along the axes.
struct block_form {
  static constexpr int order = 1;
  vec3 half;  ///< half of its edges
  /// The largest number of corners of a face.
  [[nodiscard]] int corners() const { return 4; }
};
/// All points within `rounding` of a segment of the z axis.
struct segment_form {
  static constexpr int order = 2;
  real half = 0;      ///< half the length of the segment
  real rounding = 0;  ///< length
  [[nodiscard]] int corners() const { return 2; }
};
/// A round drum about the z axis with two flat ends.
struct drum_form {
  static constexpr int order = 3;
  real radius = 0, half = 0;  ///< half: of its length
  [[nodiscard]] int corners() const { return 16; }
};
/// A ball about the origin.
struct ball_form {
  static constexpr int order = 6;
  real radius = 0;
  [[nodiscard]] int corners() const { return 1; }
};
/// A body without faces and edges, by its support function.
struct smooth_form {
  static constexpr int order = 5;
  const void* shape = nullptr;  ///< outlives the form
  vec3 (*support)(const void*, const vec3& direction) = nullptr;
  real thickness = 0;  ///< half of the smallest, about
  real inner = 0;      ///< radius of a ball about the origin that is inside
  real sharpest = 0;   ///< smallest radius of curvature, about
  /// The surface of the shape, or null: the general search needs it for exact points where the
  /// shape is flat.
  surface_level (*level)(const void*, const vec3& point) = nullptr;
  /// Points furthest along directions that are a thousandth apart are corners of a flat side if
  /// they are further apart than this; 0 for a shape that is round everywhere.
  real flat = 0;
  [[nodiscard]] int corners() const { return flat > 0 ? 16 : 1; }
};

namespace detail {

/// Whether flat sides are looked for: as the member `flat_sides` says, or if there is none, where
/// no function gives the surface itself.
template <class Shape>
[[nodiscard]] constexpr bool may_have_flat_sides() {
  constexpr bool bends = requires(const Shape& s) { s.bend(vec3{}); };
  constexpr bool level = requires(const Shape& s) { s.level(vec3{}); };
  if constexpr (requires { Shape::flat_sides; })
    return bool(Shape::flat_sides);
  else
    return !bends && !level;
}

/// The form of a convex shape: its own, or a smooth one. The shape outlives it. A smooth shape that
/// does not give its smallest radius of curvature has that of an ellipsoid of its size.
template <class Shape>
[[nodiscard]] auto form_of(const Shape& s) {
  if constexpr (requires { s.form(); }) {
    return s.form();
  } else {
    smooth_form f{&s, [](const void* shape, const vec3& direction) -> vec3 {
                    return static_cast<const Shape*>(shape)->support(direction);
                  }};
    if constexpr (requires { s.inner_radius(); })
      f.inner = f.thickness = s.inner_radius();
    else
      f.thickness = s.half_extents(pose{}).minCoeff();
    if constexpr (requires { s.smallest_curvature_radius(); })
      f.sharpest = s.smallest_curvature_radius();
    else
      f.sharpest = f.thickness * (f.thickness / s.bounding_radius());
    if constexpr (may_have_flat_sides<Shape>()) f.flat = real(0.1) * s.bounding_radius();
    if constexpr (requires { s.level(vec3{}); })
      f.level = [](const void* shape, const vec3& point) -> surface_level {
        return static_cast<const Shape*>(shape)->level(point);
      };
    return f;
  }
}
template <class Shape>
using form_type = decltype(form_of(std::declval<const Shape&>()));

}  // namespace detail

}  // namespace talus
