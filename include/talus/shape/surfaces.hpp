#pragma once
// Walls of revolution: tubes, cones and any surface of revolution, as triangles.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/shape/triangle_mesh.hpp"

namespace talus {

/// Parameters of the revolution of a profile about the z axis.
struct revolution {
  int sectors = 64;     ///< flat pieces from `from` to `to`; at least 3 for a full circle
  bool closed = false;  ///< ends of the profile that lie off the axis get a flat cap
  real from = 0;        ///< angle at which the surface begins, radians from the x axis
  real to = 2 * pi;     ///< angle at which it ends, above `from`, at most a full circle on
};
/// A straight tube about the z axis, with its lower end at z = 0.
struct tube_form {
  real radius = 1;  ///< of the circle on which its edges lie, length
  real height = 1;  ///< length
};
/// A cone, or a frustum of one, about the z axis, with its lower end at z = 0.
struct cone_form {
  real lower = 1;   ///< radius at z = 0, length; 0 for the apex
  real upper = 0;   ///< radius at z = height, length; 0 for the apex
  real height = 1;  ///< length
};

namespace detail {

[[gnu::cold]] void require_revolvable(const std::vector<std::array<real, 2>>& line,
                                      const revolution& how, bool full);

}  // namespace detail

/// The triangles of the surface that a line of points {radius, height} makes about the z axis. The
/// points lie on the surface; between them it is flat, so with n sectors its cross section is a
/// polygon of area n / 2 * sin(2 * pi / n) * radius^2. Normals, by the order of the corners, point
/// to the right of the line, seen with the axis on its left: away from the axis if the line goes
/// up, and out of a closed surface whose line begins below. A line whose last point equals its
/// first makes a ring, such as a tube with a thick wall, which needs no caps. Throws
/// invalid_argument for an invalid line or invalid angles.
[[nodiscard, gnu::cold]] std::vector<triangle_mesh::triangle> triangles_of_revolution(
    const std::vector<std::array<real, 2>>& line, const revolution& how = {});

/// The mesh of triangles_of_revolution(): `placed(mesh)` gives the pose of a body at which the axis
/// is the z axis of the world.
[[nodiscard, gnu::cold]] inline triangle_mesh surface_of_revolution(
    const std::vector<std::array<real, 2>>& line, const revolution& how = {}) {
  return triangle_mesh(triangles_of_revolution(line, how));
}

/// A tube about the z axis from z = 0 to its height, open at both ends, or with `.closed` closed by
/// flat caps; normals point outwards. Throws invalid_argument for sizes that are not positive.
[[nodiscard, gnu::cold]] triangle_mesh tube_surface(const tube_form& form,
                                                    const revolution& how = {});

/// A cone, or a frustum, about the z axis from z = 0 to its height, open at ends with non-zero
/// radius, or with `.closed` closed by flat caps; normals point outwards. A funnel has the wider
/// end above. Throws invalid_argument for invalid sizes.
[[nodiscard, gnu::cold]] triangle_mesh cone_surface(const cone_form& form,
                                                    const revolution& how = {});

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/shape/surfaces_definitions.hpp"
#endif
