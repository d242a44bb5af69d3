#pragma once
// Roots, powers, exponentials and logarithms with the same bits on every platform.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace talus {

namespace detail {

/// A number as the sum of two doubles, `low` below the last bit of `high`: some 100 bits (Dekker,
/// "A floating-point technique for extending the available precision", 1971).
struct double_double {
  double high = 0, low = 0;

  /// The exact sum of two numbers, the first of which is at least as large as the second in
  /// magnitude.
  static double_double sum(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
  }
  friend double_double operator+(const double_double& a, const double_double& b) {
    const double s = a.high + b.high, t = s - a.high;
    return sum(s, ((a.high - (s - t)) + (b.high - t)) + (a.low + b.low));
  }
  friend double_double operator*(const double_double& a, const double_double& b) {
    const double p = a.high * b.high;
    return sum(p, std::fma(a.high, b.high, -p) + (a.high * b.low + a.low * b.high));
  }
  friend double_double operator/(const double_double& a, const double_double& b) {
    const double q = a.high / b.high;
    const double rest = std::fma(-q, b.high, a.high) + (a.low - q * b.low);
    return sum(q, rest / b.high);
  }
};

/// The natural logarithm of a finite positive number: of m in [sqrt(1/2), sqrt(2)) with
/// x = m 2^k, log m = 2 artanh((m - 1) / (m + 1)).
[[nodiscard]] inline double_double precise_log(double x) {
  int k = 0;
  double m = std::frexp(x, &k);
  if (m < 0.70710678118654752440) m *= 2, --k;
  const double_double s =
      double_double{m - 1, 0} / double_double::sum(m >= 1 ? m : 1, m >= 1 ? 1 : m);
  const double_double square = s * s;
  double_double series{0, 0};
  for (int n = 41; n > 1; n -= 2)  // of at most 0.0295 each: below 2^-100 where it ends
    series = square * (series + double_double{1, 0} / double_double{static_cast<double>(n), 0});
  const double_double of_m =
      s * (double_double{2, 0} + double_double{2 * series.high, 2 * series.low});
  const auto times = static_cast<double>(k);
  return double_double{times, 0} * double_double{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56} +
         of_m;
}

}  // namespace detail

namespace portable {

/// Returns the value of std::hypot of two numbers.
[[nodiscard]] inline double hypot(double x, double y) {
  const double a = std::abs(x), b = std::abs(y), large = std::max(a, b);
  if (large > 0x1p-450 && large < 0x1p500) return std::sqrt(a * a + b * b);
  if (std::isinf(a) || std::isinf(b)) return std::numeric_limits<double>::infinity();
  if (!(large > 0)) return a + b;
  const int k = std::ilogb(large);
  const double u = std::ldexp(a, -k), v = std::ldexp(b, -k);
  return std::ldexp(std::sqrt(u * u + v * v), k);
}

/// Returns the value of std::hypot of three numbers; wrong by less than two units in the last
/// place.
[[nodiscard]] inline double hypot(double x, double y, double z) { return hypot(hypot(x, y), z); }

/// Returns the value of std::cbrt: three Newton steps after a guess, and one with the residual to
/// twice the bits.
[[nodiscard]] inline double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  int k = 0;
  double m = std::frexp(std::abs(x), &k);
  while (k % 3 != 0) m /= 2, ++k;                 // now in [1/8, 1)
  double r = 0.3815 + m * (1.0685 - m * 0.4663);  // within 2 per cent
  for (int n = 0; n < 3; ++n) r -= (r * r * r - m) / (3 * r * r);
  const double square = r * r, below = std::fma(r, r, -square), cube = square * r;
  const double residual = (cube - m) + (std::fma(square, r, -cube) + below * r);
  r -= residual / (3 * square);
  return std::copysign(std::ldexp(r, k / 3), x);
}

/// Returns the value of std::exp (the method of fdlibm, Sun Microsystems 1993).
[[nodiscard]] inline double exp(double x) {
  if (!(std::abs(x) < 1000))  // not a number, or the result overflows or underflows
    return x > 0 ? std::numeric_limits<double>::infinity() : x < 0 ? 0 : x;
  const double k = std::floor(x * 1.44269504088896338700e+00 + 0.5);
  const double high = x - k * 6.93147180369123816490e-01, low = k * 1.90821492927058770002e-10;
  const double r = high - low, t = r * r;
  const double c =
      r - t * (1.66666666666666019037e-01 +
               t * (-2.77777777770155933842e-03 +
                    t * (6.61375632143793436117e-05 +
                         t * (-1.65339022054652515390e-06 + t * 4.13813679705723846039e-08))));
  const double result = 1 - ((low - (r * c) / (2 - c)) - high);
  return std::ldexp(result, static_cast<int>(k));
}

/// Returns the value of std::log.
[[nodiscard]] inline double log(double x) {
  if (!(x > 0))
    return x == 0 ? -std::numeric_limits<double>::infinity()
                  : std::numeric_limits<double>::quiet_NaN();
  return std::isfinite(x) ? detail::precise_log(x).high : x;
}
/// Returns the value of std::acosh, with an absolute error of 1e-15 near 1.
[[nodiscard]] inline double acosh(double x) { return log(x + std::sqrt((x - 1) * (x + 1))); }

/// Returns the value of std::pow for a finite base that is not negative and a finite exponent;
/// wrong by less than two units in the last place.
[[nodiscard]] inline double pow(double base, double exponent) {
  if (exponent == 0 || base == 1) return 1;
  if (base == 0) return exponent > 0 ? 0 : std::numeric_limits<double>::infinity();
  const detail::double_double of_base = detail::precise_log(base);
  if (!(std::abs(of_base.high * exponent) < 800)) return exp(of_base.high * exponent);
  const detail::double_double product = of_base * detail::double_double{exponent, 0};
  const double rough = exp(product.high);
  return rough + rough * product.low;
}

}  // namespace portable

}  // namespace talus
