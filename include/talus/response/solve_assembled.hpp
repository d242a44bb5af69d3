#pragma once
// The default solver of assembled contact problems: several methods in turn.
#include <limits>

#include "talus/response/assembled.hpp"
#include "talus/response/assembled_gauss_seidel.hpp"
#include "talus/response/assembled_interior_point.hpp"
#include "talus/response/assembled_newton.hpp"
#include "talus/response/block_system.hpp"

namespace talus::detail {

/// What became of a contact problem.
struct assembled_result {
  bool converged = false;  ///< the error of what is handed back is within the tolerance
  real error = 0;          ///< contact_error::scaled of what is handed back
  int iterations = 0;      ///< sweeps and Newton steps together
};

struct always {
  bool operator()() const { return true; }
};

/// Solves p from the warm start r (cones need not hold; zeros are fine), to `tolerance` in
/// contact_error::scaled. Ends after `max_iterations` sweeps or linear systems, or when `go_on()`
/// says no; then r is the best that was seen, and the result says that it has not converged.
template <class GoOn = always>
assembled_result solve_assembled(const assembled_problem& p, vecx& r, real tolerance,
                                 int max_iterations = 2000, GoOn&& go_on = {}) {
  const int n = p.contacts();
  if (r.size() != 3 * n || !r.allFinite()) r = vecx::Zero(3 * n);
  const real mean = p.mean_diagonal(), rho = 1 / mean;
  vecx u, best = r;
  assembled_result result;
  result.error = HUGE_VAL;
  const auto look = [&](const vecx& at) {
    p.velocity(at, u);
    const real e = scaled_error(p, at, u, rho);
    if (e < result.error) result.error = e, best = at;
    return e;
  };
  const auto go = [&] {
    return result.error > tolerance && result.iterations < max_iterations && go_on();
  };

  look(r);
  if (r.squaredNorm() > 0) look(vecx::Zero(3 * n));
  const assembled_sweeps sweep(p);
  assembled_newton<block_system> newton(p, sweep);
  vecx swept = best, x, centre;

  const auto sweeps = [&](int count, real least) {
    real last = HUGE_VAL;
    for (int k = 0; k < count && go(); k += 5) {
      for (int j = 0; j < 5; ++j) sweep(swept, (result.iterations++ & 1) != 0);
      const real e = look(swept);
      if (e > least * last) break;
      last = e;
    }
  };
  // Newton's method with a proximal term that shrinks while it works.
  const auto proximal = [&](real alpha, int patience) {
    x = best;
    real mark = result.error;
    for (int lost = 0, since = 0; go() && lost < 6 && since < patience; ++since) {
      centre = x;
      const bool solved = newton.solve(x, centre, alpha, 0.1, 15, go_on);
      result.iterations += newton.steps();
      const real e = look(x);
      if (solved) {
        alpha = std::max(alpha * (newton.steps() < 5 ? 0.1 : 0.5), 1e-12 * mean);
        lost = 0;
      } else {
        alpha = std::min(5 * alpha, 1e3 * mean);
        ++lost;
        if (e > 2 * result.error) x = best;
      }
      if (result.error < 0.5 * mark) mark = result.error, since = 0;
    }
  };
  const auto interior = [&] {
    assembled_interior_point method(p);
    real mark = HUGE_VAL;
    for (int k = 0, since = 0; k < 80 && since < 8 && go() && method.step(); ++k, ++since) {
      ++result.iterations;
      x = method.impulses();
      real e = look(x);
      sweep(x);
      e = std::min(e, look(x));
      if (e < 0.8 * mark || (k < 20 && method.length() > 0.3)) mark = std::min(e, mark), since = 0;
    }
  };

  sweeps(30, 0.9);
  proximal(1e-3 * mean, 4);
  interior();
  proximal(1e-3 * std::min(real{1}, result.error) * mean, 6);
  for (int round = 1; go() && round < 10; ++round) {
    if (result.error < 0.1 * look(swept)) swept = best;
    sweeps(30 << round, 1);
    proximal(1e-3 * mean, 10 + 5 * round);
  }
  r = best;
  result.converged = result.error <= tolerance;
  return result;
}

}  // namespace talus::detail
