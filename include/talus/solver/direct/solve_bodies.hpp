#pragma once
// Solves a wide island by its bodies.
#include <algorithm>

#include "talus/solver/direct/body_newton.hpp"
#include "talus/solver/direct/body_problem.hpp"

namespace talus::detail {

/// The result of an island.
struct island_outcome {
  real before = 0, after = 0;  ///< its error: the natural residual
  bool solved = false;         ///< to a hundredth of the error, or to round-off
  bool too_dear = false;       ///< the budget ended it
};

/// Improves the impulses r of `p`, never increasing their error, as solve_island() does with an
/// assembled problem: proximal points, each found by full Newton steps. `budget` are the available
/// floating-point operations; decreases by those used.
inline island_outcome solve_by_bodies(const body_problem& p, contact_vector& r, double& budget) {
  const real mean = p.mean_diagonal(), rho = 1 / mean;
  contact_vector u;
  const auto error = [&](const contact_vector& at) {
    p.velocity(at, u);
    return p.residual(at, u, rho);
  };
  contact_vector best = r, x;
  island_outcome result;
  real least = result.before = error(r);
  const real enough = 1e-14 * r.norm() + 1e-10 * rho * p.q().norm();
  if (least <= 10 * enough) {
    result.after = least;
    result.solved = true;
    return result;
  }
  body_newton newton(p, budget);
  real alpha = 1e-5 * mean;
  for (int lost = 0; least > enough && lost < 3 && !newton.too_dear();) {
    const real before = least;
    x = best;
    const contact_vector centre = best;
    const bool there = newton.solve(x, centre, alpha, 0.1 * alpha * rho, 0.1 * enough, 8);
    for (int k = 0; k < 2 && newton.keeps_weak(); ++k) p.sweep(x, k % 2 == 1);
    const real e = error(x);
    if (e < least) least = e, best = x;
    if (least < 0.5 * before)
      lost = 0;
    else if (!there || alpha <= 1e-9 * mean)
      ++lost;
    if (there) {
      alpha = std::max(0.01 * alpha, 1e-9 * mean);
    } else {
      alpha = std::min(30 * alpha, mean);
      x = best;
      for (int k = 0; k < 6; ++k) p.sweep(x, k % 2 == 1);
      if (const real at = error(x); at < least) least = at, best = x;
    }
  }
  result.solved = least <= std::max(enough, 0.01 * result.before);
  result.too_dear = newton.too_dear();
  // A partial solution must not add energy to the result of the sweeps.
  const auto work = [&](const contact_vector& at) {
    p.velocity(at, u);
    return at.dot(u) + at.dot(p.q());
  };
  if (result.solved || work(best) <= work(r)) {
    r = best;
    result.after = least;
  } else {
    result.after = result.before;
  }
  return result;
}

/// Solves `p` from zero impulses, so that equal problems give equal bits, with at most so many
/// operations; false, with arbitrary r, if the remaining error is too large.
[[nodiscard]] inline bool solve_by_bodies_anew(const body_problem& p, contact_vector& r,
                                               double operations) {
  r.set_zero(p.contacts_count());
  for (int k = 0; k < 10; ++k) p.sweep(r, k % 2 == 1);
  const island_outcome found = solve_by_bodies(p, r, operations);
  const real free = p.q().norm() / p.mean_diagonal();
  return found.after <= 1e-6 * std::max(free, r.norm()) && found.after <= 0.01 * free;
}

}  // namespace talus::detail
