#pragma once
// Sums of numbers that do not depend on the order of their terms.
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/core/math.hpp"

namespace talus::detail {

/// A finite number >= 0 as digits of a sum: digits[k] counts multiples of 2^(32 (first + k) -
/// 1074).
struct digits_of_number {
  static constexpr int bits = 32;       ///< of a digit, in words twice as large
  static constexpr int lowest = -1074;  ///< exponent of the smallest positive number

  std::size_t first;
  std::array<std::uint64_t, 3> digits;

  explicit digits_of_number(double x) {
    const auto word = std::bit_cast<std::uint64_t>(x);
    const auto exponent = static_cast<int>(word >> 52);
    std::uint64_t mantissa = word & ((std::uint64_t{1} << 52) - 1);
    if (exponent > 0) mantissa |= std::uint64_t{1} << 52;
    *this = digits_of_number(mantissa, exponent > 0 ? exponent - 1 : 0);
  }
  /// `mantissa` times 2^(at - 1074).
  digits_of_number(std::uint64_t mantissa, int at) {
    first = static_cast<std::size_t>(at / bits);
    const int shift = at % bits;
    const std::uint64_t low = mantissa << shift, high = shift == 0 ? 0 : mantissa >> (64 - shift);
    digits = {low & ((std::uint64_t{1} << bits) - 1), low >> bits, high};
  }
};

/// The exact sum of finite numbers >= 0 of any size (a long accumulator: Kulisch 1986). It is the
/// same to the bit for any grouping of the terms. Takes up to 2^31 terms. A term that is not finite
/// makes the sum NaN.
class exact_sum {
  static constexpr int bits = digits_of_number::bits, lowest = digits_of_number::lowest;

 public:
  static constexpr std::size_t digits = 67;

  exact_sum& operator+=(double x) {
    if (!(x >= 0 && std::isfinite(x))) {
      broken_ = 1;
      return *this;
    }
    if (x != 0) add(digits_of_number(x), false);
    return *this;
  }
  /// Adds a number given by its digits; a negative one is not allowed.
  void add(const digits_of_number& x, bool negative) {
    if (negative) broken_ = 1;
    for (std::size_t k = 0; k < x.digits.size(); ++k) digits_[x.first + k] += x.digits[k];
  }
  exact_sum& operator+=(const exact_sum& x) {
    exact_sum other = x;
    other.carry(), carry();
    for (std::size_t k = 0; k < digits; ++k) digits_[k] += other.digits_[k];
    broken_ |= other.broken_;
    return *this;
  }
  /// Adds `x` times a number > 0, exactly: what is below the smallest number is dropped.
  void add_product(exact_sum x, double factor) {
    int exponent = 0;
    const double mantissa = std::ldexp(std::frexp(factor, &exponent), 53);
    const auto all = static_cast<std::uint64_t>(mantissa);
    constexpr int half = 27;
    const std::uint64_t low = all & ((std::uint64_t{1} << half) - 1), high = all >> half;
    x.carry(), carry();
    broken_ |= x.broken_;
    for (std::size_t k = 0; k < digits; ++k) {
      if (x.digits_[k] == 0) continue;
      const auto add_at = [&](std::uint64_t product, int at) {
        if (at < 0) product = at > -64 ? product >> -at : 0, at = 0;
        const digits_of_number of(product, at);
        if (of.first + of.digits.size() > digits)
          broken_ = 1;
        else
          add(of, false);
      };
      const int at = static_cast<int>(k) * bits + exponent - 53;
      add_at(x.digits_[k] * low, at), add_at(x.digits_[k] * high, at + half);
    }
  }
  /// Takes from both sums what they have in common: one of them is 0 afterwards.
  static void cancel(exact_sum& a, exact_sum& b) {
    a.carry(), b.carry();
    std::size_t k = digits;
    while (k > 0 && a.digits_[k - 1] == b.digits_[k - 1]) --k;
    const bool less = k > 0 && a.digits_[k - 1] < b.digits_[k - 1];
    exact_sum &larger = less ? b : a, &smaller = less ? a : b;
    std::uint64_t borrowed = 0;
    for (std::size_t n = 0; n < digits; ++n) {
      const std::uint64_t taken = smaller.digits_[n] + borrowed;
      borrowed = larger.digits_[n] < taken ? 1 : 0;
      larger.digits_[n] += (borrowed << bits) - taken;
      smaller.digits_[n] = 0;
    }
  }
  /// Writes the sum as numbers that may be added up over ranks, up to 2^20 of them.
  void write(std::span<double, digits + 1> out) {
    carry();
    for (std::size_t k = 0; k < digits; ++k) out[k] = static_cast<double>(digits_[k]);
    out[digits] = static_cast<double>(broken_);
  }
  void read(std::span<const double, digits + 1> in) {
    for (std::size_t k = 0; k < digits; ++k) digits_[k] = static_cast<std::uint64_t>(in[k]);
    broken_ = in[digits] != 0;
  }
  /// The nearest number, or one of the two nearest.
  [[nodiscard]] double value() const {
    if (broken_) return std::nan("");
    exact_sum sum = *this;
    sum.carry();
    double all = 0;
    for (std::size_t k = digits; k-- > 0;)  // from the highest: small digits have no effect
      all += std::ldexp(static_cast<double>(sum.digits_[k]), static_cast<int>(k) * bits + lowest);
    return all;
  }
  operator double() const { return value(); }

 private:
  static constexpr std::uint64_t mask = (std::uint64_t{1} << bits) - 1;

  void carry() {
    for (std::size_t k = 0; k + 1 < digits; ++k) {
      digits_[k + 1] += digits_[k] >> bits;
      digits_[k] &= mask;
    }
  }

  std::array<std::uint64_t, digits> digits_{};
  std::uint64_t broken_ = 0;
};

/// An exact sum of finite numbers of either sign.
struct signed_sum {
  exact_sum plus, minus;

  signed_sum& operator+=(double x) {
    if (x < 0)
      minus += -x;
    else
      plus += x;
    return *this;
  }
  signed_sum& operator-=(double x) { return *this += -x; }
  void add(const digits_of_number& x, bool negative) { (negative ? minus : plus).add(x, false); }
  signed_sum& operator+=(const signed_sum& x) {
    plus += x.plus, minus += x.minus;
    return *this;
  }
  signed_sum& operator-=(const signed_sum& x) {
    plus += x.minus, minus += x.plus;
    return *this;
  }
  /// The sum times a number >= 0, exactly.
  [[nodiscard]] signed_sum times(double factor) const {
    signed_sum rest = *this, product;
    if (factor == 0) return product;
    exact_sum::cancel(rest.plus, rest.minus);
    product.plus.add_product(rest.plus, factor), product.minus.add_product(rest.minus, factor);
    return product;
  }
  /// The nearest number, or one of the two nearest.
  [[nodiscard]] double value() const {
    signed_sum rest = *this;
    exact_sum::cancel(rest.plus, rest.minus);
    return rest.plus.value() - rest.minus.value();
  }
};

/// An exact sum of vectors: each component is a signed_sum.
struct vector_sum {
  std::array<signed_sum, 3> parts;

  vector_sum& operator+=(const vec3& v) {
    for (int k = 0; k < 3; ++k) parts[static_cast<std::size_t>(k)] += v[k];
    return *this;
  }
  vector_sum& operator-=(const vec3& v) { return *this += vec3(-v); }
  [[nodiscard]] vec3 value() const {
    return {parts[0].value(), parts[1].value(), parts[2].value()};
  }
};

}  // namespace talus::detail
