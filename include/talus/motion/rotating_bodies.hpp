#pragma once
// Free rotation of eight bodies at once, to the bit of single ones.
#include <algorithm>
#include <array>
#include <cstddef>

#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/motion/free_bodies.hpp"
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

/// Up to eight bodies. Those whose angles in the step are small are rotated side by side, and the
/// others one by one.
template <class Real>
class rotating_bodies {
  using number = pack<Real, 8>;
  using mask = mask_of<number>;
  using vectors = pack_vector<number>;
  using quaternions = free_quaternions<number>;

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
    const mask moves = length > zero;
    const vectors p{1 / inertia.x, 1 / inertia.y, 1 / inertia.z};
    free_bodies<number> all(start, own, p);
    const number angle = length * dt * all.asymmetry();
    const mask second = moves & (angle < second_order_angle<Real>),
               fourth = moves & (angle >= second_order_angle<Real>)&(angle < largest_angle);
    mask small = second | fourth;
    if (bits_of(second) != 0) all.second_order(dt, second, small);
    if (bits_of(fourth) != 0) {
      number parts = every_lane<number>(1);
      Real most = 1;
      for (std::size_t k = 0; k < capacity; ++k)
        if (bits_of(fourth) >> k & 1u)
          most = std::max(most, parts[k] = parts_of_step<Real>(angle[k]));
      for (Real k = 0; k < most; ++k) all.fourth_order(dt / parts, fourth & (parts > k), small);
    }
    quaternions q = all.orientation();
    const small_angles<number> h(length * dt * all.middle(), small);
    const number part = h.sine / length;
    q = normalized(product({part * momentum.x, part * momentum.y, part * momentum.z, h.cosine}, q));
    const vectors spin = rotated(q, scaled(rotated(conjugate(q), momentum), p));

    const number way = square_root(dot(turn, turn));
    const small_angles<number> half(way, small);
    const number by = half.sine / way;
    const quaternions next =
        normalized(product({by * turn.x, by * turn.y, by * turn.z, half.cosine}, q));
    const mask stays = way == zero;
    q = {stays ? q.x : next.x, stays ? q.y : next.y, stays ? q.z : next.z, stays ? q.w : next.w};

    const unsigned together = bits_of(small);
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
  /// Beyond it a body takes many parts of a step, and would let the others wait.
  static constexpr Real largest_angle = 4 * fourth_order_angle<Real>;

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
