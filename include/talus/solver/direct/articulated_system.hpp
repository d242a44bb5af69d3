#pragma once
// The saddle-point system of bodies and of the joints between them, sparse and in blocks.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/direct/block_product.hpp"
#include "talus/solver/direct/elimination_order.hpp"

namespace talus::detail {

/// The matrix [M J'; J -C], with the masses M of bodies, the rows J of joints and their compliances
/// C. It is factorized as L D L' without pivoting between blocks. Bodies are eliminated by minimum
/// degree. A body is followed by one joint, if none that ends with it precedes; other joints follow
/// the last of their bodies. Along a chain each block then is definite, and the effort is linear.
/// Rows that depend on others, as in closed loops, leave pivots that are round-off. These get a
/// compliance of the size of their mobility, and the caller refines the solution.
class articulated_system {
 public:
  /// A joint between two bodies of the system, numbered from 0, or -1 for what never moves.
  struct tie {
    std::int32_t a, b;
    std::int32_t rows;
  };
  static constexpr std::int32_t body_size = 6;

  /// Finds the structure; the values follow.
  void arrange(std::int32_t bodies, std::span<const tie> ties) {
    bodies_ = bodies;
    order(ties);
    find_fill(ties);
  }
  /// Sets all values to 0.
  void clear() {
    for (auto* all : {&values_, &scale_, &compliance_}) all->assign(all->size(), 0);
  }
  void set_body(std::int32_t i, real mass, const mat3& inertia) {
    real* d = values_.data() + diagonal_[at(place_[at(i)])];
    for (int k = 0; k < 3; ++k) d[7 * k] = mass;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) d[6 * (3 + k) + 3 + j] = inertia(k, j);
  }
  /// Row k of joint j: what it multiplies the velocities of its bodies by, its compliance and, as
  /// a scale, the sum of its velocities for a unit impulse. A row that is not set keeps impulse 0.
  void set_row(std::int32_t j, std::int32_t k, const std::array<real, 6>& of_a,
               const std::array<real, 6>& of_b, real compliance, real scale) {
    const std::int32_t p = place_[at(bodies_ + j)], n = size_[at(p)];
    values_[diagonal_[at(p)] + at(k) * at(n + 1)] = -compliance;
    scale_[first_[at(p)] + at(k)] = scale;
    compliance_[first_[at(p)] + at(k)] = compliance;
    const auto put = [&](std::size_t block, bool joint_is_row, const std::array<real, 6>& x) {
      if (block == none) return;
      for (std::size_t i = 0; i < 6; ++i)
        values_[block + (joint_is_row ? at(k) * 6 + i : i * at(n) + at(k))] = x[i];
    };
    const ends& e = ends_[at(j)];
    put(e.a, e.a_first, of_a), put(e.b, e.b_first, of_b);
  }

  /// Rows whose elimination leaves less than a part of their diagonal depend on others.
  void factorize(real dependence = round_off) {
    dependence_ = dependence;
    for (std::size_t p = 0; p < size_.size(); ++p) {
      factorize_block(p);
      const std::size_t n = at(size_[p]);
      const real* l = values_.data() + diagonal_[p];
      const real sign = is_body(p) ? 1 : -1;
      for (std::size_t e = start_[p]; e < start_[p + 1]; ++e) {
        real* y = values_.data() + block_[e];
        for (std::size_t i = 0, rows = at(size_[at(later_[e])]); i < rows; ++i)
          for (std::size_t j = 0; j < n; ++j) {
            real sum = y[i * n + j];
            for (std::size_t k = 0; k < j; ++k) sum -= y[i * n + k] * l[j * n + k];
            y[i * n + j] = sum / l[j * n + j];
          }
      }
      for (std::size_t e = start_[p]; e < start_[p + 1]; ++e) {
        const std::size_t q = at(later_[e]), columns = at(size_[q]);
        turned_.resize(n * columns);
        const real* y = values_.data() + block_[e];
        for (std::size_t j = 0; j < columns; ++j)
          for (std::size_t k = 0; k < n; ++k) turned_[k * columns + j] = y[j * n + k];
        const block_product product = block_product_of(n, columns);
        const auto subtract = [&](real* to, std::size_t f) {
          product(to, values_.data() + block_[f], turned_.data(), at(size_[at(later_[f])]), n,
                  columns, sign);
        };
        subtract(values_.data() + diagonal_[q], e);
        std::size_t to = start_[q];
        for (std::size_t f = e + 1; f < start_[p + 1]; ++f) {
          while (later_[to] != later_[f]) ++to;
          subtract(values_.data() + block_[to], f);
        }
      }
    }
  }
  /// The position of the unknowns of a body, and of a joint, in a vector of size().
  [[nodiscard]] std::size_t of_body(std::int32_t i) const { return first_[at(place_[at(i)])]; }
  [[nodiscard]] std::size_t of_joint(std::int32_t j) const {
    return first_[at(place_[at(bodies_ + j)])];
  }
  [[nodiscard]] std::size_t size() const { return scale_.size(); }
  /// Whether rows eliminated before a row determine its velocity, by its position.
  [[nodiscard]] bool depends(std::size_t row) const { return added_[row] != 0; }
  /// The compliance that the factorization has added to a row, by its position.
  [[nodiscard]] real added(std::size_t row) const { return added_[row]; }
  /// The velocity of a row for a unit impulse where these hold.
  [[nodiscard]] real left_of(std::size_t row) const { return left_[row]; }

  /// Replaces the right-hand side by the solution.
  void solve(plain_vector<real>& x) const {
    for (std::size_t p = 0; p < size_.size(); ++p) {
      const std::size_t n = at(size_[p]);
      const real* l = values_.data() + diagonal_[p];
      real* own = x.data() + first_[p];
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) own[i] -= l[i * n + k] * own[k];
        own[i] /= l[i * n + i];
      }
      const real sign = is_body(p) ? 1 : -1;
      for (std::size_t e = start_[p]; e < start_[p + 1]; ++e) {
        const std::size_t q = at(later_[e]), rows = at(size_[q]);
        const real* y = values_.data() + block_[e];
        real* to = x.data() + first_[q];
        for (std::size_t i = 0; i < rows; ++i) {
          real sum = 0;
          for (std::size_t k = 0; k < n; ++k) sum += y[i * n + k] * own[k];
          to[i] -= sign * sum;
        }
      }
    }
    for (std::size_t p = size_.size(); p-- > 0;) {
      const std::size_t n = at(size_[p]);
      const real* l = values_.data() + diagonal_[p];
      const real sign = is_body(p) ? 1 : -1;
      real* own = x.data() + first_[p];
      for (std::size_t k = 0; k < n; ++k) own[k] *= sign;
      for (std::size_t e = start_[p]; e < start_[p + 1]; ++e) {
        const std::size_t q = at(later_[e]), rows = at(size_[q]);
        const real* y = values_.data() + block_[e];
        const real* from = x.data() + first_[q];
        for (std::size_t i = 0; i < rows; ++i)
          for (std::size_t k = 0; k < n; ++k) own[k] -= sign * y[i * n + k] * from[i];
      }
      for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) own[i] -= l[k * n + i] * own[k];
        own[i] /= l[i * n + i];
      }
    }
  }

 private:
  static constexpr std::size_t none = ~std::size_t{0};
  static constexpr real round_off = 1e-12;
  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] bool is_body(std::size_t p) const { return node_[p] < bodies_; }

  struct ends {
    std::size_t a = none, b = none;  ///< blocks
    bool a_first = false, b_first = false;
  };

  /// Places of the nodes: bodies, then joints.
  void order(std::span<const tie> ties) {
    plain_vector<plain_pair<std::int32_t, std::int32_t>> pairs;
    vector_of<plain_vector<std::int32_t>> of_body(at(bodies_));
    for (std::size_t j = 0; j < ties.size(); ++j) {
      const auto [a, b, rows] = ties[j];
      if (a >= 0) of_body[at(a)].push_back(static_cast<std::int32_t>(j));
      if (b >= 0) of_body[at(b)].push_back(static_cast<std::int32_t>(j));
      if (a >= 0 && b >= 0) pairs.push_back({a, b}), pairs.push_back({b, a});
    }
    sort_values(pairs);
    sparse_graph graph;
    std::size_t next = 0;
    for (std::int32_t i = 0; i < bodies_; ++i) {
      for (std::int32_t last = -1; next < pairs.size() && pairs[next].first == i; ++next)
        if (pairs[next].second != last) graph.column.push_back(last = pairs[next].second);
      graph.start.push_back(static_cast<std::int32_t>(graph.column.size()));
    }
    const elimination_order bodies(graph, std::numeric_limits<double>::infinity());

    node_.clear(), size_.clear();
    const std::size_t nodes = at(bodies_) + ties.size();
    place_.assign(nodes, -1);
    const auto put = [&](std::int32_t node, std::int32_t size) {
      place_[at(node)] = static_cast<std::int32_t>(node_.size());
      node_.push_back(node), size_.push_back(size);
    };
    const auto gone = [&](std::int32_t i) { return i < 0 || place_[at(i)] >= 0; };
    for (const std::int32_t i : bodies.order()) {
      put(i, body_size);
      bool taken = false;
      for (const bool last : {true, false})
        for (const std::int32_t j : of_body[at(i)]) {
          const tie& t = ties[at(j)];
          if (place_[at(bodies_ + j)] >= 0 || (gone(t.a) && gone(t.b)) != last) continue;
          if (!last && taken) continue;
          put(bodies_ + j, t.rows);
          taken = true;
        }
    }
  }

  /// The blocks below the diagonal, with those that the elimination adds.
  void find_fill(std::span<const tie> ties) {
    const std::size_t n = node_.size();
    vector_of<plain_vector<std::int32_t>> below(n);
    const auto join = [&](std::int32_t x, std::int32_t y) {
      below[at(std::min(x, y))].push_back(std::max(x, y));
    };
    for (std::size_t j = 0; j < ties.size(); ++j)
      for (const std::int32_t i : {ties[j].a, ties[j].b})
        if (i >= 0) join(place_[at(i)], place_[at(bodies_) + j]);
    start_.assign(1, 0), later_.clear(), block_.clear();
    diagonal_.resize(n), first_.resize(n);
    std::size_t values = 0, unknowns = 0;
    for (std::size_t p = 0; p < n; ++p) {
      auto& list = below[p];
      sort_values(list);
      std::size_t kept = 0;
      for (const std::int32_t q : list)
        if (kept == 0 || list[kept - 1] != q) list[kept++] = q;
      list.resize(kept);
      const std::size_t own = at(size_[p]);
      diagonal_[p] = values, first_[p] = unknowns;
      values += own * own, unknowns += own;
      for (const std::int32_t q : list)
        later_.push_back(q), block_.push_back(values), values += own * at(size_[at(q)]);
      start_.push_back(later_.size());
      for (std::size_t k = 1; k < kept; ++k) below[at(list[0])].push_back(list[k]);
      plain_vector<std::int32_t>().swap(list);
    }
    values_.resize(values), scale_.resize(unknowns), compliance_.resize(unknowns);
    added_.assign(unknowns, 0), left_.assign(unknowns, 0);
    ends_.assign(ties.size(), {});
    for (std::size_t j = 0; j < ties.size(); ++j) {
      const std::int32_t place = place_[at(bodies_) + j];
      const auto find = [&](std::int32_t body, std::size_t& block, bool& joint_is_row) {
        if (body < 0) return;
        const std::int32_t other = place_[at(body)];
        joint_is_row = place > other;
        const std::size_t low = at(std::min(place, other));
        const std::int32_t high = std::max(place, other);
        for (std::size_t e = start_[low]; e < start_[low + 1]; ++e)
          if (later_[e] == high) block = block_[e];
      };
      find(ties[j].a, ends_[j].a, ends_[j].a_first), find(ties[j].b, ends_[j].b, ends_[j].b_first);
    }
  }

  /// Replaces a block of the diagonal, which is definite, by its Cholesky factor.
  void factorize_block(std::size_t p) {
    const std::size_t n = at(size_[p]);
    real* d = values_.data() + diagonal_[p];
    const bool body = is_body(p);
    if (!body)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j) d[i * n + j] = -d[i * n + j];
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        real sum = d[i * n + j];
        for (std::size_t k = 0; k < j; ++k) sum -= d[i * n + k] * d[j * n + k];
        d[i * n + j] = sum / d[j * n + j];
      }
      const real own = d[i * n + i];
      real pivot = own;
      for (std::size_t k = 0; k < i; ++k) pivot -= d[i * n + k] * d[i * n + k];
      if (body) {
        pivot = std::max(pivot, round_off * own);
      } else {
        const real scale = scale_[first_[p] + i];
        pivot = std::max(pivot, compliance_[first_[p] + i]);
        const bool depends = !(pivot > dependence_ * scale);
        real& added = added_[first_[p] + i];
        added = depends ? (scale > 0 ? scale : real(1)) : real(0);
        left_[first_[p] + i] = depends ? real(0) : pivot;
        if (depends) pivot = std::max(pivot, real(0)) + added;
      }
      d[i * n + i] = std::sqrt(pivot);
    }
  }
  std::int32_t bodies_ = 0;
  real dependence_ = round_off;
  plain_vector<std::int32_t> place_, node_;  ///< of a node in the order, and the other way
  plain_vector<std::int32_t> size_;          ///< unknowns, by place, and likewise:
  plain_vector<std::size_t> diagonal_, first_, start_{0};
  plain_vector<std::int32_t> later_;  ///< places of the blocks below, ascending
  plain_vector<std::size_t> block_;
  plain_vector<ends> ends_;
  plain_vector<real> values_, scale_, compliance_, added_, left_;
  plain_vector<real> turned_;  ///< the transpose of a block
};

}  // namespace talus::detail
