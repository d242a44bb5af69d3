#pragma once
// Many numbers added to an exact sum at about the cost of additions.
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "talus/core/exact_sum.hpp"

namespace talus::detail {

/// Collects numbers for an exact sum: their mantissas add up separately for each exponent (the
/// large accumulator of Neal 2015). The sum has them after flush().
template <class Sum>
class exact_batch {
 public:
  explicit exact_batch(Sum& sum) : sum_(sum) {}
  exact_batch(const exact_batch&) = delete;
  exact_batch& operator=(const exact_batch&) = delete;
  ~exact_batch() { flush(); }

  [[gnu::always_inline]] inline exact_batch& operator+=(double x) {
    const auto word = std::bit_cast<std::uint64_t>(x);
    const std::size_t exponent = word >> 52 & 0x7ff;
    if (exponent == 0 || exponent == not_finite) [[unlikely]] {
      sum_ += x;
      return *this;
    }
    const auto mantissa = static_cast<std::int64_t>((word & (one - 1)) | one);
    parts_[exponent] += x < 0 ? -mantissa : mantissa;
    lowest_ = std::min(lowest_, exponent), highest_ = std::max(highest_, exponent);
    if (++count_ == most) [[unlikely]]
      flush();
    return *this;
  }
  [[gnu::always_inline]] inline exact_batch& operator-=(double x) { return *this += -x; }

  [[gnu::noinline]] void flush() {
    for (std::size_t e = lowest_; e <= highest_; ++e) {
      if (parts_[e] == 0) continue;
      const bool negative = parts_[e] < 0;
      const auto size = static_cast<std::uint64_t>(negative ? -parts_[e] : parts_[e]);
      sum_.add(digits_of_number(size, static_cast<int>(e) - 1), negative);
      parts_[e] = 0;
    }
    lowest_ = not_finite, highest_ = 0, count_ = 0;
  }

 private:
  static constexpr std::uint64_t one = std::uint64_t{1} << 52;
  static constexpr std::size_t not_finite = 0x7ff;
  static constexpr int most = 1000;  ///< mantissas of 53 bits that fit into 63 bits

  Sum& sum_;
  std::size_t lowest_ = not_finite, highest_ = 0;
  int count_ = 0;
  std::array<std::int64_t, not_finite> parts_{};
};
template <class Sum>
exact_batch(Sum&) -> exact_batch<Sum>;

}  // namespace talus::detail
