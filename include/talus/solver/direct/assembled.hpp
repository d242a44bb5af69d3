#pragma once
// A contact problem with its Delassus operator assembled: u = W r + q, Coulomb's law at each
// contact. Direct solvers of stalled islands use it, and so do external problems.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "talus/core/contact_vector.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/sort.hpp"

namespace talus::detail {

/// The block of W that gives the velocity of contact `row` for an impulse at contact `column`.
struct delassus_block {
  std::int32_t row = 0;
  std::int32_t column = 0;
  mat3 value;
};

/// Contacts in local frames (normal, tangent, tangent): u = W r + q, û = u + mu |u_t| e_n, and K*
/// contains û, orthogonal to r in K, the Coulomb cone |r_t| <= mu r_n (De Saxcé's form of Coulomb's
/// law with Signorini's condition). W is sparse by blocks of 3 x 3, in compressed rows, with all
/// diagonal blocks. W may be singular and not quite symmetric.
struct assembled_problem {
  plain_vector<std::int32_t> start{0};  ///< of each row in `column` and `block`, and the end
  plain_vector<std::int32_t> column;    ///< ascending in each row
  plain_vector<mat3> block;
  plain_vector<std::int32_t> diagonal;  ///< place of each row's diagonal block
  contact_vector q;                     ///< velocities without impulses
  plain_vector<real> mu;

  [[nodiscard]] int contacts() const { return static_cast<int>(mu.size()); }
  [[nodiscard]] const mat3& own(int i) const { return block[diagonal[i]]; }

  /// Sum over row i of W r.
  [[nodiscard]] vec3 row_product(int i, const contact_vector& r) const {
    vec3 sum{0, 0, 0};
    for (auto k = start[i]; k < start[i + 1]; ++k) sum += block[k] * r(column[k]);
    return sum;
  }
  /// u = W r + q
  void velocity(const contact_vector& r, contact_vector& u) const {
    u.resize(q.contacts());
    for (int i = 0; i < contacts(); ++i) u(i) = q(i) + row_product(i, r);
  }
  /// Mean of the diagonal of W: the scale of an inverse mass. 1 if it is not usable as a scale.
  [[nodiscard]] real mean_diagonal() const {
    real sum = 0;
    for (int i = 0; i < contacts(); ++i) sum += trace(own(i));
    const real mean = contacts() > 0 ? sum / (3 * contacts()) : 0;
    return mean > 0 && std::isfinite(mean) ? mean : 1;
  }
};

/// A problem of mu.size() contacts from blocks in any order; those of one place are added up.
/// Throws invalid_argument for places outside the matrix, sizes that do not fit, values that are
/// not finite, and negative friction.
[[nodiscard]] inline assembled_problem assemble(plain_vector<delassus_block> blocks,
                                                contact_vector q, plain_vector<real> mu) {
  const auto n = static_cast<std::int32_t>(mu.size());
  if (q.contacts() != n)
    fail<std::invalid_argument>("{} contacts need {} values of q, not {}", n, 3 * n, q.size());
  for (std::int32_t i = 0; i < n; ++i) {
    if (!(mu[i] >= 0) || !std::isfinite(mu[i]))
      fail<std::invalid_argument>("contact {}: friction must be finite and >= 0, but is {}", i,
                                  mu[i]);
    if (!all_finite(q(i))) fail<std::invalid_argument>("contact {}: q is not finite", i);
  }
  for (const auto& b : blocks) {
    if (b.row < 0 || b.row >= n || b.column < 0 || b.column >= n)
      fail<std::invalid_argument>("a block of W at ({}, {}) is outside of {} contacts", b.row,
                                  b.column, n);
    if (!std::all_of(b.value.data(), b.value.data() + 9, [](real x) { return std::isfinite(x); }))
      fail<std::invalid_argument>("the block of W at ({}, {}) is not finite", b.row, b.column);
  }
  for (std::int32_t i = 0; i < n; ++i) blocks.push_back({i, i, diagonal_matrix(real{0})});
  plain_vector<plain_pair<std::int64_t, std::uint32_t>> order;  // place in W, block
  order.reserve(blocks.size());
  for (const auto& b : blocks)
    order.emplace_back(std::int64_t{n} * b.row + b.column,
                       static_cast<std::uint32_t>(order.size()));
  sort_values(order);

  assembled_problem p;
  p.q = std::move(q);
  p.mu = std::move(mu);
  p.diagonal.resize(n);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto& b = blocks[order[k].second];
    if (k > 0 && order[k].first == order[k - 1].first) {
      p.block.back() += b.value;
      continue;
    }
    if (b.row == b.column) p.diagonal[b.row] = static_cast<std::int32_t>(p.block.size());
    p.start.resize(b.row + 2, static_cast<std::int32_t>(p.block.size()));
    p.column.push_back(b.column);
    p.block.push_back(b.value);
    p.start[b.row + 1] = static_cast<std::int32_t>(p.block.size());
  }
  return p;
}

/// The point of the Coulomb cone |x_t| <= mu x_n nearest to x.
[[nodiscard]] inline vec3 project_on_cone(const vec3& x, real mu) {
  const real t = portable::hypot(x[1], x[2]);
  if (t <= mu * x[0]) return x;
  if (mu * t <= -x[0]) return {0, 0, 0};
  const real n = (x[0] + mu * t) / (1 + mu * mu);
  const real scale = t > 0 ? mu * n / t : 0;
  return {n, scale * x[1], scale * x[2]};
}

/// The error of an r: the residual of the natural map, with û from u = W r + q.
struct contact_error {
  real scaled = 0;    ///< |r - P(r - rho û)| / max(|r|, rho |q|, rho |u|), rho = 1/mean_diagonal()
  real by_q = 0;      ///< |r - P(r - û)| / |q| (Acary, Brémond, Huber 2018)
  real relative = 0;  ///< the same over max(|q|, |r|, |u|)
};

/// |r - P(r - rho û)|
[[nodiscard]] inline real natural_residual(const assembled_problem& p, const contact_vector& r,
                                           const contact_vector& u, real rho) {
  real sum = 0;
  for (int i = 0; i < p.contacts(); ++i) {
    const vec3 ri = r(i);
    vec3 v = u(i);
    v[0] += p.mu[i] * portable::hypot(v[1], v[2]);
    sum += (ri - project_on_cone(ri - rho * v, p.mu[i])).squaredNorm();
  }
  return std::sqrt(sum);
}

/// 0 / 0 counts as no error; any other quotient by 0, and NaN, as an infinite one.
[[nodiscard]] inline real error_ratio(real residual, real size) {
  if (residual == 0 && size >= 0) return 0;
  const real ratio = residual / size;
  return ratio >= 0 ? ratio : HUGE_VAL;
}

/// The error measure of the solvers' stopping criterion; `u` is W r + q.
[[nodiscard]] inline real scaled_error(const assembled_problem& p, const contact_vector& r,
                                       const contact_vector& u, real rho) {
  return error_ratio(natural_residual(p, r, u, rho),
                     std::max({r.norm(), rho * p.q.norm(), rho * u.norm()}));
}

[[nodiscard]] inline contact_error error_of(const assembled_problem& p, const contact_vector& r) {
  contact_vector u;
  p.velocity(r, u);
  const real plain = natural_residual(p, r, u, 1);
  return {scaled_error(p, r, u, 1 / p.mean_diagonal()), error_ratio(plain, p.q.norm()),
          error_ratio(plain, std::max({p.q.norm(), r.norm(), u.norm()}))};
}

}  // namespace talus::detail
