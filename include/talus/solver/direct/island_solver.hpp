#pragma once
// Solves an island to round-off by Newton's method, or as far as possible.
#include <algorithm>

#include "talus/solver/direct/assembled.hpp"
#include "talus/solver/direct/assembled_gauss_seidel.hpp"
#include "talus/solver/direct/assembled_newton.hpp"
#include "talus/solver/direct/band_system.hpp"

namespace talus::detail {

/// Improves the impulses r of `p`, never increasing their error, with at most `most_systems` linear
/// systems; returns how many it took. Some problems have no solution (a sphere that is to rebound
/// from both sides of a corner whose friction holds it), and their error falls slightly as the
/// impulses grow: such impulses are rejected. Proximal points, each found by full Newton steps: one
/// is enough if the loaded contacts are known. The proximal term starts at a value that settles
/// degenerate choices (which three feet of a box carry it?), and shrinks until weak directions (a
/// heavy body on light ones) are solved too.
inline int solve_island(const assembled_problem& p, contact_vector& r, int most_systems) {
  const real mean = p.mean_diagonal(), rho = 1 / mean;
  contact_vector u;
  const auto error = [&](const contact_vector& at) {
    p.velocity(at, u);
    return natural_residual(p, at, u, rho);
  };
  contact_vector best = r, x;
  const real first = error(r);
  real least = first;
  const real enough = 1e-14 * r.norm() + 1e-11 * rho * p.q.norm();
  const assembled_sweeps sweep(p);
  assembled_newton<band_system> newton(p, sweep);
  real alpha = 1e-5 * mean;
  int systems = 0;
  for (int lost = 0; least > enough && lost < 3 && systems < most_systems;) {
    const real before = least;
    x = best;
    const contact_vector centre = best;
    const bool there = newton.solve_by_whole_steps(x, centre, alpha, 0.1 * alpha * rho,
                                                   std::min(8, most_systems - systems));
    systems += newton.steps();
    if (const real e = error(x); e < least) least = e, best = x;
    if (least < 0.5 * before)
      lost = 0;
    else if (!there || alpha <= 1e-9 * mean)
      ++lost;
    if (there) {
      alpha = std::max(0.1 * alpha, 1e-10 * mean);
    } else {
      alpha = std::min(30 * alpha, mean);
      x = best;
      for (int k = 0; k < 6; ++k) sweep(x, k % 2 == 1);
      if (const real e = error(x); e < least) least = e, best = x;
    }
  }
  const bool solved = least <= 0.01 * first;
  if (solved || best.norm() <= 10 * (r.norm() + rho * p.q.norm())) r = best;
  return systems;
}

/// Solves `p` from zero impulses, so that equal problems give equal bits; false, with an arbitrary
/// r, if the remaining error is too large.
[[nodiscard]] inline bool solve_island_anew(const assembled_problem& p, contact_vector& r,
                                            int most_systems) {
  r.set_zero(p.contacts());
  const assembled_sweeps sweep(p);
  for (int k = 0; k < 10; ++k) sweep(r, k % 2 == 1);
  solve_island(p, r, most_systems);
  contact_vector u;
  p.velocity(r, u);
  const real rho = 1 / p.mean_diagonal(), free = rho * p.q.norm();
  const real error = natural_residual(p, r, u, rho);
  return error <= 1e-6 * std::max(free, r.norm()) && error <= 0.01 * free;
}

}  // namespace talus::detail
