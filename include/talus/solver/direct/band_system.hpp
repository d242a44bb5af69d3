#pragma once
// Linear systems of 3 x 3 blocks that lie near the diagonal: contacts along a stack or an arch.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "talus/core/contact_vector.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Solved by LU with row exchanges inside the band, in O(n b²) for half a bandwidth of b.
class band_system {
 public:
  /// Floating-point operations of a solution, for a half bandwidth in blocks.
  [[nodiscard]] static real cost(std::size_t blocks, std::size_t half) {
    const real n = 3 * static_cast<real>(blocks), b = std::min(n, 3 * static_cast<real>(half) + 3);
    return 4 * n * b * b;
  }
  void reset(int blocks) {
    n_ = 3 * static_cast<std::size_t>(blocks);
    entries_.clear();
    half_ = 2;
  }
  void add(int row, int column, const mat3& value) {
    const auto off = static_cast<std::size_t>(std::abs(row - column));
    half_ = std::max(half_, 3 * off + 2);
    entries_.push_back({row, column, value});
  }
  /// False if a pivot vanishes.
  [[nodiscard]] bool factorize() {
    width_ = 3 * half_ + 1;  // row exchanges widen the upper part
    a_.assign(n_ * width_, 0);
    pivots_.resize(n_);
    for (const entry& e : entries_)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) at(index(e.row, i), index(e.column, j)) += e.value(i, j);
    for (std::size_t k = 0; k < n_; ++k) {
      const std::size_t below = std::min(n_, k + half_ + 1), end = std::min(n_, k + 2 * half_ + 1);
      std::size_t best = k;
      for (std::size_t i = k + 1; i < below; ++i)
        if (std::abs(at(i, k)) > std::abs(at(best, k))) best = i;
      const real pivot = at(best, k);
      if (!(std::abs(pivot) > 0)) return false;
      pivots_[k] = best;
      if (best != k) std::swap_ranges(&at(k, k), &at(k, k) + (end - k), &at(best, k));
      const real* from = &at(k, k);
      for (std::size_t i = k + 1; i < below; ++i) {
        real* to = &at(i, k);
        if (*to == 0) continue;
        *to /= pivot;
        for (std::size_t j = 1; j < end - k; ++j) to[j] -= *to * from[j];
      }
    }
    return true;
  }
  /// Solves with the last factors; false if the solution is not finite.
  [[nodiscard]] bool solve(const contact_vector& right, contact_vector& x) const {
    x = right;
    real* v = x.data();
    for (std::size_t k = 0; k < n_; ++k) {
      std::swap(v[k], v[pivots_[k]]);
      for (std::size_t i = k + 1, below = std::min(n_, k + half_ + 1); i < below; ++i)
        v[i] -= at(i, k) * v[k];
    }
    for (std::size_t k = n_; k-- > 0;) {
      for (std::size_t j = k + 1, end = std::min(n_, k + 2 * half_ + 1); j < end; ++j)
        v[k] -= at(k, j) * v[j];
      v[k] /= at(k, k);
    }
    return x.is_finite();
  }

 private:
  struct entry {
    int row, column;
    mat3 value;
  };
  static std::size_t index(int block, int k) { return static_cast<std::size_t>(3 * block + k); }

  real& at(std::size_t i, std::size_t j) { return a_[i * width_ + (j + half_ - i)]; }
  const real& at(std::size_t i, std::size_t j) const { return a_[i * width_ + (j + half_ - i)]; }

  std::size_t n_ = 0, half_ = 2, width_ = 7;
  plain_vector<entry> entries_;
  plain_vector<real> a_;  ///< rows of `width_`, the diagonal in column `half_`
  plain_vector<std::size_t> pivots_;
};

}  // namespace talus::detail
