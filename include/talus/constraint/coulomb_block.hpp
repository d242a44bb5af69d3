#pragma once
// A contact's own block of the Delassus operator, prepared for many solutions of Coulomb's law.
#include <cmath>

#include "talus/constraint/coulomb.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// The symmetric block W in the frame (normal, tangent, tangent), and its inverse: most contacts
/// stick or are open, and need only a product.
struct coulomb_block {
  real nn = 0, n1 = 0, n2 = 0, t11 = 0, t12 = 0, t22 = 0;           ///< W
  real i_nn = 0, i_n1 = 0, i_n2 = 0, i_11 = 0, i_12 = 0, i_22 = 0;  ///< its inverse
  real inverse_nn = 0;                                              ///< 1 / nn

  /// From the components of W, which is positive definite.
  void set(real wnn, real wn1, real wn2, real w11, real w12, real w22) {
    nn = wnn, n1 = wn1, n2 = wn2, t11 = w11, t12 = w12, t22 = w22;
    const real a = w11 * w22 - w12 * w12, b = wn2 * w12 - wn1 * w22, c = wn1 * w12 - wn2 * w11;
    const real scale = 1 / (wnn * a + wn1 * b + wn2 * c);
    i_nn = scale * a, i_n1 = scale * b, i_n2 = scale * c;
    i_11 = scale * (wnn * w22 - wn2 * wn2);
    i_12 = scale * (wn1 * wn2 - wnn * w12);
    i_22 = scale * (wnn * w11 - wn1 * wn1);
    inverse_nn = 1 / wnn;
  }
  void set(const mat3& w) {
    set(w(0, 0), (w(0, 1) + w(1, 0)) / 2, (w(0, 2) + w(2, 0)) / 2, w(1, 1), (w(1, 2) + w(2, 1)) / 2,
        w(2, 2));
  }
  [[nodiscard]] vec3 times(const vec3& r) const {
    return {nn * r[0] + n1 * r[1] + n2 * r[2], n1 * r[0] + t11 * r[1] + t12 * r[2],
            n2 * r[0] + t12 * r[1] + t22 * r[2]};
  }

  /// The impulse that satisfies Coulomb's law (see solve_coulomb), if the impulse `r` leaves the
  /// velocity `u`, relative to the target velocity of separation.
  [[nodiscard]] vec3 solve(const vec3& r, const vec3& u, real mu) const {
    const real n = r[0] - (i_nn * u[0] + i_n1 * u[1] + i_n2 * u[2]),
               x = r[1] - (i_n1 * u[0] + i_11 * u[1] + i_12 * u[2]),
               y = r[2] - (i_n2 * u[0] + i_12 * u[1] + i_22 * u[2]);
    const real limit = mu * n;
    if (n >= 0 && x * x + y * y <= limit * limit) [[likely]]
      return {n, x, y};  // sticks
    const real un = u[0] - (nn * r[0] + n1 * r[1] + n2 * r[2]);
    if (un >= 0) return {0, 0, 0};  // opens
    return slide(r, u, un, mu);
  }

  /// The same for a contact known to slide; uses W and inverse_nn alone. `un` is the normal
  /// velocity without the impulse. Eliminating the normal leaves the law as (S + lambda) r_t = -c
  /// with the Schur complement S, and mu r_n / |r_t| = 1, which is nearly linear in lambda:
  /// Newton's method starts from the previous lambda, and mostly takes a step or two. If it
  /// diverges, the general solution is used.
  [[nodiscard]] [[gnu::noinline]] vec3 slide(const vec3& r, const vec3& u, real un, real mu) const {
    const real inverse = inverse_nn;
    if (mu == 0) return {-un * inverse, 0, 0};
    const real w1 = n1 * inverse, w2 = n2 * inverse;
    const real s11 = t11 - n1 * w1, s12 = t12 - n1 * w2, s22 = t22 - n2 * w2;
    const real b1 = u[1] - (n1 * r[0] + t11 * r[1] + t12 * r[2]),
               b2 = u[2] - (n2 * r[0] + t12 * r[1] + t22 * r[2]);
    const real c1 = b1 - w1 * un, c2 = b2 - w2 * un, free = -un * inverse;

    const real before = r[1] * r[1] + r[2] * r[2];
    real lambda = before > 0 ? -(u[1] * r[1] + u[2] * r[2]) / before : 0;
    if (!(lambda > 0)) {  // as if it slid along -c
      const real length = std::sqrt(c1 * c1 + c2 * c2), x = -c1 / length, y = -c2 / length;
      const real n = free / (1 + mu * (w1 * x + w2 * y));
      lambda = length / (mu * n) - (s11 * x * x + 2 * s12 * x * y + s22 * y * y);
      if (!(lambda > 0)) lambda = 0;
    }
    bool last = false;
    for (int k = 0; k < 12; ++k) {
      const real p = s11 + lambda, q = s22 + lambda, scale = 1 / (p * q - s12 * s12);
      const real x = scale * (s12 * c2 - q * c1), y = scale * (s12 * c1 - p * c2);
      const real n = free - w1 * x - w2 * y, square = x * x + y * y;
      const real ratio = mu / std::sqrt(square), miss = ratio * n - 1;
      if (last || std::abs(miss) < 1e-14) {
        if (!(n >= 0) || !(std::abs(miss) < 1e-9)) break;
        const real fit = ratio * n;  // on the cone to the last relevant bit
        if (mu > 1) return {n / fit, x, y};
        return {n, fit * x, fit * y};
      }
      const real dx = scale * (s12 * y - q * x), dy = scale * (s12 * x - p * y);
      const real dn = -w1 * dx - w2 * dy;
      const real slope = ratio * (dn - n * (x * dx + y * dy) / square);
      const real next = lambda - miss / slope;
      if (!(slope > 0) || !(next >= 0)) break;
      last = std::abs(miss) < 1e-6;
      lambda = next;
    }
    return solve_coulomb(mat3(nn, n1, n2, n1, t11, t12, n2, t12, t22), {un, b1, b2}, mu);
  }
};

}  // namespace talus::detail
