#pragma once
// Linear systems with a block of 6 x 6 for each body and each pair of bodies that touch.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/direct/elimination_order.hpp"

namespace talus::detail {

/// The unknowns of a body: velocity and angular velocity, or impulse and angular impulse.
using body_vector = std::array<real, 6>;

/// By rows.
struct alignas(16) body_block {
  std::array<real, 36> at{};

  real& operator()(int i, int j) { return at[static_cast<std::size_t>(6 * i + j)]; }
  real operator()(int i, int j) const { return at[static_cast<std::size_t>(6 * i + j)]; }

  /// Subtracts the product of a and b from it.
  void take(const body_block& a, const body_block& b) {
    using two = real __attribute__((vector_size(2 * sizeof(real)), may_alias));
    const two* const from = reinterpret_cast<const two*>(b.at.data());
    two* to = reinterpret_cast<two*>(at.data());
    for (int i = 0; i < 6; ++i, to += 3) {
      two x = to[0], y = to[1], z = to[2];
      for (int k = 0; k < 6; ++k) {
        const real f = a(i, k);
        x -= f * from[3 * k], y -= f * from[3 * k + 1], z -= f * from[3 * k + 2];
      }
      to[0] = x, to[1] = y, to[2] = z;
    }
  }
  /// Subtracts the product of it and x from y.
  void take_from(body_vector& y, const body_vector& x) const {
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        y[static_cast<std::size_t>(i)] -= (*this)(i, j) * x[static_cast<std::size_t>(j)];
  }
};

/// LU of one block, with row exchanges.
class body_pivot {
 public:
  [[nodiscard]] bool factorize(const body_block& block) {
    lu_ = block;
    for (int k = 0; k < 6; ++k) {
      int best = k;
      for (int i = k + 1; i < 6; ++i)
        if (std::abs(lu_(i, k)) > std::abs(lu_(best, k))) best = i;
      if (!(std::abs(lu_(best, k)) > 0)) return false;
      row_[static_cast<std::size_t>(k)] = best;
      if (best != k)
        for (int j = 0; j < 6; ++j) std::swap(lu_(k, j), lu_(best, j));
      const real inverse = 1 / lu_(k, k);
      for (int i = k + 1; i < 6; ++i) {
        const real f = lu_(i, k) *= inverse;
        for (int j = k + 1; j < 6; ++j) lu_(i, j) -= f * lu_(k, j);
      }
      lu_(k, k) = inverse;
    }
    return true;
  }
  /// Replaces `Width` columns, lying in rows, by the solutions.
  template <int Width>
  void solve(real* x) const {
    for (int k = 0; k < 6; ++k)
      if (const int other = row_[static_cast<std::size_t>(k)]; other != k)
        for (int j = 0; j < Width; ++j) std::swap(x[k * Width + j], x[other * Width + j]);
    for (int k = 0; k < 6; ++k)
      for (int i = k + 1; i < 6; ++i)
        for (int j = 0; j < Width; ++j) x[i * Width + j] -= lu_(i, k) * x[k * Width + j];
    for (int k = 5; k >= 0; --k) {
      for (int i = k + 1; i < 6; ++i)
        for (int j = 0; j < Width; ++j) x[k * Width + j] -= lu_(k, i) * x[i * Width + j];
      for (int j = 0; j < Width; ++j) x[k * Width + j] *= lu_(k, k);
    }
  }

 private:
  body_block lu_;
  std::array<int, 6> row_{};
};

/// Solved by block LU in an order of small fill, without exchanges between bodies: meant for I + a
/// matrix whose symmetric part is nearly positive. Rows and columns are numbers of bodies.
class body_elimination {
 public:
  body_elimination() = default;
  explicit body_elimination(const elimination_order& order)
      : cost_(product * order.cost()),
        n_(order.order().size()),
        place_(n_),
        body_(n_),
        diagonal_(n_),
        pivot_(n_) {
    for (std::size_t k = 0; k < n_; ++k) {
      body_[k] = order.order()[k];
      place_[index(body_[k])] = static_cast<std::int32_t>(k);
    }
    plain_vector<std::int32_t> row;
    for (std::size_t k = 0; k < n_; ++k) {
      row.clear();
      for (const std::int32_t i : order.touched(body_[k])) row.push_back(place_[index(i)]);
      sort_values(row);
      later_.append(row.data(), row.size());
      start_.push_back(later_.size());
    }
    lower_.resize(later_.size());
    upper_.resize(later_.size());
  }
  [[nodiscard]] std::size_t bodies() const { return n_; }
  /// Floating-point operations of a product of two blocks.
  static constexpr double product = 432;
  /// Floating-point operations of a factorization.
  [[nodiscard]] double cost() const { return cost_; }
  void clear() {
    diagonal_.assign(n_, body_block{});
    lower_.assign(later_.size(), body_block{});
    upper_.assign(later_.size(), body_block{});
  }
  [[nodiscard]] body_block& diagonal(std::int32_t body) {
    return diagonal_[index(place_[index(body)])];
  }
  /// The blocks (a, b) and (b, a); null if these bodies are not known to touch.
  [[nodiscard]] std::pair<body_block*, body_block*> pair(std::int32_t a, std::int32_t b) {
    const std::int32_t i = place_[index(a)], j = place_[index(b)];
    const std::size_t e = entry(std::min(i, j), std::max(i, j));
    if (e == later_.size()) return {nullptr, nullptr};
    return i < j ? std::pair{&upper_[e], &lower_[e]} : std::pair{&lower_[e], &upper_[e]};
  }
  /// Calls f(body, block) for each block, with the body of its row.
  template <class F>
  void each_block(F&& f) {
    for (std::size_t k = 0; k < n_; ++k) {
      f(body_[k], diagonal_[k]);
      for (std::size_t e = start_[k]; e < start_[k + 1]; ++e) {
        f(body_[k], upper_[e]);
        f(body_[index(later_[e])], lower_[e]);
      }
    }
  }

  /// Replaces the blocks by the factors; false if a pivot vanishes.
  [[nodiscard]] bool factorize() {
    for (std::size_t k = 0; k < n_; ++k) {
      if (!pivot_[k].factorize(diagonal_[k])) return false;
      const std::size_t first = start_[k], end = start_[k + 1];
      for (std::size_t e = first; e < end; ++e) pivot_[k].solve<6>(upper_[e].at.data());
      for (std::size_t x = first; x < end; ++x) {
        const std::size_t row = index(later_[x]);
        diagonal_[row].take(lower_[x], upper_[x]);
        std::size_t to = start_[row];
        for (std::size_t y = x + 1; y < end; ++y, ++to) {
          while (later_[to] != later_[y]) ++to;
          upper_[to].take(lower_[x], upper_[y]);
          lower_[to].take(lower_[y], upper_[x]);
        }
      }
    }
    return true;
  }
  /// Replaces the right-hand side, by bodies, by the solution.
  void solve(plain_vector<body_vector>& x) const {
    for (std::size_t k = 0; k < n_; ++k)
      for (std::size_t e = start_[k]; e < start_[k + 1]; ++e) {
        if (e == start_[k]) solved_ = x[index(body_[k])], pivot_[k].solve<1>(solved_.data());
        lower_[e].take_from(x[index(body_[index(later_[e])])], solved_);
      }
    for (std::size_t k = n_; k-- > 0;) {
      body_vector& own = x[index(body_[k])];
      pivot_[k].solve<1>(own.data());
      for (std::size_t e = start_[k]; e < start_[k + 1]; ++e)
        upper_[e].take_from(own, x[index(body_[index(later_[e])])]);
    }
  }

 private:
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] std::size_t entry(std::int32_t row, std::int32_t column) const {
    const auto first = later_.data() + start_[index(row)],
               end = later_.data() + start_[index(row) + 1];
    const auto found = std::lower_bound(first, end, column);
    return found != end && *found == column ? static_cast<std::size_t>(found - later_.data())
                                            : later_.size();
  }

  double cost_ = 0;
  std::size_t n_ = 0;
  plain_vector<std::int32_t> place_, body_;  ///< of a body in the order, and the other way
  plain_vector<std::size_t> start_{0};       ///< of each row in `later_`, and the end
  plain_vector<std::int32_t> later_;         ///< places, ascending in each row
  plain_vector<body_block> diagonal_, lower_, upper_;
  plain_vector<body_pivot> pivot_;
  mutable body_vector solved_{};
};

}  // namespace talus::detail
