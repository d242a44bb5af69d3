#pragma once
// Linear systems of 3 x 3 blocks.
#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <vector>

#include "talus/core/math.hpp"

namespace talus::detail {

/// A linear system of 3 x 3 blocks, solved by LU: dense where it is small, else sparse.
class block_system {
 public:
  static constexpr int dense_limit = 600;

  void reset(int blocks) {
    n_ = 3 * blocks;
    dense_ = n_ <= dense_limit;
    if (dense_) {
      matrix_.setZero(n_, n_);
    } else {
      entries_.clear();
    }
  }
  void add(int row, int column, const mat3& value) {
    if (dense_) {
      matrix_.block<3, 3>(3 * row, 3 * column) += value;
    } else {
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) entries_.emplace_back(3 * row + a, 3 * column + b, value(a, b));
    }
  }
  [[nodiscard]] bool factorize() {
    if (dense_) {
      dense_lu_.compute(matrix_);
      return true;
    }
    Eigen::SparseMatrix<real> a(n_, n_);
    a.setFromTriplets(entries_.begin(), entries_.end());
    sparse_lu_.compute(a);
    return sparse_lu_.info() == Eigen::Success;
  }
  [[nodiscard]] bool solve(const Eigen::VectorXd& right, Eigen::VectorXd& x) {
    if (dense_)
      x = dense_lu_.solve(right);
    else
      x = sparse_lu_.solve(right);
    return x.allFinite();
  }

 private:
  int n_ = 0;
  bool dense_ = true;
  Eigen::MatrixXd matrix_;
  Eigen::PartialPivLU<Eigen::MatrixXd> dense_lu_;
  Eigen::SparseLU<Eigen::SparseMatrix<real>, Eigen::COLAMDOrdering<int>> sparse_lu_;
  std::vector<Eigen::Triplet<real>> entries_;
};

}  // namespace talus::detail
