#pragma once
// Newton's method for an assembled contact problem with a proximal term.
#include <vector>

#include "talus/response/assembled.hpp"
#include "talus/response/assembled_gauss_seidel.hpp"

namespace talus::detail {

/// Semi-smooth Newton steps on the function of Alart and Curnier (1991) for the problem with
/// u = W r + q + alpha (r - centre). The proximal term makes the linear systems regular where W is
/// not; with the centre moved to each solution it does not change what is converged to. System
/// solves the linear systems: block_system, or band_system.
template <class System>
class assembled_newton {
 public:
  assembled_newton(const assembled_problem& p, const assembled_sweeps& sweep)
      : p_(&p), sweep_(&sweep), place_(p.contacts()) {}

  /// Moves r towards the solution of the problem with the proximal term, until its residual is
  /// within `accuracy` times |r - centre| or after `steps` linear systems. Where a Newton step
  /// gains little, sweeps sort out which contacts stick, slide and open. Whether it got there.
  template <class GoOn>
  bool solve(vecx& r, const vecx& centre, real alpha, real accuracy, int steps, GoOn&& go_on) {
    alpha_ = alpha;
    steps_ = 0;
    real now = residual(r, centre, f_), best = now;
    vecx best_r = r;
    const real aim = accuracy * now;
    for (int k = 0, idle = 0; k < steps && idle < 6 && go_on(); ++k) {
      ++steps_;
      const real before = now;
      if (direction(r)) {
        // The first length that does well, else the best of all.
        real least = HUGE_VAL, length = 1;
        for (int trial = 0; trial < 8; ++trial, length *= 0.5) {
          trial_ = r + length * step_;
          const real found = residual(trial_, centre, trial_f_);
          if (found < least) least = found, chosen_ = trial_;
          if (least < (1 - 0.1 * length) * now) break;
        }
        if (least < now) r = chosen_;
        now = std::min(now, least);
      }
      if (now > 0.7 * before)
        for (int j = 0; j < 6; ++j) (*sweep_)(r, j % 2 != 0, alpha, centre);
      now = residual(r, centre, f_);
      if (now < best) {
        idle = now < 0.9 * best ? 0 : idle + 1;
        best = now, best_r = r;
      } else {
        ++idle;
      }
      if (now <= aim) return true;
    }
    r = best_r;
    return best <= aim;
  }

  /// Whole Newton steps, whatever they do to the residual: where many contacts share a load, the
  /// way to the right choice of those that carry it leads through large residuals. Ends when the
  /// residual is within `accuracy` times |r - centre|, else hands back the best of `steps`. Whether
  /// it got there.
  bool solve_by_whole_steps(vecx& r, const vecx& centre, real alpha, real accuracy, int steps) {
    alpha_ = alpha;
    steps_ = 0;
    real now = residual(r, centre, f_), best = now;
    vecx best_r = r;
    while (steps_ < steps) {
      ++steps_;
      if (!direction(r)) break;
      r += step_;
      now = residual(r, centre, f_);
      if (now < best) best = now, best_r = r;
      if (now <= accuracy * (r - centre).norm()) return true;
    }
    r = best_r;
    return false;
  }

  /// Linear systems solved by the last call.
  [[nodiscard]] int steps() const { return steps_; }

 private:
  enum class state { open, sticks, slides };

  real rho(int i) const { return 3 / (p_->own(i).trace() + 3 * alpha_); }

  state state_of(int i, const vecx& r, const vecx& u, vec3& y) const {
    y = r.segment<3>(3 * i) - rho(i) * u.segment<3>(3 * i);
    if (y[0] <= 0) return state::open;
    const real t = std::hypot(y[1], y[2]);
    return p_->mu[i] > 0 && t <= p_->mu[i] * y[0] ? state::sticks : state::slides;
  }

  real residual(const vecx& r, const vecx& centre, vecx& f) {
    p_->velocity(r, u_);
    u_ += alpha_ * (r - centre);
    f.resize(r.size());
    for (int i = 0; i < p_->contacts(); ++i) {
      vec3 y;
      auto fi = f.segment<3>(3 * i);
      const auto ri = r.segment<3>(3 * i);
      const auto ui = u_.segment<3>(3 * i);
      switch (state_of(i, r, u_, y)) {
        case state::open:
          fi = ri;
          break;
        case state::sticks:
          fi = rho(i) * ui;
          break;
        case state::slides: {
          const real t = std::hypot(y[1], y[2]), scale = t > 0 ? p_->mu[i] * y[0] / t : 0;
          fi = vec3(rho(i) * ui[0], ri[1] - scale * y[1], ri[2] - scale * y[2]);
        }
      }
    }
    return f.norm();
  }

  /// The Newton step from r; u_ and f_ belong to it. Open contacts drop out: theirs is -r.
  bool direction(const vecx& r) {
    const int n = p_->contacts();
    vec3 y;
    int active = 0;
    step_ = -r;
    for (int i = 0; i < n; ++i) place_[i] = state_of(i, r, u_, y) == state::open ? -1 : active++;
    if (active == 0) return true;
    system_.reset(active);
    vecx right(3 * active), x;
    for (int i = 0; i < n; ++i) {
      const int row = place_[i];
      if (row < 0) continue;
      // f changes by of_u du + of_r dr
      mat3 of_u = rho(i) * mat3::Identity(), of_r = mat3::Zero();
      if (state_of(i, r, u_, y) == state::slides) {
        const real t = std::hypot(y[1], y[2]), mu = p_->mu[i];
        const real c = t > 0 ? y[1] / t : 0, s = t > 0 ? y[2] / t : 0;
        const real turn = t > 0 ? mu * y[0] / t : 0;
        const Eigen::Vector2d d{c, s};
        const Eigen::Matrix2d across = turn * (Eigen::Matrix2d::Identity() - d * d.transpose());
        of_r.bottomRightCorner<2, 2>() = Eigen::Matrix2d::Identity() - across;
        of_r.bottomLeftCorner<2, 1>() = -mu * d;
        of_u.bottomRightCorner<2, 2>() = rho(i) * across;
        of_u.bottomLeftCorner<2, 1>() = rho(i) * mu * d;
      }
      vec3 known{0, 0, 0};
      for (auto k = p_->start[i]; k < p_->start[i + 1]; ++k) {
        const int j = p_->column[k];
        if (place_[j] >= 0)
          system_.add(row, place_[j], of_u * p_->block[k]);
        else
          known += p_->block[k] * r.segment<3>(3 * j);
      }
      system_.add(row, row, alpha_ * of_u + of_r);
      right.segment<3>(3 * row) = of_u * known - f_.segment<3>(3 * i);
    }
    if (!system_.factorize() || !system_.solve(right, x)) return false;
    for (int i = 0; i < n; ++i)
      if (place_[i] >= 0) step_.segment<3>(3 * i) = x.segment<3>(3 * place_[i]);
    return true;
  }

  const assembled_problem* p_;
  const assembled_sweeps* sweep_;
  std::vector<int> place_;  ///< in the linear system, -1 for open contacts
  System system_;
  real alpha_ = 0;
  int steps_ = 0;
  vecx u_, f_, trial_, trial_f_, step_, chosen_;
};

}  // namespace talus::detail
