#pragma once
// An interior-point method for an assembled contact problem.
#include <algorithm>

#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/solver/direct/assembled.hpp"
#include "talus/solver/direct/block_system.hpp"

namespace talus::detail {

/// Primal-dual interior-point method for r in K, û in K*, both scaled to Lorentz cones: the
/// direction of Nesterov and Todd (1998) for the cones, Newton's for De Saxcé's term in û. It needs
/// no guess of which contacts stick, slide or open, and so works well if impulses are not unique
/// and masses differ by orders of magnitude; it cannot use a warm start.
class assembled_interior_point {
 public:
  explicit assembled_interior_point(const assembled_problem& p) : p_(&p) {
    const int n = p.contacts();
    scale_.reserve(n);
    real size = 0;  // of velocities
    for (int i = 0; i < n; ++i) size = std::max(size, p.q(i).norm());
    if (!(size > 0)) size = 1;
    const real least = 1e-9 * p.mean_diagonal();
    r_.set_zero(n), u_.set_zero(n);
    for (int i = 0; i < n; ++i) {
      const real mu = p.mu[i];
      scale_.push_back(mu > smooth ? vec3(1 / mu, 1, 1) : vec3(1, 0, 0));
      const vec3 w = scale_[i].cwiseProduct(p.own(i).diagonal()).cwiseProduct(scale_[i]);
      u_(i)[0] = size * std::max(scale_[i][0], real{1});
      r_(i)[0] = 100 * u_(i)[0] / std::max(w.maxCoeff(), least);
    }
  }

  /// One step; returns whether it was possible.
  bool step() {
    const int n = p_->contacts();
    // g = W r + q + |u_t| - u
    contact_vector g(n), right(n), dr, du(n);
    const contact_vector plain = impulses();
    real together = 0;
    for (int i = 0; i < n; ++i) {
      const vec3 u = u_(i);
      vec3 gi = scale_[i].cwiseProduct(p_->q(i) + p_->row_product(i, plain)) - u;
      gi[0] += portable::hypot(u[1], u[2]);
      if (smooth_at(i)) gi[1] = gi[2] = 0;
      g(i) = gi;
      together += r_(i).dot(u);
    }
    const real average = together / n;
    if (!(average > 0)) return false;

    system_.reset(n);
    plain_vector<mat3> scaling(n), turn(n);
    for (int i = 0; i < n; ++i) {
      const vec3 r = r_(i), u = u_(i);
      scaling[i] = scaling_of(i, r, u);
      turn[i] = mat3::Identity();
      const real t = portable::hypot(u[1], u[2]);
      if (t > 0) turn[i](0, 1) = -u[1] / t, turn[i](0, 2) = -u[2] / t;
      for (auto k = p_->start[i]; k < p_->start[i + 1]; ++k)
        system_.add(
            i, p_->column[k],
            diagonal_matrix(scale_[i]) * p_->block[k] * diagonal_matrix(scale_[p_->column[k]]));
      system_.add(i, i, turn[i] * scaling[i]);
    }
    if (!system_.factorize()) return false;

    // First the direction to the solution alone; the length of its step determines the amount of
    // centring.
    real centring = 0, length = 0;
    for (int pass = 0; pass < 2; ++pass) {
      contact_vector target(n);
      for (int i = 0; i < n; ++i) {
        const vec3 r = r_(i), u = u_(i);
        const vec3 c = centring * average * inverse_of(i, r) - u;
        target(i) = c;
        right(i) = turn[i] * c - g(i);
      }
      if (!system_.solve(right, dr)) return false;
      length = 1;
      for (int i = 0; i < n; ++i) {
        du(i) = target(i) - scaling[i] * dr(i);
        if (smooth_at(i)) du(i)[1] = du(i)[2] = dr(i)[1] = dr(i)[2] = 0;
        length = std::min({length, reach(r_(i), dr(i)), reach(u_(i), du(i))});
      }
      if (pass == 0) centring = std::clamp(portable::pow(1 - length, 3), 1e-6, 1.);
    }
    length_ = std::min(1., std::max(0.9, 1 - average) * length);
    length_ = std::min(1., 0.98 * length);
    const contact_vector r0 = r_, u0 = u_;
    for (int k = 0; k < 20; ++k, length_ *= 0.8) {
      r_ = r0 + length_ * dr;
      u_ = u0 + length_ * du;
      bool in = true;
      for (int i = 0; i < n && in; ++i) in = inside(r_(i)) && inside(u_(i));
      if (in) break;
    }
    return r_.is_finite() && u_.is_finite() && length_ > 1e-10;
  }

  /// The present impulses, within their cones.
  [[nodiscard]] contact_vector impulses() const {
    contact_vector r(r_.contacts());
    for (int i = 0; i < p_->contacts(); ++i) r(i) = scale_[i].cwiseProduct(r_(i));
    return r;
  }
  [[nodiscard]] real length() const { return length_; }

 private:
  static constexpr real smooth = 1e-7;  ///< smaller friction counts as zero here
  [[nodiscard]] bool smooth_at(int i) const { return scale_[i][1] == 0; }

  static bool inside(const vec3& x) { return x[0] > 0 && determinant(x) > 0; }
  static real determinant(const vec3& x) {
    const real t = portable::hypot(x[1], x[2]);
    return (x[0] - t) * (x[0] + t);
  }
  [[nodiscard]] vec3 inverse_of(int i, const vec3& r) const {
    if (smooth_at(i)) return {1 / r[0], 0, 0};
    return vec3(r[0], -r[1], -r[2]) / determinant(r);
  }
  /// The symmetric matrix P of the cone with P r = u.
  [[nodiscard]] mat3 scaling_of(int i, const vec3& r, const vec3& u) const {
    if (smooth_at(i)) return diagonal_matrix(vec3(u[0] / r[0], 1, 1));
    const real a = std::sqrt(determinant(r)), b = std::sqrt(determinant(u));
    const vec3 x = r / a, y = u / b;
    const vec3 z = (y + vec3(x[0], -x[1], -x[2])) / std::sqrt(2 * (1 + x.dot(y)));
    mat3 p = outer<vec3>(2 * z, z);
    p -= diagonal_matrix(vec3(1, -1, -1));
    return b / a * p;
  }
  /// The length for which x + length d stays in the Lorentz cone.
  static real reach(const vec3& x, const vec3& d) {
    const real a = d[0] * d[0] - d[1] * d[1] - d[2] * d[2];
    const real b = x[0] * d[0] - x[1] * d[1] - x[2] * d[2];
    const real c = determinant(x);
    // The smallest positive root of a l² + 2 b l + c.
    real least = HUGE_VAL;
    const real root = b * b - a * c;
    if (root >= 0) {
      const real k = -(b + std::copysign(std::sqrt(root), b));
      for (const real l : {k / a, c / k})
        if (l > 0 && l < least) least = l;
    }
    if (d[0] < 0) least = std::min(least, -x[0] / d[0]);
    return least;
  }

  const assembled_problem* p_;
  plain_vector<vec3> scale_;
  contact_vector r_, u_;  ///< in Lorentz cones: (mu r_n, r_t), (û_n / mu, û_t)
  real length_ = 0;
  block_system system_;
};

}  // namespace talus::detail
