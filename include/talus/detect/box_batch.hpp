#pragma once
// Pairs of boxes tested for separation eight at a time.
#include <array>
#include <cstdint>
#include <cstring>

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
  static constexpr unsigned capacity = 8;

  void set(unsigned lane, const box_place<Real>& a, const box_place<Real>& b, Real margin) {
    const vector3<Real> away = b.position - a.position;
    for (int i = 0; i < 3; ++i) {
      ha_[i][lane] = a.half[i];
      hb_[i][lane] = b.half[i];
      away_[i][lane] = away[i];
      for (int j = 0; j < 3; ++j) {
        a_[i][j][lane] = a.axes(i, j);
        b_[i][j][lane] = b.axes(i, j);
      }
    }
    margin_[lane] = margin;
  }
  /// Bit k is set unless some axis separates pair k by more than its margin. Unused lanes have no
  /// effect.
  [[nodiscard]] unsigned test() {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        c_[i][j] = a_[0][i] * b_[0][j] + a_[1][i] * b_[1][j] + a_[2][i] * b_[2][j];
      d_[i] = a_[0][i] * away_[0] + a_[1][i] * away_[1] + a_[2][i] * away_[2];
    }
    gaps_ = find_box_gaps<false>(ha_, hb_, c_, d_, margin_);
    const number square = margin_ * (margin_ < 0 ? -margin_ : margin_);
    const auto near =
        (gaps_.face_a <= margin_) & (gaps_.face_b <= margin_) & (gaps_.edge <= square);
    unsigned bits = 0;
    for (unsigned k = 0; k < capacity; ++k) bits |= (near[k] != 0 ? 1u : 0u) << k;
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
  number ha_[3]{}, hb_[3]{}, a_[3][3]{}, b_[3][3]{}, away_[3]{}, margin_{};
  number c_[3][3], d_[3];
  box_gaps<number> gaps_;
  box_patches<Real> patches_;
};

}  // namespace talus::detail
