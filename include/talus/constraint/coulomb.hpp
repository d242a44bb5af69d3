#pragma once
// The Coulomb problem of a single contact, solved exactly.
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Finds the impulse r of one contact with friction coefficient mu >= 0 such that u = W r + b
/// satisfies u_n >= 0, r_n >= 0, u_n r_n = 0, |r_t| <= mu r_n, and u_t = -lambda r_t with lambda >=
/// 0 and lambda (mu r_n - |r_t|) = 0 (component 0 is the normal one). W is positive definite and
/// need not be quite symmetric. If the contact slides, r_t = -(S + lambda)^-1 c with the Schur
/// complement S of W_nn reduces the law to one scalar equation for lambda, which is bracketed and
/// solved by Newton's method; it has a solution whenever the sticking impulse lies outside the
/// cone.
[[nodiscard]] inline vec3 solve_coulomb(const mat3& W, const vec3& b, real mu) {
  if (b[0] >= 0) return {0, 0, 0};
  const real wn = W(0, 0);
  if (mu == 0) return {-b[0] / wn, 0, 0};

  // Eliminate the normal: r_n = -(b_n + w . r_t) / W_nn, (S + lambda) r_t = -c.
  const real w1 = W(0, 1), w2 = W(0, 2), v1 = W(1, 0), v2 = W(2, 0);
  const real s11 = W(1, 1) - v1 * w1 / wn, s22 = W(2, 2) - v2 * w2 / wn,
             s12 = W(1, 2) - v1 * w2 / wn, s21 = W(2, 1) - v2 * w1 / wn;
  const real c1 = b[1] - v1 * b[0] / wn, c2 = b[2] - v2 * b[0] / wn;

  const auto length_of = [](real x, real y) { return std::sqrt(x * x + y * y); };
  struct state {
    real t1, t2, n;
  };
  const auto at = [&](real lambda) {
    const real a = s11 + lambda, d = s22 + lambda, det = a * d - s12 * s21;
    state r{};
    r.t1 = -(d * c1 - s12 * c2) / det;
    r.t2 = -(a * c2 - s21 * c1) / det;
    r.n = -(b[0] + w1 * r.t1 + w2 * r.t2) / wn;
    return r;
  };
  const auto excess = [&](const state& r) { return length_of(r.t1, r.t2) - mu * r.n; };

  state r = at(0);
  if (r.n >= 0 && excess(r) <= 0) return {r.n, r.t1, r.t2};  // sticks

  // For large lambda, r_t = -c / lambda and r_n = -b_n / W_nn.
  real low = 0, high = std::max(s11 + s22, -length_of(c1, c2) * wn / (mu * b[0]));
  while (excess(r = at(high)) > 0 && high < 1e150 * wn) low = high, high *= 4;
  real lambda = high;
  for (int i = 0; i < 60; ++i) {
    const real length = length_of(r.t1, r.t2), g = length - mu * r.n;
    if (std::abs(g) <= 1e-15 * (length + mu * std::abs(r.n))) break;
    (g > 0 ? low : high) = lambda;
    // d r_t / d lambda = -(S + lambda)^-1 r_t
    const real a = s11 + lambda, d = s22 + lambda, det = a * d - s12 * s21;
    const real d1 = -(d * r.t1 - s12 * r.t2) / det, d2 = -(a * r.t2 - s21 * r.t1) / det;
    const real slope =
        (length > 0 ? (r.t1 * d1 + r.t2 * d2) / length : 0) + mu * (w1 * d1 + w2 * d2) / wn;
    real next = lambda - g / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (next == lambda) break;
    lambda = next;
    r = at(lambda);
  }
  // Project the impulse onto the cone to the last relevant bit, by the more precise component.
  const real length = length_of(r.t1, r.t2);
  if (mu > 1) return {length / mu, r.t1, r.t2};
  const real n = std::max(r.n, real{0});
  const real scale = length > mu * n && length > 0 ? mu * n / length : 1;
  return {n, scale * r.t1, scale * r.t2};
}

}  // namespace talus::detail
