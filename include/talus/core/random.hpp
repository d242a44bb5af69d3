#pragma once
// Random numbers that depend on their purpose, not on the rank or the time of the draw.
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "talus/core/error.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"

namespace talus {

namespace detail {

/// Philox4x32-10: four random words from a counter and a key (Salmon, Moraes, Dror, Shaw,
/// "Parallel random numbers: as easy as 1, 2, 3", 2011).
constexpr std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                              std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xd2511f53} * counter[0];
    const std::uint64_t p1 = std::uint64_t{0xcd9e8d57} * counter[2];
    counter = {
        static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(p1),
        static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(p0)};
    key = {key[0] + 0x9e3779b9, key[1] + 0xbb67ae85};
  }
  return counter;
}

}  // namespace detail

/// A sequence of random numbers identified by a seed, a number (of a site, a body, ...) and a
/// purpose. Different streams never share a counter; a stream holds 2^33 draws. The numbers are the
/// same on every rank and every platform: they do not depend on the library of the compiler, on
/// functions that platforms round differently, or on fused products and sums.
class random_stream {
 public:
  constexpr explicit random_stream(std::uint64_t seed, std::uint64_t number = 0,
                                   std::uint32_t purpose = 0)
      : key_{low(seed), high(seed)}, counter_{0, purpose, low(number), high(number)} {}
  constexpr random_stream(std::uint64_t seed, system_id id, std::uint32_t purpose = 0)
      : random_stream(seed, value_of(id), purpose) {}

  /// 64 random bits.
  constexpr std::uint64_t bits() {
    if (next_ == 4) {
      words_ = detail::philox(counter_, key_);
      ++counter_[0];
      next_ = 0;
    }
    const std::uint64_t word = words_[next_] | std::uint64_t{words_[next_ + 1]} << 32;
    next_ += 2;
    return word;
  }

  /// In [0, 1), a multiple of 2^-53.
  constexpr real uniform() { return static_cast<real>(bits() >> 11) * 0x1p-53; }
  /// Between a and b; invalid_argument unless both are finite and a <= b.
  real uniform(real a, real b) {
    if (!(a <= b) || !std::isfinite(b - a))
      detail::fail<std::invalid_argument>(
          "random numbers between {} and {}: give two finite bounds, the lower one first", a, b);
    return std::fma(b - a, uniform(), a);
  }
  /// In the axis-aligned box between two corners.
  vec3 uniform(const vec3& lower, const vec3& upper) {
    const real x = uniform(lower[0], upper[0]);
    const real y = uniform(lower[1], upper[1]);
    return {x, y, uniform(lower[2], upper[2])};
  }

  /// One of 0, 1, ..., n - 1, all equally likely (Lemire 2019); invalid_argument for n = 0.
  std::uint64_t integer(std::uint64_t n) {
    if (n == 0)
      detail::fail<std::invalid_argument>("a random integer below 0 does not exist: give n >= 1");
    for (;;) {
      __extension__ using wide = unsigned __int128;
      const wide product = static_cast<wide>(bits()) * n;
      if (static_cast<std::uint64_t>(product) >= (0 - n) % n)
        return static_cast<std::uint64_t>(product >> 64);
    }
  }

  /// A uniformly distributed direction (Marsaglia 1972).
  vec3 unit_vector() {
    const auto [x, y, s] = in_disk();
    const real scale = 2 * std::sqrt(1 - s);
    return {x * scale, y * scale, 1 - 2 * s};
  }
  /// A uniformly distributed point in the ball of `radius` about the origin.
  vec3 in_ball(real radius = 1) {
    for (;;) {
      const real x = symmetric(), y = symmetric(), z = symmetric();
      if (std::fma(x, x, std::fma(y, y, z * z)) <= 1) return {radius * x, radius * y, radius * z};
    }
  }
  /// A uniformly distributed rotation (Marsaglia 1972).
  quat rotation() {
    const auto [a, b, s] = in_disk();
    auto [c, d, t] = in_disk();
    while (t == 0) std::tie(c, d, t) = in_disk();
    const real scale = std::sqrt((1 - s) / t);
    return {a, b, c * scale, d * scale};
  }

 private:
  static constexpr std::uint32_t low(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
  static constexpr std::uint32_t high(std::uint64_t x) { return low(x >> 32); }

  real symmetric() { return 2 * uniform() - 1; }  // the product is exact: fused or not, equal bits
  /// x, y and x² + y² <= 1.
  std::tuple<real, real, real> in_disk() {
    for (;;) {
      const real x = symmetric(), y = symmetric(), s = std::fma(x, x, y * y);
      if (s <= 1) return {x, y, s};
    }
  }

  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> words_{};
  unsigned next_ = 4;
};

}  // namespace talus
