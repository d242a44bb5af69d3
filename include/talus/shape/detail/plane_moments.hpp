#pragma once
// Area and moments of a part of a plane whose boundary is made of arcs.
#include <array>
#include <cstddef>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Area and moments between circles in a plane.
template <class Real>
struct plane_moments {
  Real one = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  /// Adds the boundary integrals, by Green, of an arc about (a, b) from one angle to another.
  void add_arc(Real a, Real b, Real r, Real from, Real to) {
    const auto at = [](Real t) {
      const auto [s, c] = portable::sincos(t);
      const Real s2 = 2 * s * c, s4 = 2 * s2 * (c * c - s * s);
      return std::array<Real, 9>{s,
                                 t / 2 + s2 / 4,
                                 s - s * s * s / 3,
                                 3 * t / 8 + s2 / 4 + s4 / 32,
                                 s * s / 2,
                                 -c * c * c / 3,
                                 -c * c * c * c / 4,
                                 s * s * s / 3,
                                 t / 8 - s4 / 32};
    };
    std::array<Real, 9> f = at(to);
    const std::array<Real, 9> low = at(from);
    for (std::size_t k = 0; k < f.size(); ++k) f[k] = r * (f[k] - low[k]);
    // Integrals of c, c², c³, c⁴, cs, c²s, c³s, cs², c²s² over the arc, times r.
    const auto [c1, c2, c3, c4, cs, c2s, c3s, cs2, c2s2] = f;
    const Real r2 = r * r, r3 = r2 * r;
    one += a * c1 + r * c2;
    x += (a * a * c1 + 2 * a * r * c2 + r2 * c3) / 2;
    y += a * b * c1 + a * r * cs + b * r * c2 + r2 * c2s;
    xx += (a * a * a * c1 + 3 * a * a * r * c2 + 3 * a * r2 * c3 + r3 * c4) / 3;
    xy += (a * a * b * c1 + a * a * r * cs + 2 * a * b * r * c2 + 2 * a * r2 * c2s + b * r2 * c3 +
           r3 * c3s) /
          2;
    yy += a * b * b * c1 + 2 * a * b * r * cs + a * r2 * cs2 + b * b * r * c2 + 2 * b * r2 * c2s +
          r3 * c2s2;
  }
};

}  // namespace talus::detail
