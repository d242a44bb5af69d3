#pragma once
// Sine, cosine and their inverses with the same bits on every platform.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace talus {

namespace detail {

/// An angle less the nearest multiple of pi/2: -pi/4 <= high + low <= pi/4, `low` below the last
/// bit of `high`.
struct reduced_angle {
  double high = 0, low = 0;
  unsigned quadrant = 0;  ///< the multiple, modulo 4
};

/// 2/pi, the bits behind the point, after 64 zeros.
inline constexpr std::array<std::uint64_t, 21> two_over_pi{0,
                                                           0xa2f9836e4e441529,
                                                           0xfc2757d1f534ddc0,
                                                           0xdb6295993c439041,
                                                           0xfe5163abdebbc561,
                                                           0xb7246e3a424dd2e0,
                                                           0x06492eea09d1921c,
                                                           0xfe1deb1cb129a73e,
                                                           0xe88235f52ebb4484,
                                                           0xe99c7026b45f7e41,
                                                           0x3991d639835339f4,
                                                           0x9c845f8bbdf9283b,
                                                           0x1ff897ffde05980f,
                                                           0xef2f118b5a0a6d1f,
                                                           0x6d367ecf27cb09b7,
                                                           0x4f463f669e5fea2d,
                                                           0x7527bac7ebe5f17b,
                                                           0x3d0739f78a5292ea,
                                                           0x6bfb5fb11f8d5d08,
                                                           0x56033046fc7b6bab,
                                                           0xf0cfbc209af4361d};

/// Reduces a finite angle of at least pi/4 in magnitude in integer arithmetic (Payne, Hanek,
/// "Radian reduction for trigonometric functions", 1983). It multiplies only those 192 bits of 2/pi
/// that determine the product modulo 4 and 128 bits behind its point.
[[nodiscard, gnu::noinline]] inline reduced_angle reduce_far_angle(double x) {
  __extension__ using whole = unsigned __int128;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const int exponent = static_cast<int>(bits >> 52 & 0x7ff) - 1075;  // x = mantissa 2^exponent
  const std::uint64_t mantissa = (bits & 0xfffffffffffff) | 0x10000000000000;

  const auto from = static_cast<unsigned>(exponent + 62);  // the first bit of weight 2 with x
  const unsigned word = from / 64, shift = from % 64;
  const auto at = [&](unsigned k) {
    const std::uint64_t high = two_over_pi[word + k];
    return shift == 0 ? high : high << shift | two_over_pi[word + k + 1] >> (64 - shift);
  };
  const whole low = whole{at(2)} * mantissa, middle = whole{at(1)} * mantissa + (low >> 64);
  const std::uint64_t top = at(0) * mantissa + static_cast<std::uint64_t>(middle >> 64);
  whole part = (whole{top} << 64 | static_cast<std::uint64_t>(middle)) << 2 |
               static_cast<std::uint64_t>(low) >> 62;  // of 2^128
  auto quadrant = static_cast<unsigned>(top >> 62);
  const bool beyond = part >> 127 != 0;
  if (beyond) part = -part, ++quadrant;

  const auto leading = static_cast<std::uint64_t>(part >> 64);
  const int zeros = leading != 0 ? std::countl_zero(leading) : 64;  // there are at most 62
  part <<= zeros;
  const double first = std::ldexp(static_cast<double>(part >> 75), -53 - zeros);
  const double second = std::ldexp(
      static_cast<double>(static_cast<std::uint64_t>(part >> 22) & 0x1fffffffffffff), -106 - zeros);
  constexpr double half_pi = 0x1.921fb54442d18p+0, rest = 0x1.1a62633145c07p-54;
  const double product = first * half_pi;
  const double error = std::fma(first, half_pi, -product) + (first * rest + second * half_pi);
  reduced_angle r;
  r.high = product + error;
  r.low = error - (r.high - product);
  r.quadrant = quadrant;
  if (beyond) r.high = -r.high, r.low = -r.low;
  if (x < 0) r.high = -r.high, r.low = -r.low, r.quadrant = -r.quadrant;
  r.quadrant &= 3;
  return r;
}

[[nodiscard]] inline reduced_angle reduce_angle(double x) {
  if (!(std::abs(x) > 0.78539816339744830962)) return {x, 0, 0};
  if (!std::isfinite(x)) return {x - x, 0, 0};
  return reduce_far_angle(x);
}

/// The polynomials of fdlibm (Sun Microsystems 1993): below one unit in the last place.
[[nodiscard]] inline double sine_of(const reduced_angle& r) {
  const double x = r.high, z = x * x, w = z * z;
  const double p = 8.33333333332248946124e-03 +
                   z * (-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06) +
                   z * w * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10);
  const double v = z * x;
  return x - ((z * (0.5 * r.low - v * p) - r.low) - v * -1.66666666666666324348e-01);
}
[[nodiscard]] inline double cosine_of(const reduced_angle& r) {
  const double x = r.high, z = x * x, w = z * z;
  const double p = z * (4.16666666666666019037e-02 +
                        z * (-1.38888888888741095749e-03 + z * 2.48015872894767294178e-05)) +
                   w * w *
                       (-2.75573143513906633035e-07 +
                        z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11));
  const double half = 0.5 * z, rough = 1 - half;
  return rough + (((1 - rough) - half) + (z * p - x * r.low));
}

/// The arc tangent of x >= 0 (fdlibm).
[[nodiscard]] inline double arc_tangent_of(double x) {
  struct place {
    double high, low;
  };
  constexpr place places[] = {{4.63647609000806093515e-01, 2.26987774529616870924e-17},
                              {7.85398163397448278999e-01, 3.06161699786838301793e-17},
                              {9.82793723247329054082e-01, 1.39033110312309984516e-17},
                              {1.57079632679489655800e+00, 6.12323399573676603587e-17}};
  int at = -1;
  if (x >= 2.4375)
    at = 3, x = -1 / x;
  else if (x >= 1.1875)
    at = 2, x = (x - 1.5) / (1 + 1.5 * x);
  else if (x >= 0.6875)
    at = 1, x = (x - 1) / (x + 1);
  else if (x >= 0.4375)
    at = 0, x = (2 * x - 1) / (2 + x);
  const double z = x * x, w = z * z;
  const double odd =
      z * (3.33333333333329318027e-01 +
           w * (1.42857142725034663711e-01 +
                w * (9.09088713343650656196e-02 +
                     w * (6.66107313738753120669e-02 +
                          w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const double even =
      w * (-1.99999999998764832476e-01 +
           w * (-1.11111104054623557880e-01 +
                w * (-7.69187620504482999495e-02 +
                     w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  if (at < 0) return x - x * (odd + even);
  return places[at].high - ((x * (odd + even) - places[at].low) - x);
}

}  // namespace detail

/// Functions of the C library that platforms round differently, with the same bits on all of them:
/// made of sums, products, quotients, square roots and fused multiply-adds, which IEEE 754 defines.
/// Errors are below one unit in the last place unless a function states another bound.
namespace portable {

/// A sine and a cosine.
struct sine_and_cosine {
  double sine, cosine;
};
/// Both of one angle in radians.
[[nodiscard]] inline sine_and_cosine sincos(double angle) {
  const detail::reduced_angle r = detail::reduce_angle(angle);
  const double s = detail::sine_of(r), c = detail::cosine_of(r);
  switch (r.quadrant) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}
/// Returns the value of std::sin.
[[nodiscard]] inline double sin(double angle) { return sincos(angle).sine; }
/// Returns the value of std::cos.
[[nodiscard]] inline double cos(double angle) { return sincos(angle).cosine; }
/// Returns the value of std::tan, wrong by less than three units in the last place.
[[nodiscard]] inline double tan(double angle) {
  const sine_and_cosine both = sincos(angle);
  return both.sine / both.cosine;
}

/// Returns the value of std::atan2, for two finite numbers; wrong by less than two units in the
/// last place.
[[nodiscard]] inline double atan2(double y, double x) {
  constexpr double whole = 3.14159265358979311600e+00, rest = 1.22464679914735317720e-16;
  const double up = std::abs(y), along = std::abs(x);
  double angle;
  if (along == 0)
    angle = up == 0 ? 0 : whole / 2;
  else
    angle = up / along > 0x1p60 ? whole / 2 : detail::arc_tangent_of(up / along);
  if (std::signbit(x)) angle = whole - (angle - rest);
  return std::copysign(angle, y);
}
/// Returns the value of std::acos; wrong by less than two units in the last place.
[[nodiscard]] inline double acos(double x) { return atan2(std::sqrt((1 - x) * (1 + x)), x); }

}  // namespace portable

}  // namespace talus
