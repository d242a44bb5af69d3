#pragma once
// The definitions of surfaces.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/shape/surfaces.hpp"

namespace talus::detail {

TALUS_INLINE void require_revolvable(const std::vector<std::array<real, 2>>& line,
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

}  // namespace talus::detail

namespace talus {

TALUS_INLINE std::vector<triangle_mesh::triangle> triangles_of_revolution(
    const std::vector<std::array<real, 2>>& line, const revolution& how) {
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

TALUS_INLINE triangle_mesh tube_surface(const tube_form& form, const revolution& how) {
  detail::require_positive(form.radius, "the radius of a tube");
  detail::require_positive(form.height, "the height of a tube");
  return surface_of_revolution({{form.radius, 0}, {form.radius, form.height}}, how);
}

TALUS_INLINE triangle_mesh cone_surface(const cone_form& form, const revolution& how) {
  detail::require_positive(form.height, "the height of a cone");
  detail::require_positive(std::max(form.lower, form.upper), "the larger radius of a cone");
  return surface_of_revolution({{form.lower, 0}, {form.upper, form.height}}, how);
}

}  // namespace talus
