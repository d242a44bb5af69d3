#pragma once
// Pairs of boxes tested for separation eight at a time.
#include <array>
#include <cstdint>
#include <cstring>

#include "talus/core/pack_rows.hpp"
#include "talus/detect/batch_of.hpp"
#include "talus/detect/box_place.hpp"
#include "talus/detect/detail/box_axes.hpp"
#include "talus/detect/detail/box_patches.hpp"

namespace talus::detail {

/// Up to eight pairs, added one by one and tested together. The result of a pair does not depend on
/// the others.
template <class Real>
class box_batch {
  using number = pack<Real, 8>;

 public:
  using place = box_place<Real>;
  static constexpr unsigned capacity = 8;

  /// The boxes must stay where they are until the search.
  void set(unsigned lane, const box_place<Real>& a, const box_place<Real>& b, Real margin) {
    at_a_[lane] = &a, at_b_[lane] = &b;
    margin_[lane] = margin;
  }
  /// Bit k is set if pair k, of the first `count`, may have contacts: collide_lane() finds them.
  [[nodiscard]] unsigned search(unsigned count) {
    const unsigned near = test(count);
    if (near != 0) find_patches();
    return near;
  }
  [[nodiscard]] static constexpr unsigned uncertain() { return 0; }
  /// Bit k is set unless some axis separates pair k, of the first `count`, by more than its margin.
  [[nodiscard]] unsigned test(unsigned count = capacity) {
    for (unsigned k = count; k < capacity; ++k) at_a_[k] = at_a_[0], at_b_[k] = at_b_[0];
    number a[3][3], b[3][3], away[3];
    load(at_a_, ha_, a, away);
    number from[3];
    for (int i = 0; i < 3; ++i) from[i] = away[i];
    load(at_b_, hb_, b, away);
    for (int i = 0; i < 3; ++i) away[i] = away[i] - from[i];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        c_[i][j] = a[0][i] * b[0][j] + a[1][i] * b[1][j] + a[2][i] * b[2][j];
      d_[i] = a[0][i] * away[0] + a[1][i] * away[1] + a[2][i] * away[2];
    }
    gaps_ = find_box_gaps<false>(ha_, hb_, c_, d_, margin_);
    const number square = margin_ * (margin_ < 0 ? -margin_ : margin_);
    const auto near =
        (gaps_.face_a <= margin_) & (gaps_.face_b <= margin_) & (gaps_.edge <= square);
    unsigned bits = 0;
    for (unsigned k = 0; k < count; ++k) bits |= (near[k] != 0 ? 1u : 0u) << k;
    return bits;
  }
  /// Computes the manifolds of all pairs, after test().
  void find_patches() { patches_.find(ha_, hb_, c_, d_, gaps_, margin_); }
  [[nodiscard]] const box_patches<Real>& patches() const { return patches_; }
  [[nodiscard]] box_pair<Real> pair(unsigned lane) const {
    box_pair<Real> p;
    for (int i = 0; i < 3; ++i) {
      p.ha[i] = ha_[i][lane], p.hb[i] = hb_[i][lane], p.offset[i] = d_[i][lane];
      for (int j = 0; j < 3; ++j) p.axes(i, j) = c_[i][j][lane];
    }
    return p;
  }
  [[nodiscard]] box_gaps<Real> gaps(unsigned lane) const {
    return {gaps_.face_a[lane], gaps_.axis_a[lane], gaps_.face_b[lane],
            gaps_.axis_b[lane], gaps_.edge[lane],   gaps_.axes[lane]};
  }

 private:
  using places = std::array<const box_place<Real>*, capacity>;

  [[gnu::always_inline]] static void load(const places& of, number (&half)[3], number (&axes)[3][3],
                                          number (&position)[3]) {
    const auto rows = [&](auto part) __attribute__((always_inline)) {
      return gather<number>([&](int k) __attribute__((always_inline)) {
        const box_place<Real>& x = *of[static_cast<std::size_t>(k)];
        return row_from<Real>(x, part(x));
      });
    };
    const auto p = rows([](const auto& x) -> auto& { return x.position; });
    const auto h = rows([](const auto& x) -> auto& { return x.half; });
    // The nine numbers of the axes, column by column.
    const auto low = rows([](const auto& x) -> auto& { return x.axes.data()[0]; });
    const auto high = rows([](const auto& x) -> auto& { return x.axes.data()[4]; });
    position[0] = p.x, position[1] = p.y, position[2] = p.z;
    half[0] = h.x, half[1] = h.y, half[2] = h.z;
    axes[0][0] = low.x, axes[1][0] = low.y, axes[2][0] = low.z, axes[0][1] = low.w;
    axes[1][1] = high.x, axes[2][1] = high.y, axes[0][2] = high.z, axes[1][2] = high.w;
    for (unsigned k = 0; k < capacity; ++k) axes[2][2][k] = of[k]->axes(2, 2);
  }

  places at_a_{}, at_b_{};
  number ha_[3], hb_[3], margin_{};
  number c_[3][3], d_[3];
  box_gaps<number> gaps_;
  box_patches<Real> patches_;
};

template <>
struct batch_of<box> {
  using type = box_batch<real>;
};

}  // namespace talus::detail
