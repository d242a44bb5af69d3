#pragma once
// Linear systems of 3 x 3 blocks.
#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <cstdint>
#include <utility>

#include "talus/core/contact_vector.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// A linear system of 3 x 3 blocks, not symmetric, solved by LU: dense if it is small or full, else
/// sparse.
class block_system {
 public:
  void reset(int rows) {
    rows_ = rows;
    entries_.clear();
  }
  /// Blocks at the same position are added up.
  void add(std::int32_t row, std::int32_t column, const mat3& value) {
    entries_.push_back({row, column, value});
  }
  /// Whether it succeeded; a matrix that is singular to round-off may be detected only in solve().
  [[nodiscard]] bool factorize() {
    const auto size = 3 * static_cast<Eigen::Index>(rows_);
    const real fill = 9 * static_cast<real>(entries_.size()) / (static_cast<real>(size) * size);
    dense_ = size <= 48 || (size <= 900 && fill > 0.2);
    if (dense_) {
      matrix_.setZero(size, size);
      for (const entry& e : entries_)
        for (int j = 0; j < 3; ++j)
          for (int i = 0; i < 3; ++i) matrix_(3 * e.row + i, 3 * e.column + j) += e.value(i, j);
      dense_lu_.compute(matrix_);
      return true;
    }
    compress();
    if (pattern_ != place_) {
      sparse_lu_.analyzePattern(sparse_);
      pattern_ = place_;
    }
    sparse_lu_.factorize(sparse_);
    return sparse_lu_.info() == Eigen::Success;
  }
  /// Whether the solution is finite.
  [[nodiscard]] bool solve(const contact_vector& right, contact_vector& x) {
    const auto size = static_cast<Eigen::Index>(right.size());
    const Eigen::Map<const Eigen::VectorXd> b(right.data(), size);
    x.resize(right.contacts());
    Eigen::Map<Eigen::VectorXd> solution(x.data(), size);
    if (dense_)
      solution = dense_lu_.solve(b);
    else
      solution = sparse_lu_.solve(b);
    return x.is_finite();
  }

 private:
  struct entry {
    std::int32_t row, column;
    mat3 value;
  };

  /// The entries by columns; `place_` holds the positions of the blocks.
  void compress() {
    plain_vector<std::int32_t> start(rows_ + 1, 0), by_row(entries_.size()), order(entries_.size());
    const auto sort = [&](auto&& key, auto&& from, plain_vector<std::int32_t>& to) {
      std::fill(start.begin(), start.end(), 0);
      for (const entry& e : entries_) ++start[key(e) + 1];
      for (int i = 0; i < rows_; ++i) start[i + 1] += start[i];
      for (std::size_t k = 0; k < entries_.size(); ++k)
        to[start[key(entries_[from(k)])]++] = static_cast<std::int32_t>(from(k));
    };
    sort([](const entry& e) { return e.row; }, [](std::size_t k) { return k; }, by_row);
    sort([](const entry& e) { return e.column; },
         [&](std::size_t k) { return static_cast<std::size_t>(by_row[k]); }, order);

    place_.clear();
    plain_vector<mat3> sum;
    for (const std::int32_t k : order) {
      const entry& e = entries_[k];
      if (!place_.empty() && place_.back() == plain_pair{e.column, e.row}) {
        sum.back() += e.value;
      } else {
        place_.push_back({e.column, e.row});
        sum.push_back(e.value);
      }
    }
    const auto size = 3 * static_cast<Eigen::Index>(rows_);
    sparse_.resize(size, size);
    sparse_.resizeNonZeros(9 * static_cast<Eigen::Index>(place_.size()));
    int* outer = sparse_.outerIndexPtr();
    int* inner = sparse_.innerIndexPtr();
    real* value = sparse_.valuePtr();
    int filled = 0;
    std::size_t first = 0;
    for (int column = 0; column < rows_; ++column) {
      std::size_t last = first;
      while (last < place_.size() && place_[last].first == column) ++last;
      for (int c = 0; c < 3; ++c) {
        outer[3 * column + c] = filled;
        for (std::size_t k = first; k < last; ++k)
          for (int r = 0; r < 3; ++r) {
            inner[filled] = 3 * place_[k].second + r;
            value[filled++] = sum[k](r, c);
          }
      }
      first = last;
    }
    outer[size] = filled;
  }

  int rows_ = 0;
  bool dense_ = true;
  plain_vector<entry> entries_;
  plain_vector<plain_pair<std::int32_t, std::int32_t>> place_, pattern_;  ///< column, row
  Eigen::MatrixXd matrix_;
  Eigen::SparseMatrix<real> sparse_;
  Eigen::PartialPivLU<Eigen::MatrixXd> dense_lu_;
  Eigen::SparseLU<Eigen::SparseMatrix<real>, Eigen::COLAMDOrdering<int>> sparse_lu_;
};

}  // namespace talus::detail
