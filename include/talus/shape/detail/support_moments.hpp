#pragma once
// Volume and moments of a convex body of which the support function is all that is known, about to
// a hundredth: fifteen planes through it with fifteen lines each.
#include <cmath>

#include "talus/core/math.hpp"
#include "talus/shape/detail/part_overlaps.hpp"
#include "talus/shape/detail/support_chord.hpp"
#include "talus/shape/detail/support_lines.hpp"
#include "talus/shape/principal_axes.hpp"

namespace talus::detail {

/// For a function that returns a furthest point along a direction, of a body of the bounding radius
/// 1 with the origin inside.
template <class Support>
[[nodiscard]] mass_moments<real> moments_by_support(const Support& support) {
  const auto reach = [&](const vec3& d) { return d.dot(support(d)); };
  const support_chord along_x(support, vec3(1, 0, 0), 1);
  // Over t of (3 t - t^3) / 2, see shared_by_parts.
  const auto over = [](const chord& range, auto&& f) {
    const real middle = (range.from + range.to) / 2, half = (range.to - range.from) / 2;
    for (std::size_t k = 0; k < 8; ++k)
      for (const real side : {-1., 1.}) {
        if (k == 7 && side > 0) break;
        const real t = side * kronrod_rule::nodes[k];
        f(middle + half * (t * (3 - t * t) / 2),
          kronrod_rule::kronrod[k] * half * real(1.5) * (1 - t * t));
      }
  };
  mass_moments<real> sum;
  over({-reach(vec3(0, 0, -1)), reach(vec3(0, 0, 1))}, [&](real z, real of_plane) {
    over(range_in_plane(z, reach), [&](real y, real of_line) {
      const chord c = along_x.of(vec3(0, y, z));
      if (c.empty()) return;
      const real weight = of_plane * of_line, length = c.to - c.from;
      const real x = (c.from + c.to) / 2;
      const vec3 middle(x, y, z);
      sum.mass += weight * length;
      sum.first += weight * length * middle;
      sum.second += weight * length * outer(middle, middle);
      sum.second(0, 0) += weight * length * length * length / 12;
    });
  });
  return sum;
}

}  // namespace talus::detail
