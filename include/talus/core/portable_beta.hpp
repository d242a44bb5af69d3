#pragma once
// Euler's beta function with the same bits on every platform.
#include "talus/core/portable_powers.hpp"

namespace talus {

namespace detail {

/// Stirling's series for the logarithm of the gamma function of z >= 20, without the terms that
/// are constant or linear in z. (The first one left out is below 1e-19.)
[[nodiscard]] inline double_double stirling(double z) {
  const double r = 1 / z, square = r * r;
  const double tail =
      r *
      (1.0 / 12 -
       square *
           (1.0 / 360 -
            square * (1.0 / 1260 -
                      square * (1.0 / 1680 - square * (1.0 / 1188 - square * (691.0 / 360360))))));
  return double_double{z - 0.5, 0} * precise_log(z) + double_double{tail, 0};
}

}  // namespace detail

namespace portable {

/// The beta function of two numbers between 0.01 and 100, to 2e-14 of its value.
[[nodiscard]] inline double beta(double x, double y) {
  // B(x, y) = B(x + n, y + n) (x + y)_2n / ((x)_n (y)_n) with rising factorials.
  constexpr int shift = 20;
  double factor = 1;
  for (int k = 0; k < shift; ++k) {
    const double s = x + y + 2 * k;
    factor *= s * (s + 1) / ((x + k) * (y + k));
  }
  const double u = x + shift, v = y + shift, w = u + v;
  const detail::double_double minus{-1, 0};
  // Of the terms z of log gamma(z), those of the three gamma functions cancel.
  const detail::double_double sum =
      detail::stirling(u) + detail::stirling(v) + minus * detail::stirling(w);
  // What u, v and w lack in rounding errors.
  const double lost = (x - (u - shift)) * log(u) + (y - (v - shift)) * log(v) -
                      ((x - (w - 2 * shift)) + y) * log(w);
  constexpr double root_of_2_pi = 2.5066282746310005024;
  const double rough = exp(sum.high);
  return factor * root_of_2_pi * (rough + rough * (sum.low + lost));
}

}  // namespace portable

}  // namespace talus
