#pragma once
// The default solver of assembled contact problems: several methods in turn.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "talus/core/portable_powers.hpp"
#include "talus/solver/direct/assembled.hpp"
#include "talus/solver/direct/assembled_gauss_seidel.hpp"
#include "talus/solver/direct/assembled_interior_point.hpp"
#include "talus/solver/direct/assembled_newton.hpp"
#include "talus/solver/direct/block_system.hpp"
#include "talus/solver/direct/elimination_cost.hpp"

namespace talus::detail {

/// The result of a contact problem.
struct assembled_result {
  /// `error` is within the tolerance, and `velocity_error` within its root or a hundredth.
  bool converged = false;
  real error = 0;           ///< contact_error::scaled of the returned impulses
  real velocity_error = 0;  ///< the same residual over rho max(|q|, |u|)
  int iterations = 0;       ///< sweeps and linear systems together
};

enum class assembled_method { hybrid, gauss_seidel, newton, interior_point };

/// Callable that never requests a stop.
struct always {
  bool operator()() const { return true; }
};

/// The solver of one problem; keeps the best impulses seen, by the error with the full W.
template <class GoOn>
class assembled_solver {
 public:
  /// All by reference; they outlive the solver.
  assembled_solver(const assembled_problem& p, const contact_vector& start, real tolerance,
                   int most, GoOn& go_on)
      : p_(p), tolerance_(tolerance), most_(most), go_on_(go_on), sweep_(p) {
    const contact_vector none(p.contacts());
    best_ = start.contacts() == p.contacts() && start.is_finite() ? start : none;
    result_.error = result_.velocity_error = HUGE_VAL;
    look(best_);
    if (best_.norm() > 0) look(none);
    swept_ = best_;
  }

  void run(assembled_method method) {
    switch (method) {
      case assembled_method::hybrid:
        return hybrid();
      case assembled_method::gauss_seidel:
        while (going()) sweeps(1000, false);
        return;
      case assembled_method::newton:
        for (int round = 0; round < 20 && going(); ++round)
          proximal(1e-3 * mean_, 10 + 5 * round, 6, 15);
        return;
      case assembled_method::interior_point:
        return interior();
    }
  }
  [[nodiscard]] const contact_vector& best() const { return best_; }
  [[nodiscard]] assembled_result result() const {
    assembled_result r = result_;
    r.converged =
        r.error <= tolerance_ && r.velocity_error <= std::max(std::sqrt(tolerance_), real{0.01});
    return r;
  }

 private:
  [[nodiscard]] bool going() const {
    return least_ > tolerance_ && result_.iterations < most_ && go_on_();
  }
  /// The error at r, which is kept if it is the best so far. Impulses that are large (of heavy
  /// bodies on light ones, or unbounded) can hide wrong velocities in the scaled error, so the
  /// velocity error counts separately, against the root of the tolerance.
  real look(const contact_vector& r) {
    p_.velocity(r, u_);
    const real rho = 1 / mean_, residual = natural_residual(p_, r, u_, rho);
    const real velocities = rho * std::max(p_.q.norm(), u_.norm());
    const real scaled = error_ratio(residual, std::max(r.norm(), velocities));
    // Errors below the precision of r count, too.
    const real wrong = error_ratio(residual + 1e-16 * r.norm(), velocities);
    const real e = std::max(scaled, std::sqrt(tolerance_) * wrong);
    if (e < least_) {
      least_ = e;
      result_.error = scaled;
      result_.velocity_error = wrong;
      best_ = r;
    }
    return e;
  }

  void hybrid() {
    if (p_.contacts() <= 100) {  // a linear system costs no more than a few sweeps
      sweeps(5, false);
      proximal(1e-3 * mean_, 4, 1, 5);
      swept_ = best_;
    }
    if (!going()) return;
    sweeps(p_.contacts() > 16 ? 100 : 40, true);
    if (!going()) return;
    // How many sweeps take as long as a linear system, roughly.
    const real work = 20 * p_.contacts() + static_cast<real>(p_.block.size());  // of a sweep
    const real elimination = p_.contacts() > 100 ? elimination_cost(p_) : 0;
    const real exchange = std::clamp(elimination / (12 * work), real{10}, real{1e6});
    const bool affordable = elimination < 3e11;
    sweeps(static_cast<int>(30 * exchange), true);
    if (affordable) {
      proximal(1e-3 * mean_, 4, 1, 10);
      if (least_ < 1e-3) {  // near the solution: another try costs less than a restart
        swept_ = best_;
        sweeps(60, true);
        proximal(1e-2 * mean_, 4, 2, 10);
      }
      interior();
      proximal(1e-3 * std::min(real{1}, least_) * mean_, 6, 6, 15);
    }
    for (int round = 1; going(); ++round) {
      const int longer = std::min(round, 11);
      if (least_ < 0.1 * look(swept_)) swept_ = best_;
      sweeps(static_cast<int>(std::min(std::ldexp(3 * exchange, longer), 1e9)), false);
      if (affordable)
        proximal(portable::pow(real{10}, -3 - round / 11 % 4) * mean_, 10 + 5 * longer, 6, 15);
    }
  }

  /// Sweeps; if they are to pay, only while fewer than `count` more are expected to suffice,
  /// extrapolated from the later half of those done.
  void sweeps(int count, bool to_pay) {
    real then = look(swept_);
    int before = 0;
    for (int done = 0, burst = 1; done < (to_pay ? 3 * count : count) && going();
         burst = std::min(burst + 1, std::max(5, done / 20))) {
      for (int k = 0; k < burst; ++k) sweep_(swept_, (result_.iterations++ & 1) != 0);
      done += burst;
      const real e = look(swept_);
      if (to_pay && done >= std::max(10, count / 10)) {
        const real rate = portable::log(e / then) / (done - before);  // of the logarithm, per sweep
        if (!(rate < 0 && portable::log(tolerance_ / e) / rate < count)) break;
      }
      if (done >= 2 * before) {
        before = done;
        then = e;
      }
    }
  }

  /// Newton's method with a proximal term, which shrinks while that works.
  void proximal(real alpha, int patience, int most_lost, int steps) {
    if (!newton_) newton_.emplace(p_, sweep_);
    contact_vector x = best_;
    real mark = least_;
    for (int lost = 0, since = 0; going() && lost < most_lost && since < patience; ++since) {
      const contact_vector centre = x;
      const bool solved = newton_->solve(x, centre, alpha, 0.1, steps, go_on_);
      result_.iterations += newton_->steps();
      const real e = look(x);
      if (solved) {
        alpha = std::max(alpha * (newton_->steps() < 5 ? 0.1 : 0.5), 1e-12 * mean_);
        lost = 0;
      } else {
        alpha = std::min(5 * alpha, 1e3 * mean_);
        ++lost;
        if (e > 2 * least_) x = best_;
      }
      if (least_ < 0.5 * mark) {
        mark = least_;
        since = 0;
      }
    }
  }

  /// The interior-point method until it stalls; a sweep after each step determines the open
  /// contacts.
  void interior() {
    if (!going()) return;
    assembled_interior_point method(p_);
    real mark = HUGE_VAL;
    for (int k = 0, since = 0; k < 80 && since < 8 && going() && method.step(); ++k, ++since) {
      ++result_.iterations;
      contact_vector x = method.impulses();
      real e = look(x);
      sweep_(x);
      e = std::min(e, look(x));
      if (e < 0.8 * mark || (k < 20 && method.length() > 0.3)) {
        mark = std::min(e, mark);
        since = 0;
      }
    }
  }

  const assembled_problem& p_;
  const real tolerance_;
  const int most_;
  GoOn& go_on_;
  assembled_sweeps sweep_;
  std::optional<assembled_newton<block_system>> newton_;
  const real mean_ = p_.mean_diagonal();
  contact_vector u_, best_, swept_;
  real least_ = HUGE_VAL;  ///< measure of best_: within the tolerance if all is well
  assembled_result result_;
};

/// Solves p from the warm start r (which may lie outside of its cones; zeros are allowed), to
/// `tolerance` in contact_error::scaled. Ends after about `most` sweeps and linear systems, or soon
/// after `go_on()` returns false; then r is the best seen, and the result reports that it has not
/// converged. The default: a few steps of Newton's method for few contacts, sweeps while they pay,
/// Newton's method with a proximal term, the interior-point method, and Newton's method from its
/// result; then sweeps and Newton's method in turn, while it may continue.
template <class GoOn = always>
assembled_result solve_assembled(const assembled_problem& p, contact_vector& r, real tolerance,
                                 int most = 2000, GoOn&& go_on = {},
                                 assembled_method method = assembled_method::hybrid) {
  assembled_solver solver(p, r, tolerance, most, go_on);
  solver.run(method);
  r = solver.best();
  return solver.result();
}

}  // namespace talus::detail
