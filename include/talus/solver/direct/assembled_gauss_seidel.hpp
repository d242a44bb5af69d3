#pragma once
// Nonlinear Gauss-Seidel on an assembled problem.

#include "talus/constraint/coulomb.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/assembled.hpp"

namespace talus::detail {

/// Each contact in turn is solved exactly for its cone with all others held (Jourdan, Alart, Jean
/// 1998). A proximal term regularizes a contact with a (nearly) singular block, and does not change
/// the solutions of the whole problem.
class assembled_sweeps {
 public:
  explicit assembled_sweeps(const assembled_problem& p) : p_(&p) {
    const real mean = p.mean_diagonal();
    own_.reserve(p.contacts());
    for (int i = 0; i < p.contacts(); ++i) {
      mat3 w = p.own(i);
      real size = 1e-12 * mean;
      for (int k = 0; k < 9; ++k) size = std::max(size, std::abs(w.data()[k]));
      // Leading minors: positive if w is (nearly symmetric and) positive definite.
      const real a = w(0, 0), b = a * w(1, 1) - w(0, 1) * w(1, 0), c = w.determinant();
      const bool sound = a > 1e-9 * size && b > 1e-9 * a * size && c > 1e-9 * b * size;
      const real hold = sound ? 0 : 1e-6 * size;
      w += diagonal_matrix(hold);
      own_.push_back(w);
    }
  }

  /// One sweep, up or down the contacts, for u = W r + q + alpha (r - centre); |change of r|².
  real operator()(contact_vector& r, bool down, real alpha, const contact_vector& centre) const {
    return sweep(r, down, [&](int i, const vec3& rest) {
      mat3 w = own_[i];
      w += diagonal_matrix(alpha);
      return solve_coulomb(w, rest - alpha * centre(i), p_->mu[i]);
    });
  }
  /// One sweep, up or down the contacts, for u = W r + q; |change of r|².
  real operator()(contact_vector& r, bool down = false) const {
    return sweep(r, down,
                 [&](int i, const vec3& rest) { return solve_coulomb(own_[i], rest, p_->mu[i]); });
  }

 private:
  template <class Local>
  real sweep(contact_vector& r, bool down, Local&& local) const {
    const int n = p_->contacts();
    real moved = 0;
    for (int k = 0; k < n; ++k) {
      const int i = down ? n - 1 - k : k;
      vec3& ri = r(i);
      const vec3 before = ri;
      const vec3 rest = p_->q(i) + p_->row_product(i, r) - own_[i] * before;
      const vec3 now = local(i, rest);
      if (!all_finite(now)) continue;
      ri = now;
      moved += (now - before).squaredNorm();
    }
    return moved;
  }

  const assembled_problem* p_;
  plain_vector<mat3> own_;
};

}  // namespace talus::detail
