#pragma once
// Planes through a convex shape, by its support function h(u), the largest u . x of its points x.
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"

namespace talus::detail {

/// The least value of a convex function of all numbers c, given as f(w, t) for c = t / w: by the
/// golden section over c = t / (1 - t^2).
template <class F>
[[nodiscard]] real least_over_slopes(F&& f) {
  constexpr real golden = 0.6180339887498949;
  const auto value = [&](real t) { return f(1 - t * t, t); };
  real from = -1, to = 1;
  real a = to - golden * (to - from), b = from + golden * (to - from);
  real at_a = value(a), at_b = value(b);
  for (int k = 0; k < 44; ++k) {
    if (at_a < at_b) {
      to = b, b = a, at_b = at_a;
      a = to - golden * (to - from), at_a = value(a);
    } else {
      from = a, a = b, at_a = at_b;
      b = from + golden * (to - from), at_b = value(b);
    }
  }
  return std::min(at_a, at_b);
}

/// The values of y that a convex shape has in the plane z, or a little more: the upper end is the
/// least of h(0, 1, c) - c z over all c.
template <class Support>
[[nodiscard]] chord range_in_plane(real z, Support&& h) {
  const auto top = [&](real sign) {
    return least_over_slopes([&](real w, real t) { return (h(vec3(0, sign * w, t)) - t * z) / w; });
  };
  return {-top(-1), top(1)};
}

}  // namespace talus::detail
