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

[[gnu::cold]] inline void require_revolvable(const std::vector<std::array<real, 2>>& line,
                                             const revolution& how, bool full) {
  if (line.size() < 2)
    fail<std::invalid_argument>(
        "a surface of revolution needs a line of at least 2 points of radius and height, but got "
        "{}",
        line.size());
  for (std::size_t i = 0; i < line.size(); ++i)
    if (!(line[i][0] >= 0) || !std::isfinite(line[i][0]) || !std::isfinite(line[i][1]))
      fail<std::invalid_argument>(
          "point {} of a surface of revolution has the radius {} and the height {}: the radius "
          "must not be negative, and both must be finite",
          i, line[i][0], line[i][1]);
  if (!(how.to > how.from) || !(how.to - how.from <= 2 * pi * (1 + 1e-12)))
    fail<std::invalid_argument>(
        "a surface of revolution goes from an angle to a larger one, by at most 2 * pi, but was "
        "given .from = {} and .to = {}",
        how.from, how.to);
  if (how.sectors < (full ? 3 : 1) || how.sectors > 1 << 20)
    fail<std::invalid_argument>(
        "a surface of revolution has from {} to {} sectors, but was given {}", full ? 3 : 1,
        1 << 20, how.sectors);
  if (how.closed && !full)
    fail<std::invalid_argument>(
        "a surface of revolution is closed only where it goes around by 2 * pi, but it goes from "
        "{} to {}: leave out .closed, or .from and .to",
        how.from, how.to);
}

}  // namespace detail

/// The triangles of the surface that a line of points {radius, height} makes about the z axis. The
/// points lie on the surface; between them it is flat, so with n sectors its cross section is a
/// polygon of area n / 2 * sin(2 * pi / n) * radius^2. Normals, by the order of the corners, point
/// to the right of the line, seen with the axis on its left: away from the axis if the line goes
/// up, and out of a closed surface whose line begins below. A line whose last point equals its
/// first makes a ring, such as a tube with a thick wall, which needs no caps. Throws
/// invalid_argument for an invalid line or invalid angles.
[[nodiscard, gnu::cold]] inline std::vector<triangle_mesh::triangle> triangles_of_revolution(
    const std::vector<std::array<real, 2>>& line, const revolution& how = {}) {
  const int n = how.sectors;
  const bool full = std::abs(how.to - how.from - 2 * pi) <= 1e-12 * 2 * pi;
  detail::require_revolvable(line, how, full);
  const auto at = [&](std::size_t i, int k) {
    const real angle = how.from + (how.to - how.from) * (full ? k % n : k) / n;
    return vec3(line[i][0] * portable::cos(angle), line[i][0] * portable::sin(angle), line[i][1]);
  };
  std::vector<triangle_mesh::triangle> all;
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    for (int k = 0; k < n; ++k) {
      all.push_back({at(i, k), at(i, k + 1), at(i + 1, k + 1)});
      all.push_back({at(i, k), at(i + 1, k + 1), at(i + 1, k)});
    }
  if (how.closed && line.front() != line.back())
    for (int k = 0; k < n; ++k) {
      all.push_back({vec3(0, 0, line.front()[1]), at(0, k + 1), at(0, k)});
      all.push_back(
          {vec3(0, 0, line.back()[1]), at(line.size() - 1, k), at(line.size() - 1, k + 1)});
    }
  return all;
}

/// The mesh of triangles_of_revolution(): `placed(mesh)` gives the pose of a body at which the axis
/// is the z axis of the world.
[[nodiscard, gnu::cold]] inline triangle_mesh surface_of_revolution(
    const std::vector<std::array<real, 2>>& line, const revolution& how = {}) {
  return triangle_mesh(triangles_of_revolution(line, how));
}

/// A tube about the z axis from z = 0 to its height, open at both ends, or with `.closed` closed by
/// flat caps; normals point outwards. Throws invalid_argument for sizes that are not positive.
[[nodiscard, gnu::cold]] inline triangle_mesh tube_surface(const tube_form& form,
                                                           const revolution& how = {}) {
  detail::require_positive(form.radius, "the radius of a tube");
  detail::require_positive(form.height, "the height of a tube");
  return surface_of_revolution({{form.radius, 0}, {form.radius, form.height}}, how);
}

/// A cone, or a frustum, about the z axis from z = 0 to its height, open at ends with non-zero
/// radius, or with `.closed` closed by flat caps; normals point outwards. A funnel has the wider
/// end above. Throws invalid_argument for invalid sizes.
[[nodiscard, gnu::cold]] inline triangle_mesh cone_surface(const cone_form& form,
                                                           const revolution& how = {}) {
  detail::require_positive(form.height, "the height of a cone");
  detail::require_positive(std::max(form.lower, form.upper), "the larger radius of a cone");
  return surface_of_revolution({{form.lower, 0}, {form.upper, form.height}}, how);
}

}  // namespace talus
