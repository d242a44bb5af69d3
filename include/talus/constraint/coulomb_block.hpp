#pragma once
// The own blocks of contacts in the Delassus operator, prepared for many solutions of Coulomb's
// law.
#include <bit>
#include <cmath>
#include <cstddef>

#include "talus/constraint/coulomb.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"

namespace talus::detail {

// All functions that take packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// The symmetric block W in the frame (normal, tangent, tangent), and its inverse: most contacts
/// stick or are open, and need only a product. One block, or one for each lane. What the solution
/// of a sliding contact alone reads comes last.
template <class Pack>
struct coulomb_blocks {
  using vectors = pack_vector<Pack>;
  using mask = mask_of<Pack>;

  Pack i_nn{}, i_n1{}, i_n2{}, i_11{}, i_12{}, i_22{};  ///< the inverse of W
  Pack nn{}, n1{}, n2{};                                ///< W, with those below
  Pack inverse_nn{};                                    ///< 1 / nn
  Pack t11{}, t12{}, t22{};

  /// From the components of W, which is positive definite.
  [[gnu::always_inline]] void set(const Pack& wnn, const Pack& wn1, const Pack& wn2,
                                  const Pack& w11, const Pack& w12, const Pack& w22) {
    nn = wnn, n1 = wn1, n2 = wn2, t11 = w11, t12 = w12, t22 = w22;
    const Pack a = w11 * w22 - w12 * w12, b = wn2 * w12 - wn1 * w22, c = wn1 * w12 - wn2 * w11;
    const Pack scale = 1 / (wnn * a + wn1 * b + wn2 * c);
    i_nn = scale * a, i_n1 = scale * b, i_n2 = scale * c;
    i_11 = scale * (wnn * w22 - wn2 * wn2);
    i_12 = scale * (wn1 * wn2 - wnn * w12);
    i_22 = scale * (wnn * w11 - wn1 * wn1);
    inverse_nn = 1 / wnn;
  }

  /// The impulses that satisfy Coulomb's law (see solve_coulomb), if the impulses `r` leave the
  /// velocities `u`, relative to the target velocities of separation; 0 in lanes that are not
  /// `present`.
  [[nodiscard]] [[gnu::always_inline]] vectors solve(const vectors& r, const vectors& u,
                                                     const Pack& mu, const mask& present) const {
    const Pack zero = every_lane<Pack>(0);
    const Pack n = r.x - (i_nn * u.x + i_n1 * u.y + i_n2 * u.z),
               x = r.y - (i_n1 * u.x + i_11 * u.y + i_12 * u.z),
               y = r.z - (i_n2 * u.x + i_12 * u.y + i_22 * u.z);
    const Pack limit = mu * n;
    const mask within = x * x + y * y <= limit * limit, pushes = n >= zero;
    const mask sticks = both(both(pushes, within), present);
    const Pack un = u.x - (nn * r.x + n1 * r.y + n2 * r.z);
    const mask opens = un >= zero;
    const mask slides = both(both(inverted(sticks), inverted(opens)), present);
    vectors next{sticks ? n : zero, sticks ? x : zero, sticks ? y : zero};
    if (const unsigned all = bits_of(slides); std::popcount(all) >= few) {
      const vectors found = slide(r, u, un, mu, slides);
      next = {choose(slides, found.x, next.x), choose(slides, found.y, next.y),
              choose(slides, found.z, next.z)};
    } else {
      for (unsigned left = all; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(left));
        put_lane(next, i, sliding_lane(i).slide(lane(r, i), lane(u, i), lane(un, i), lane(mu, i)));
      }
    }
    // Where friction is large, the law may hold with several impulses: a load on its cone stays.
    const mask held = both(both(inverted(sticks), present), both(pushes, r.x > zero));
    for (unsigned left = bits_of(held); left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      put_lane(next, i,
               nearer_on_cone(lane(r, i), {lane(n, i), lane(x, i), lane(y, i)}, lane(next, i),
                              lane(mu, i)));
    }
    return next;
  }

  /// The solutions for contacts known to slide, in the lanes `slides`; uses W and inverse_nn alone.
  /// `un` is the normal velocity without the impulse. Eliminating the normal leaves the law as (S +
  /// lambda) r_t = -c with the Schur complement S, and mu r_n / |r_t| = 1, which is nearly linear
  /// in lambda: Newton's method starts from the previous lambda, and mostly takes a step or two. If
  /// it diverges, the general solution is used.
  [[nodiscard]] [[gnu::noinline]] vectors slide(const vectors& r, const vectors& u, const Pack& un,
                                                const Pack& mu, const mask& slides) const {
    const Pack zero = every_lane<Pack>(0), inverse = inverse_nn;
    const Pack w1 = n1 * inverse, w2 = n2 * inverse;
    const Pack s11 = t11 - n1 * w1, s12 = t12 - n1 * w2, s22 = t22 - n2 * w2;
    const Pack b1 = u.y - (n1 * r.x + t11 * r.y + t12 * r.z),
               b2 = u.z - (n2 * r.x + t12 * r.y + t22 * r.z);
    const Pack c1 = b1 - w1 * un, c2 = b2 - w2 * un, free = -un * inverse;

    const Pack before = r.y * r.y + r.z * r.z;
    Pack lambda = choose(before > zero, -(u.y * r.y + u.z * r.z) / before, zero);
    if (const mask begins = inverted(lambda > zero); any_lane(both(begins, slides))) {
      const Pack length = square_root(c1 * c1 + c2 * c2);  // as if it slid along -c
      const Pack x = -c1 / length, y = -c2 / length;
      const Pack n = free / (1 + mu * (w1 * x + w2 * y));
      const Pack from = length / (mu * n) - (s11 * x * x + 2 * s12 * x * y + s22 * y * y);
      lambda = choose(begins, choose(from > zero, from, zero), lambda);
    }
    const auto within = [&](const Pack& x, real most) __attribute__((always_inline)) {
      return both(x<every_lane<Pack>(most), x> every_lane<Pack>(-most));
    };
    const mask rough = inverted(mu == zero);
    vectors found{choose(both(slides, inverted(rough)), free, zero), zero, zero};
    mask left = both(slides, rough), lost{}, last{};
    for (int k = 0; k < 12; ++k) {
      const Pack p = s11 + lambda, q = s22 + lambda, scale = 1 / (p * q - s12 * s12);
      const Pack x = scale * (s12 * c2 - q * c1), y = scale * (s12 * c1 - p * c2);
      const Pack n = free - w1 * x - w2 * y, square = x * x + y * y;
      const Pack ratio = mu / square_root(square), miss = ratio * n - 1;
      if (const mask ends = both(left, either(last, within(miss, 1e-14))); any_lane(ends)) {
        const mask holds = both(ends, both(n >= zero, within(miss, 1e-9)));
        const Pack fit = ratio * n;  // on the cone to the last relevant bit
        const mask steep = mu > every_lane<Pack>(1);
        found.x = choose(holds, choose(steep, n / fit, n), found.x);
        found.y = choose(holds, choose(steep, x, fit * x), found.y);
        found.z = choose(holds, choose(steep, y, fit * y), found.z);
        lost = either(lost, both(ends, inverted(holds))), left = both(left, inverted(ends));
      }
      if (!any_lane(left)) break;
      const Pack dx = scale * (s12 * y - q * x), dy = scale * (s12 * x - p * y);
      const Pack dn = -w1 * dx - w2 * dy;
      const Pack slope = ratio * (dn - n * (x * dx + y * dy) / square);
      const Pack next = lambda - miss / slope;
      const mask goes_on = both(slope > zero, next >= zero);
      lost = either(lost, both(left, inverted(goes_on))), left = both(left, goes_on);
      last = within(miss, 1e-6);
      lambda = next;
    }
    for (unsigned all = bits_of(either(lost, left)); all != 0; all &= all - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(all));
      const auto of = [&](const Pack& x) { return lane(x, i); };
      const mat3 w(of(nn), of(n1), of(n2), of(n1), of(t11), of(t12), of(n2), of(t12), of(t22));
      put_lane(found, i, solve_coulomb(w, {of(un), of(b1), of(b2)}, of(mu)));
    }
    return found;
  }

 private:
  /// Contacts that slide are solved one by one if they are fewer: a block of eight takes the time
  /// of one or two in the widest registers.
#if defined(__AVX512F__)
  static constexpr int few = 2;
#else
  static constexpr int few = 3;
#endif

  /// The impulse at which a contact would stick, moved onto its cone, if the law holds with both it
  /// and the impulse `r` to a small relative error, and `found` is another solution; else `found`.
  [[nodiscard]] static vec3 nearer_on_cone(const vec3& r, const vec3& sticking, const vec3& found,
                                           real mu) {
    constexpr real small = 1e-8, apart = 1e-3;
    const real square = r.squaredNorm();
    if ((found - r).squaredNorm() <= apart * apart * square ||
        !((sticking - r).squaredNorm() <= small * small * square))
      return found;
    const real length = std::sqrt(sticking[1] * sticking[1] + sticking[2] * sticking[2]);
    const real limit = mu * sticking[0];
    if (!(length <= (1 + small) * limit)) return found;
    const real fit = limit / length;
    return {sticking[0], fit * sticking[1], fit * sticking[2]};
  }
  /// Copies the coefficients that slide() uses from lane `l`.
  [[nodiscard]] [[gnu::always_inline]] auto sliding_lane(std::size_t l) const;
};

/// One block.
struct coulomb_block : coulomb_blocks<real> {
  using coulomb_blocks<real>::set;
  void set(const mat3& w) {
    set(w(0, 0), (w(0, 1) + w(1, 0)) / 2, (w(0, 2) + w(2, 0)) / 2, w(1, 1), (w(1, 2) + w(2, 1)) / 2,
        w(2, 2));
  }
  [[nodiscard]] vec3 solve(const vec3& r, const vec3& u, real mu) const {
    return lane(coulomb_blocks::solve({r[0], r[1], r[2]}, {u[0], u[1], u[2]}, mu, true), 0);
  }

  [[nodiscard]] vec3 slide(const vec3& r, const vec3& u, real un, real mu) const {
    return lane(coulomb_blocks::slide({r[0], r[1], r[2]}, {u[0], u[1], u[2]}, un, mu, true), 0);
  }
};

template <class Pack>
inline auto coulomb_blocks<Pack>::sliding_lane(std::size_t l) const {
  coulomb_block one;
  one.nn = lane(nn, l), one.n1 = lane(n1, l), one.n2 = lane(n2, l);
  one.t11 = lane(t11, l), one.t12 = lane(t12, l), one.t22 = lane(t22, l);
  one.inverse_nn = lane(inverse_nn, l);
  return one;
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
