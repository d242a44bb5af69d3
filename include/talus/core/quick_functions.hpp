#pragma once
// A root, a logarithm and powers with the same bits on every platform, for what needs them at each
// contact: wrong by a few units in the last place, where portable_powers.hpp is wrong by one.
#include <bit>
#include <cstdint>

#include "talus/core/portable_powers.hpp"

namespace talus::detail {

/// The cube root of a normal positive number; 0 of 0.
[[nodiscard]] inline double quick_cbrt(double x) {
  if (!(x > 0)) return 0;
  // A third of the exponent, wrong by at most 4 %, then three steps of Halley.
  double r = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + 0x2a9f7893782da1ceULL);
  for (int k = 0; k < 3; ++k) {
    const double cube = r * r * r;
    r *= (cube + 2 * x) / (2 * cube + x);
  }
  return r;
}

/// The natural logarithm of a normal positive number: of m in [sqrt(1/2), sqrt(2)) with x = m 2^k,
/// log m = 2 artanh((m - 1) / (m + 1)) by its series.
[[nodiscard]] inline double quick_log(double x) {
  constexpr std::uint64_t half_root = 0x3fe6a09e667f3bcdULL;  // of sqrt(1/2)
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const auto shifted = static_cast<std::int64_t>(bits - half_root) >> 52;
  const double m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(shifted) << 52));
  const double t = (m - 1) / (m + 1), u = t * t;
  double sum = 1.0 / 21;
  for (int n = 19; n >= 1; n -= 2) sum = sum * u + 1.0 / n;
  return 2 * t * sum + static_cast<double>(shifted) * 0.6931471805599453;
}

/// A power of a number that is not negative; 0 below 1e-300. The error relative to the result is
/// 3e-16 times 1 + |log(result)|.
[[nodiscard]] inline double quick_pow(double base, double exponent) {
  if (exponent == 1) return base;
  if (!(base > 1e-300)) return exponent > 0 ? 0 : 1;
  return portable::exp(exponent * quick_log(base));
}

}  // namespace talus::detail
