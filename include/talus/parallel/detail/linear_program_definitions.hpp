#pragma once
// The definitions of linear_program.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/detail/linear_program.hpp"

namespace talus::detail {

TALUS_INLINE std::optional<lp_vector> maximize(int dimension, const plain_vector<lp_bound>& bounds,
                                               const lp_vector& c) {
  if (dimension == 1) {
    real low = -lp_far, high = lp_far;
    for (const lp_bound& bound : bounds) {
      const real a = bound.a[0], tolerance = lp_rounding * (1 + std::abs(bound.b));
      if (std::abs(a) < lp_rounding) {
        if (bound.b > tolerance) return std::nullopt;
      } else if (a > 0) {
        low = std::max(low, bound.b / a);
      } else {
        high = std::min(high, bound.b / a);
      }
    }
    if (low > high + lp_rounding * (1 + std::abs(low) + std::abs(high))) return std::nullopt;
    if (low > high) low = high = (low + high) / 2;
    const real x = c[0] > 0 ? high : c[0] < 0 ? low : std::clamp(real(0), low, high);
    return lp_vector{x};
  }

  const auto size = static_cast<std::size_t>(dimension);
  lp_vector x{};
  for (std::size_t k = 0; k < size; ++k) x[k] = c[k] > 0 ? lp_far : c[k] < 0 ? -lp_far : 0;
  plain_vector<lp_bound> reduced;
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const lp_vector& a = bounds[i].a;
    const real b = bounds[i].b;
    real value = 0, scale = 1 + std::abs(b);
    std::size_t pivot = 0;
    for (std::size_t k = 0; k < size; ++k) {
      value += a[k] * x[k];
      scale += std::abs(a[k] * x[k]);
      if (std::abs(a[k]) > std::abs(a[pivot])) pivot = k;
    }
    if (value >= b - lp_rounding * scale) continue;
    if (std::abs(a[pivot]) < lp_rounding) return std::nullopt;

    // The optimum lies on this bound: x_pivot follows from the others.
    const auto substitute = [&](const lp_vector& from, real constant) {
      lp_bound result{{}, constant - from[pivot] / a[pivot] * b};
      for (std::size_t k = 0, to = 0; k < size; ++k)
        if (k != pivot) result.a[to++] = from[k] - from[pivot] / a[pivot] * a[k];
      return result;
    };
    reduced.clear();
    for (std::size_t j = 0; j < i; ++j) reduced.push_back(substitute(bounds[j].a, bounds[j].b));
    lp_vector unit{};
    unit[pivot] = 1;
    reduced.push_back(substitute(unit, -lp_far));
    unit[pivot] = -1;
    reduced.push_back(substitute(unit, -lp_far));
    const auto on = maximize(dimension - 1, reduced, substitute(c, 0).a);
    if (!on) return std::nullopt;
    real rest = b;
    for (std::size_t k = 0, from = 0; k < size; ++k) {
      if (k == pivot) continue;
      x[k] = (*on)[from++];
      rest -= a[k] * x[k];
    }
    x[pivot] = rest / a[pivot];
  }
  return x;
}

}  // namespace talus::detail
