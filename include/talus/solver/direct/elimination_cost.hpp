#pragma once
// The cost of a factorization of the Delassus operator of an assembled problem, estimated before
// it.
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/assembled.hpp"

namespace talus::detail {

/// Multiplications and additions of an LU factorization of W by blocks in an order of approximate
/// minimum degree, without pivoting; from the elimination tree (Liu 1990).
[[nodiscard]] inline real elimination_cost(const assembled_problem& p) {
  const int n = p.contacts();
  std::vector<Eigen::Triplet<real>> entries;
  entries.reserve(p.column.size());
  for (int i = 0; i < n; ++i)
    for (auto k = p.start[i]; k < p.start[i + 1]; ++k) entries.emplace_back(i, p.column[k], 1.);
  Eigen::SparseMatrix<real> pattern(n, n);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  const auto& at = order.indices();  // the row eliminated k-th
  plain_vector<int> place(n), parent(n, -1), seen(n, -1);
  plain_vector<real> height(n, 1);  // of the columns of L
  for (int k = 0; k < n; ++k) place[at[k]] = k;
  for (int k = 0; k < n; ++k) {
    seen[k] = k;
    for (auto e = p.start[at[k]]; e < p.start[at[k] + 1]; ++e)
      for (int i = place[p.column[e]]; i < k && seen[i] != k; i = parent[i]) {
        if (parent[i] < 0) parent[i] = k;
        ++height[i];
        seen[i] = k;
      }
  }
  real cost = 0;
  for (const real h : height) cost += 54 * h * h;
  return cost;
}

}  // namespace talus::detail
