#pragma once
// Free rotation of eight bodies at once, to the bit of single ones.
#include <array>
#include <cstddef>

#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/motion/free_rotation.hpp"
#include "talus/motion/integrate.hpp"

namespace talus::detail {

// All functions that take packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// A body that rotates freely, and then by a rotation vector. In this order, because vectors are
/// read together with the number that follows them.
template <class Real>
struct rotating_body {
  vector3<Real> w{0, 0, 0};  ///< angular velocity in the world frame
  Real unused_w = 0;
  vector3<Real> inertia{1, 1, 1};  ///< principal moments
  Real unused_inertia = 0;
  vector3<Real> turn{0, 0, 0};  ///< rotation vector in the world frame
  Real unused_turn = 0;
  quaternion<Real> q{1, 0, 0, 0};

  /// rotate_freely() and turned().
  void rotate(Real dt) {
    w = rotate_freely(q, w, inertia, dt);
    q = turned(q, turn);
  }
};

/// Up to eight bodies. Those that rotate slowly, so that rotate_freely() takes one step of second
/// order and the angles are small, are rotated side by side, and the others one by one.
template <class Real>
class rotating_bodies {
  using number = pack<Real, 8>;
  using mask = mask_of<number>;
  using vectors = pack_vector<number>;
  struct quaternions {
    number x, y, z, w;
  };
  struct small_angle {
    number cosine, sine;

    /// half_angle for small angles; `small` keeps the lanes in which they are.
    [[gnu::always_inline]] small_angle(const number& angle, mask& small) {
      const number x = angle / 2, y = x * x;
      small &= y < 0.01;
      cosine = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90))));
      sine = x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72))));
    }
  };

 public:
  static constexpr std::size_t capacity = 8;

  [[nodiscard]] rotating_body<Real>& operator[](std::size_t k) { return bodies_[k]; }

  /// Rotates the first `count` bodies over `dt`.
  void rotate(std::size_t count, Real dt) {
    const auto rows = [&](auto part) __attribute__((always_inline)) {
      return gather<number>([&](int k) __attribute__((always_inline)) {
        auto& body = bodies_[static_cast<std::size_t>(k)];
        return row_from<Real>(body, body.*part);
      });
    };
    const auto coefficients = rows(&rotating_body<Real>::q);
    const quaternions start{coefficients.x, coefficients.y, coefficients.z, coefficients.w};
    const vectors w = vectors_in(rows(&rotating_body<Real>::w)),
                  inertia = vectors_in(rows(&rotating_body<Real>::inertia)),
                  turn = vectors_in(rows(&rotating_body<Real>::turn));

    const vectors own = scaled(inertia, rotated(conjugate(start), w));
    const vectors momentum = rotated(start, own);
    const number length = square_root(dot(momentum, momentum)), zero{};
    mask slow = length > zero;
    const vectors p{1 / inertia.x, 1 / inertia.y, 1 / inertia.z};
    const sorted_moments of(p);
    slow &= length * dt * square_root((of.high - of.middle) * (of.middle - of.low)) < 1e-4;

    quaternions q = start;
    about_low_and_high(q, own, of, dt, slow);
    const small_angle h(length * dt * of.middle, slow);
    const number part = h.sine / length;
    q = normalized(product({part * momentum.x, part * momentum.y, part * momentum.z, h.cosine}, q));
    const vectors spin = rotated(q, scaled(rotated(conjugate(q), momentum), p));

    const number way = square_root(dot(turn, turn));
    const small_angle half(way, slow);
    const number by = half.sine / way;
    const quaternions next =
        normalized(product({by * turn.x, by * turn.y, by * turn.z, half.cosine}, q));
    const mask stays = way == zero;
    q = {stays ? q.x : next.x, stays ? q.y : next.y, stays ? q.z : next.z, stays ? q.w : next.w};

    const unsigned together = bits_of(slow);
    for (std::size_t k = 0; k < count; ++k) {
      rotating_body<Real>& body = bodies_[k];
      if (together >> k & 1u) {
        body.q = {q.w[k], q.x[k], q.y[k], q.z[k]};
        body.w = lane(spin, k);
      } else {
        body.rotate(dt);
      }
    }
  }

 private:
  /// The principal inverse moments in their order, and the axes of the lowest and the highest.
  struct sorted_moments {
    number low, middle, high;
    number axis_low, axis_high;

    [[gnu::always_inline]] explicit sorted_moments(const vectors& p)
        : low(p.x), middle(p.y), high(p.z), axis_low{}, axis_high(number{} + 2) {
      number axis_middle = number{} + 1;
      const auto sort = [](number & a, number & b, number & axis_a, number & axis_b)
          __attribute__((always_inline)) {
        const mask swap = a > b;
        const number x = a, axis = axis_a;
        a = swap ? b : a, b = swap ? x : b;
        axis_a = swap ? axis_b : axis_a, axis_b = swap ? axis : axis_b;
      };
      sort(low, middle, axis_low, axis_middle);
      sort(middle, high, axis_middle, axis_high);
      sort(low, middle, axis_low, axis_middle);
    }
  };

  /// free_body::second_order().
  [[gnu::always_inline]] static void about_low_and_high(quaternions& q, const vectors& momentum,
                                                        const sorted_moments& of, Real dt,
                                                        mask& slow) {
    // In the order k, i, j in which the lowest axis k comes first.
    const mask is_0 = of.axis_low == number{}, is_1 = of.axis_low == number{} + 1;
    const auto from = [&](const number& x, const number& y, const number& z)
        __attribute__((always_inline)) {
      return is_0 ? x : is_1 ? y : z;
    };
    number m[3] = {from(momentum.x, momentum.y, momentum.z),
                   from(momentum.y, momentum.z, momentum.x),
                   from(momentum.z, momentum.x, momentum.y)};
    number v[3] = {from(q.x, q.y, q.z), from(q.y, q.z, q.x), from(q.z, q.x, q.y)};
    const auto about = [&](number(&m)[3], number(&v)[3], const number& moment, Real time)
        __attribute__((always_inline)) {
      const small_angle h(time * (moment - of.middle) * m[0], slow);
      const number c = h.cosine * h.cosine - h.sine * h.sine, s = 2 * h.cosine * h.sine;
      const number mi = m[1], mj = m[2];
      m[1] = c * mi + s * mj;
      m[2] = c * mj - s * mi;
      const number qk = v[0], qi = v[1], qj = v[2], w = q.w;
      v[0] = h.cosine * qk + h.sine * w;
      v[1] = h.cosine * qi + h.sine * qj;
      v[2] = h.cosine * qj - h.sine * qi;
      q.w = h.cosine * w - h.sine * qk;
    };
    about(m, v, of.low, dt / 2);
    // The highest axis is the next one, i, or the last one.
    const mask is_next = of.axis_high == (is_0 ? number{} + 1 : is_1 ? number{} + 2 : number{});
    const auto turned_to = [&](number(&x)[3]) __attribute__((always_inline)) {
      const number k = x[0], i = x[1], j = x[2];
      x[0] = is_next ? i : j, x[1] = is_next ? j : k, x[2] = is_next ? k : i;
    };
    const auto turned_back = [&](number(&x)[3]) __attribute__((always_inline)) {
      const number k = x[0], i = x[1], j = x[2];
      x[0] = is_next ? j : i, x[1] = is_next ? k : j, x[2] = is_next ? i : k;
    };
    turned_to(m), turned_to(v);
    about(m, v, of.high, dt);
    turned_back(m), turned_back(v);
    about(m, v, of.low, dt / 2);
    q.x = from(v[0], v[2], v[1]), q.y = from(v[1], v[0], v[2]), q.z = from(v[2], v[1], v[0]);
  }

  [[nodiscard]] [[gnu::always_inline]] static quaternions conjugate(const quaternions& q) {
    return {-q.x, -q.y, -q.z, q.w};
  }
  [[nodiscard]] [[gnu::always_inline]] static vectors rotated(const quaternions& q,
                                                              const vectors& v) {
    const vectors axis{q.x, q.y, q.z};
    vectors uv = crossed(axis, v);
    uv += uv;
    return v + q.w * uv + crossed(axis, uv);
  }
  [[nodiscard]] [[gnu::always_inline]] static vectors scaled(const vectors& a, const vectors& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
  }
  [[nodiscard]] [[gnu::always_inline]] static quaternions product(const quaternions& a,
                                                                  const quaternions& b) {
    return {(a.w * b.x + a.y * b.z) - (a.z * b.y - a.x * b.w),
            (a.w * b.y + a.y * b.w) + (a.z * b.x - a.x * b.z),
            (a.w * b.z - a.y * b.x) + (a.z * b.w + a.x * b.y),
            (a.w * b.w - a.y * b.y) - (a.z * b.z + a.x * b.x)};
  }
  [[nodiscard]] [[gnu::always_inline]] static quaternions normalized(const quaternions& q) {
    const number length = square_root((q.x * q.x + q.z * q.z) + (q.y * q.y + q.w * q.w));
    return {q.x / length, q.y / length, q.z / length, q.w / length};
  }

  std::array<rotating_body<Real>, capacity> bodies_;
};

#pragma GCC diagnostic pop

#ifdef TALUS_COMPILED
extern template class rotating_bodies<real>;
#endif

}  // namespace talus::detail
