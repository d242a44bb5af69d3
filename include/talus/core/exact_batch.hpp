#pragma once
// Many numbers added to an exact sum, eight at once.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "talus/core/exact_sum.hpp"
#include "talus/core/pack.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Collects numbers for an exact sum, and adds them up lane by lane: each is split at fixed places
/// into parts whose sums are exact (Rump 2009; Demmel, Nguyen 2015). What is below the lowest part
/// goes to the sum directly. The sum has all of them after flush().
template <class Sum>
class exact_batch {
 public:
  using number = pack<double, 8>;
  using bits_of_numbers = mask_of<number>;

  explicit exact_batch(Sum& sum) : sum_(sum) {}
  exact_batch(const exact_batch&) = delete;
  exact_batch& operator=(const exact_batch&) = delete;
  ~exact_batch() { flush(); }

  [[gnu::always_inline]] inline exact_batch& operator+=(double x) {
    waiting_[count_] = x;
    if (++count_ >= block) [[unlikely]]
      add_block();
    return *this;
  }
  [[gnu::always_inline]] inline exact_batch& operator-=(double x) { return *this += -x; }
  [[gnu::always_inline]] inline exact_batch& operator+=(const number& x) {
    std::memcpy(&waiting_[count_], &x, sizeof x);
    if ((count_ += lanes) >= block) [[unlikely]]
      add_block();
    return *this;
  }

  [[gnu::noinline]] void flush() {
    if (count_ >= lanes) {
      std::fill(waiting_.begin() + static_cast<std::ptrdiff_t>(count_), waiting_.end(), 0);
      count_ = block;
      add_block();
    }
    for (std::size_t k = 0; k < count_; ++k) sum_ += waiting_[k];
    count_ = 0;
    if (!used_) return;
    spill();
    if constexpr (std::is_same_v<Sum, exact_sum>) {
      exact_sum::cancel(all_.plus, all_.minus);
      sum_ += all_.plus;
    } else {
      sum_ += all_;
    }
    all_ = {}, used_ = false;
  }

 private:
  static constexpr std::size_t lanes = 8, packs = 8, block = packs * lanes, parts = 3;
  static constexpr int width = 41;           ///< binary digits of a part
  static constexpr std::uint32_t most = 64;  ///< blocks whose parts of 40 digits fit into 52

  [[nodiscard, gnu::always_inline]] inline number waiting(std::size_t n) const {
    number x;
    std::memcpy(&x, &waiting_[n * lanes], sizeof x);
    return x;
  }
  [[gnu::always_inline]] inline void wait(std::size_t n, const number& x) {
    std::memcpy(&waiting_[n * lanes], &x, sizeof x);
  }
  [[gnu::noinline]] void add_block() {
    used_ = true;
    number size{};
    for (std::size_t n = 0; n < packs; ++n) size += size_of_lanes(waiting(n));
    bool fits = true;
    for (std::size_t l = 0; l < lanes; ++l) fits &= size[l] < limit_;
    if (!fits) [[unlikely]]
      raise();
    bits_of_numbers left{};
    number sums[parts];
    std::memcpy(sums, part_.data(), sizeof sums);
    const number cuts[parts] = {every_lane<number>(cut_[0]), every_lane<number>(cut_[1]),
                                every_lane<number>(cut_[2])};
    for (std::size_t n = 0; n < packs; ++n) {
      number p = waiting(n);
      for (std::size_t k = 0; k < parts; ++k) {
        const number part = (p + cuts[k]) - cuts[k];
        sums[k] += part;
        p -= part;
      }
      left |= reinterpret_cast<bits_of_numbers>(p);
      wait(n, p);
    }
    std::memcpy(part_.data(), sums, sizeof sums);
    std::int64_t any = 0;
    for (std::size_t l = 0; l < lanes; ++l) any |= left[l];
    if (any << 1 != 0) [[unlikely]]  // besides signs
      for (std::size_t l = 0; l < block; ++l) all_ += waiting_[l];
    std::memcpy(waiting_.data(), &waiting_[block], lanes * sizeof(double));
    count_ -= block;
    if (++blocks_ == most) [[unlikely]]
      spill();
  }
  /// For a block with numbers that are larger than those before, or not finite.
  [[gnu::noinline]] void raise() {
    spill();
    double largest = 0;
    for (std::size_t l = 0; l < block; ++l) {
      const double size = std::abs(waiting_[l]);
      if (size <= too_large) {
        largest = std::max(largest, size);
      } else {
        sum_ += waiting_[l];
        waiting_[l] = 0;
      }
    }
    if (largest < limit_) return;
    // The first part begins a few digits above the number, so that this is rare.
    const int top = std::max(std::ilogb(largest) + 9, lowest);
    limit_ = std::ldexp(1, top);
    for (std::size_t k = 0; k < parts; ++k)
      cut_[k] = std::ldexp(1.5, top - (width - 1) - static_cast<int>(k) * width + 52);
  }
  [[gnu::noinline]] void spill() {
    if (blocks_ == 0) return;
    blocks_ = 0;
    for (number& part : part_) {
      double of_lanes = 0;  // exact
      for (std::size_t l = 0; l < lanes; ++l) of_lanes += part[l];
      all_ += of_lanes;
      part = number{};
    }
  }

  static constexpr double too_large = 0x1p900;
  static constexpr int lowest = -800;  ///< so that the units of all parts are normal numbers

  std::size_t count_ = 0;
  std::array<double, block + lanes> waiting_;
  std::uint32_t blocks_ = 0;
  bool used_ = false;  ///< blocks were added since the last flush
  double limit_ = 0;
  std::array<double, parts> cut_{};
  std::array<number, parts> part_{};
  signed_sum all_;  ///< of the blocks: parts of numbers > 0 may be below 0
  Sum& sum_;
};
template <class Sum>
exact_batch(Sum&) -> exact_batch<Sum>;

#pragma GCC diagnostic pop

}  // namespace talus::detail
