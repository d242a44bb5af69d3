#pragma once
// The default solver of assembled contact problems: several methods in turn.
#include <limits>

#include "talus/response/assembled.hpp"
#include "talus/response/assembled_gauss_seidel.hpp"
#include "talus/response/assembled_newton.hpp"

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
  vecx u, best = r, x = r;
  assembled_result result;
  result.error = HUGE_VAL;
  const auto look = [&](const vecx& at) {
    p.velocity(at, u);
    const real e = scaled_error(p, at, u, rho);
    if (e < result.error) result.error = e, best = at;
    return e;
  };
  const auto done = [&] {
    return result.error <= tolerance || result.iterations >= max_iterations || !go_on();
  };

  look(x);
  if (x.squaredNorm() > 0) look(vecx::Zero(3 * n));
  x = best;
  const assembled_sweeps sweep(p);
  // Sweeps as long as they pay: cheap, and the best start for Newton's method.
  const auto sweeps = [&](int count, real least) {
    real last = look(x);
    for (int k = 0; k < count && !done(); k += 5) {
      for (int j = 0; j < 5; ++j) sweep(x, (result.iterations++ & 1) != 0);
      const real e = look(x);
      if (e > least * last) break;
      last = e;
    }
  };
  sweeps(30, 0.9);

  assembled_newton newton(p);
  real alpha = 1e-3 * mean;
  vecx centre;
  for (int failures = 0; !done() && failures < 30;) {
    x = centre = best;
    const real before = result.error;
    const real inner = newton.solve(x, centre, alpha, 0.05, 12);
    result.iterations += newton.steps();
    real e = look(x);
    if (e > tolerance) {
      for (int j = 0; j < 2; ++j) sweep(x, j != 0);
      e = std::min(e, look(x));
    }
    if (e < 0.5 * before && inner < 0.1) {
      alpha = std::max(0.1 * alpha, 1e-12 * mean);
    } else if (e < 0.9 * before) {
      alpha = std::max(0.5 * alpha, 1e-12 * mean);
    } else {
      ++failures;
      alpha *= 10;
      if (alpha > 100 * mean) alpha = 1e-4 * mean;
      x = best;
      sweeps(20, 0.99);
    }
  }
  r = best;
  result.converged = result.error <= tolerance;
  return result;
}

}  // namespace talus::detail
