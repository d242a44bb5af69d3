#pragma once
// Sums of numbers that do not depend on the order of their terms, a tenth the size of exact ones.
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "talus/core/exact_sum.hpp"

namespace talus::detail {

/// The sum of finite numbers, the same to the bit for any grouping of the terms (binned summation:
/// Demmel, Nguyen 2015). Keeps the highest digits of all terms, at least 97 bits from the first one
/// of the largest term: what is below has no effect. Takes up to 2^31 terms. A term that is not
/// finite makes the sum NaN.
class binned_sum {
 public:
  static constexpr std::size_t kept = 4;
  /// Numbers that add up, modulo 2^64, for sums with the same top().
  using digits_type = std::array<std::uint64_t, kept>;

  binned_sum& operator+=(double x) {
    if (x == 0) return *this;
    if (!std::isfinite(x)) {
      raise(broken);
      return *this;
    }
    const digits_of_number of(std::abs(x));
    std::size_t n = of.digits.size();
    while (of.digits[n - 1] == 0) --n;
    raise(of.first + n);
    for (; n > 0; --n) {
      const std::size_t place = top_ - of.first - n;
      if (place < kept) digits_[place] += x < 0 ? -of.digits[n - 1] : of.digits[n - 1];
    }
    return *this;
  }
  binned_sum& operator+=(binned_sum x) {
    raise(x.top_), x.raise(top_);
    for (std::size_t k = 0; k < kept; ++k) digits_[k] += x.digits_[k];
    return *this;
  }
  /// One more than the place of the highest digit of any term.
  [[nodiscard]] std::uint64_t top() const { return top_; }
  [[nodiscard]] digits_type& digits() { return digits_; }
  /// Drops the digits that are too low beside a higher one.
  void raise(std::uint64_t top) {
    if (top <= top_) return;
    const std::uint64_t by = top - top_;
    for (std::size_t k = kept; k-- > 0;) digits_[k] = k >= by ? digits_[k - by] : 0;
    top_ = top;
  }
  /// The nearest number, nearly.
  [[nodiscard]] double value() const {
    if (top_ == broken) return std::numeric_limits<double>::quiet_NaN();
    double all = 0;
    for (std::size_t k = kept; k-- > 0;)
      all = std::ldexp(all, -digits_of_number::bits) +
            static_cast<double>(static_cast<std::int64_t>(digits_[k]));
    return std::ldexp(
        all, (static_cast<int>(top_) - 1) * digits_of_number::bits + digits_of_number::lowest);
  }

 private:
  static constexpr std::uint64_t broken = 1000;  ///< above the places of all numbers

  std::uint64_t top_ = 0;
  digits_type digits_{};  ///< from the highest
};

}  // namespace talus::detail
