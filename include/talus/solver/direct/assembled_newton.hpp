#pragma once
// Newton's method for an assembled contact problem with a proximal term.

#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/solver/direct/assembled.hpp"
#include "talus/solver/direct/assembled_gauss_seidel.hpp"

namespace talus::detail {

/// Semi-smooth Newton steps on the function of Alart and Curnier (1991) for the problem with u = W
/// r + q + alpha (r - centre). The proximal term makes the linear systems regular if W is singular;
/// with the centre moved to each solution it does not change the limit. System solves the linear
/// systems: block_system, or band_system.
template <class System>
class assembled_newton {
 public:
  assembled_newton(const assembled_problem& p, const assembled_sweeps& sweep)
      : p_(&p), sweep_(&sweep), place_(p.contacts()), now_(p.contacts()) {}

  /// Moves r towards the solution of the problem with the proximal term, until its residual is
  /// within `accuracy` times |r - centre| or after `steps` linear systems. If a Newton step gains
  /// little, sweeps determine which contacts stick, slide and open. Returns whether it converged.
  template <class GoOn>
  bool solve(contact_vector& r, const contact_vector& centre, real alpha, real accuracy, int steps,
             GoOn&& go_on) {
    begin(alpha);
    real now = residual(r, centre, f_), best = now;
    contact_vector best_r = r;
    const real aim = accuracy * now;
    for (int k = 0, idle = 0; k < steps && idle < 6 && go_on(); ++k) {
      ++steps_;
      const real before = now;
      if (direction(r)) {
        // The first length that gains enough, else the best of all.
        real least = HUGE_VAL, length = 1;
        for (int trial = 0; trial < 8; ++trial, length *= 0.5) {
          trial_ = r;
          trial_.add(length, step_);
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

  /// Full Newton steps, without regard to the residual: if many contacts share a load, the path to
  /// the right set of loaded contacts leads through large residuals. Ends when the residual is
  /// within `accuracy` times |r - centre|, else returns the best of `steps`. Returns whether it
  /// converged.
  bool solve_by_whole_steps(contact_vector& r, const contact_vector& centre, real alpha,
                            real accuracy, int steps) {
    begin(alpha);
    real now = residual(r, centre, f_), best = now;
    contact_vector best_r = r;
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

  /// A contact at the impulses of the last residual: y = r - rho u, and the length of its
  /// tangential part unless the contact is open.
  struct trial_point {
    state is = state::open;
    real rho = 0, tangential = 0;
    vec3 y{0, 0, 0};
  };

  void begin(real alpha) {
    alpha_ = alpha;
    steps_ = 0;
    for (int i = 0; i < p_->contacts(); ++i) now_[i].rho = 3 / (trace(p_->own(i)) + 3 * alpha);
  }
  void look(trial_point& at, real mu, const vec3& r, const vec3& u) const {
    at.y = r - at.rho * u;
    at.is = state::open;
    if (at.y[0] <= 0) return;
    at.tangential = portable::hypot(at.y[1], at.y[2]);
    at.is = mu > 0 && at.tangential <= mu * at.y[0] ? state::sticks : state::slides;
  }

  real residual(const contact_vector& r, const contact_vector& centre, contact_vector& f) {
    p_->velocity(r, u_);
    u_.add(alpha_, r);
    u_.add(-alpha_, centre);
    f.resize(r.contacts());
    for (int i = 0; i < p_->contacts(); ++i) {
      vec3& fi = f(i);
      const vec3 &ri = r(i), &ui = u_(i);
      trial_point& at = now_[i];
      look(at, p_->mu[i], ri, ui);
      switch (at.is) {
        case state::open:
          fi = ri;
          break;
        case state::sticks:
          fi = at.rho * ui;
          break;
        case state::slides: {
          const real t = at.tangential, scale = t > 0 ? p_->mu[i] * at.y[0] / t : 0;
          fi = vec3(at.rho * ui[0], ri[1] - scale * at.y[1], ri[2] - scale * at.y[2]);
        }
      }
    }
    return f.norm();
  }

  /// The Newton step from r, at which residual() was computed last: u_, f_ and now_ belong to it.
  /// Open contacts are eliminated: their step is -r.
  bool direction(const contact_vector& r) {
    const int n = p_->contacts();
    int active = 0;
    step_ = r;
    step_ *= -1;
    for (int i = 0; i < n; ++i) place_[i] = now_[i].is == state::open ? -1 : active++;
    if (active == 0) return true;
    system_.reset(active);
    contact_vector right(active), x;
    for (int i = 0; i < n; ++i) {
      const int row = place_[i];
      if (row < 0) continue;
      // f changes by of_u du + of_r dr
      const trial_point& at = now_[i];
      const vec3& y = at.y;
      mat3 of_u = diagonal_matrix(at.rho), of_r = diagonal_matrix(real{0});
      if (at.is == state::slides) {
        const real t = at.tangential, mu = p_->mu[i];
        const real c = t > 0 ? y[1] / t : 0, s = t > 0 ? y[2] / t : 0;
        const real turn = t > 0 ? mu * y[0] / t : 0;
        const real d[] = {c, s};
        for (int j = 0; j < 2; ++j) {
          of_r(1 + j, 0) = -mu * d[j];
          of_u(1 + j, 0) = at.rho * mu * d[j];
          for (int k = 0; k < 2; ++k) {
            const real across = turn * ((j == k) - d[j] * d[k]);
            of_r(1 + j, 1 + k) = (j == k) - across;
            of_u(1 + j, 1 + k) = at.rho * across;
          }
        }
      }
      vec3 known{0, 0, 0};
      for (auto k = p_->start[i]; k < p_->start[i + 1]; ++k) {
        const int j = p_->column[k];
        if (place_[j] >= 0)
          system_.add(row, place_[j], of_u * p_->block[k]);
        else
          known += p_->block[k] * r(j);
      }
      system_.add(row, row, alpha_ * of_u + of_r);
      right(row) = of_u * known - f_(i);
    }
    if (!system_.factorize() || !system_.solve(right, x)) return false;
    for (int i = 0; i < n; ++i)
      if (place_[i] >= 0) step_(i) = x(place_[i]);
    return true;
  }

  const assembled_problem* p_;
  const assembled_sweeps* sweep_;
  plain_vector<int> place_;  ///< in the linear system, -1 for open contacts
  plain_vector<trial_point> now_;
  System system_;
  real alpha_ = 0;
  int steps_ = 0;
  contact_vector u_, f_, trial_, trial_f_, step_, chosen_;
};

}  // namespace talus::detail
