#pragma once
// free_body of several bodies at once, to the bit of single ones.
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/motion/free_rotation.hpp"

namespace talus::detail {

// All functions that take packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <class Pack>
struct free_quaternions {
  Pack x, y, z, w;
};

/// half_angle for small angles.
template <class Pack>
struct small_angles {
  Pack cosine, sine;

  /// `small` keeps the lanes in which the angles are small.
  [[gnu::always_inline]] small_angles(const Pack& angle, mask_of<Pack>& small)
      : small_angles(angle, small, ~mask_of<Pack>{}) {}
  /// ... of `lanes`, and all others.
  [[gnu::always_inline]] small_angles(const Pack& angle, mask_of<Pack>& small,
                                      const mask_of<Pack>& lanes) {
    const Pack x = angle / 2, y = x * x;
    small &= (y < 0.01) | ~lanes;
    cosine = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90))));
    sine = x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72))));
  }
};

/// See free_body. Axes are in the cyclic order in which that of the lowest inverse moment comes
/// first. The functions rotate the bodies in `lanes`; `small` loses those with large angles.
template <class Pack>
class free_bodies {
  using mask = mask_of<Pack>;
  using vectors = pack_vector<Pack>;
  using number = lane_of<Pack>;

 public:
  [[gnu::always_inline]] free_bodies(const free_quaternions<Pack>& q, const vectors& momentum,
                                     const vectors& p)
      : low_(p.x), middle_(p.y), high_(p.z), w_(q.w) {
    Pack axis_low{}, axis_middle = Pack{} + 1, axis_high = Pack{} + 2;
    sort(low_, middle_, axis_low, axis_middle);
    sort(middle_, high_, axis_middle, axis_high);
    sort(low_, middle_, axis_low, axis_middle);
    is_0_ = axis_low == Pack{}, is_1_ = axis_low == Pack{} + 1;
    high_is_next_ = axis_high == (is_0_ ? Pack{} + 1 : is_1_ ? Pack{} + 2 : Pack{});
    m_[0] = from(momentum.x, momentum.y, momentum.z);
    m_[1] = from(momentum.y, momentum.z, momentum.x);
    m_[2] = from(momentum.z, momentum.x, momentum.y);
    v_[0] = from(q.x, q.y, q.z), v_[1] = from(q.y, q.z, q.x), v_[2] = from(q.z, q.x, q.y);
  }
  [[nodiscard, gnu::always_inline]] Pack asymmetry() const {
    return square_root((high_ - middle_) * (middle_ - low_));
  }
  [[nodiscard]] const Pack& middle() const { return middle_; }
  [[nodiscard, gnu::always_inline]] free_quaternions<Pack> orientation() const {
    return {from(v_[0], v_[2], v_[1]), from(v_[1], v_[0], v_[2]), from(v_[2], v_[1], v_[0]), w_};
  }
  [[gnu::always_inline]] void second_order(number dt, const mask& lanes, mask& small) {
    const Pack time = every_lane<Pack>(dt), half = every_lane<Pack>(dt / 2);
    about_low(half, lanes, small), about_high(time, lanes, small), about_low(half, lanes, small);
  }
  [[gnu::always_inline]] void fourth_order(const Pack& dt, const mask& lanes, mask& small) {
    using of = fourth_order_composition<number>;
    for (int k = 0; k < 6; ++k)
      about_low(of::a[k] * dt, lanes, small), about_high(of::b[k] * dt, lanes, small);
    about_low(of::a[0] * dt, lanes, small);
  }

 private:
  [[gnu::always_inline]] static void sort(Pack& a, Pack& b, Pack& axis_a, Pack& axis_b) {
    const mask swap = a > b;
    const Pack x = a, axis = axis_a;
    a = swap ? b : a, b = swap ? x : b;
    axis_a = swap ? axis_b : axis_a, axis_b = swap ? axis : axis_b;
  }
  [[nodiscard, gnu::always_inline]] Pack from(const Pack& x, const Pack& y, const Pack& z) const {
    return is_0_ ? x : is_1_ ? y : z;
  }
  [[gnu::always_inline]] void about_low(const Pack& time, const mask& lanes, mask& small) {
    about(low_, time, lanes, small);
  }
  /// The highest axis is the next one after the lowest, or the last.
  [[gnu::always_inline]] void about_high(const Pack& time, const mask& lanes, mask& small) {
    for (Pack(*x)[3] : {&m_, &v_}) {
      const Pack k = (*x)[0], i = (*x)[1], j = (*x)[2];
      (*x)[0] = high_is_next_ ? i : j, (*x)[1] = high_is_next_ ? j : k;
      (*x)[2] = high_is_next_ ? k : i;
    }
    about(high_, time, lanes, small);
    for (Pack(*x)[3] : {&m_, &v_}) {
      const Pack k = (*x)[0], i = (*x)[1], j = (*x)[2];
      (*x)[0] = high_is_next_ ? j : i, (*x)[1] = high_is_next_ ? k : j;
      (*x)[2] = high_is_next_ ? i : k;
    }
  }
  [[gnu::always_inline]] void about(const Pack& moment, const Pack& time, const mask& lanes,
                                    mask& small) {
    const small_angles<Pack> h(time * (moment - middle_) * m_[0], small, lanes);
    const Pack c = h.cosine * h.cosine - h.sine * h.sine, s = 2 * h.cosine * h.sine;
    const Pack mi = m_[1], mj = m_[2], qk = v_[0], qi = v_[1], qj = v_[2], w = w_;
    m_[1] = lanes ? c * mi + s * mj : mi;
    m_[2] = lanes ? c * mj - s * mi : mj;
    v_[0] = lanes ? h.cosine * qk + h.sine * w : qk;
    v_[1] = lanes ? h.cosine * qi + h.sine * qj : qi;
    v_[2] = lanes ? h.cosine * qj - h.sine * qi : qj;
    w_ = lanes ? h.cosine * w - h.sine * qk : w;
  }

  Pack low_, middle_, high_;  ///< principal inverse moments
  mask is_0_, is_1_;          ///< which axis is that of the lowest
  mask high_is_next_;
  Pack m_[3], v_[3], w_;  ///< angular momentum and quaternion
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
