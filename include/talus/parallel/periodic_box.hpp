#pragma once
// The images of a periodic box.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "talus/core/math.hpp"

namespace talus {

/// A box that is periodic along some axes. Its functions return the same bits on every rank. An
/// image has a number below 27; number 0 is the box itself. The image moves a point by whole
/// periods, at most one along each axis.
class periodic_box {
 public:
  using number = std::uint32_t;
  static constexpr number count = 27;

  periodic_box() = default;
  /// Lower and upper sides; equal along the axes that are not periodic.
  periodic_box(const vec3& lower, const vec3& upper)
      : lower_(lower), upper_(upper), period_(upper - lower) {}

  [[nodiscard]] const vec3& lower() const { return lower_; }
  [[nodiscard]] const vec3& upper() const { return upper_; }
  /// Lengths of the box; 0 along the axes that are not periodic.
  [[nodiscard]] const vec3& period() const { return period_; }
  /// The smallest of them that is not 0.
  [[nodiscard]] real shortest() const {
    real least = std::numeric_limits<real>::infinity();
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0) least = std::min(least, period_[k]);
    return least;
  }

  /// The displacement of an image.
  [[nodiscard]] vec3 shift(number image) const {
    const auto part = [&](int k, number digit) {
      return digit == 0 ? 0 : digit == 1 ? period_[k] : -period_[k];
    };
    return {part(0, image % 3), part(1, image / 3 % 3), part(2, image / 9)};
  }
  /// The image that moves a point back.
  [[nodiscard]] static number reverse(number image) {
    const auto turned = [](number digit) { return (3 - digit) % 3; };
    return turned(image % 3) + 3 * turned(image / 3 % 3) + 9 * turned(image / 9);
  }

  /// Calls f(image, moved point) for all images that come within `radius` of the box, the point
  /// itself first.
  template <class F>
  void each_within(const vec3& p, real radius, F&& f) const {
    number digits[3][3], many[3];
    for (int k = 0; k < 3; ++k) {
      digits[k][0] = 0, many[k] = 1;
      if (!(period_[k] > 0)) continue;
      if (p[k] + period_[k] <= upper_[k] + radius) digits[k][many[k]++] = 1;
      if (p[k] - period_[k] >= lower_[k] - radius) digits[k][many[k]++] = 2;
    }
    for (number z = 0; z < many[2]; ++z)
      for (number y = 0; y < many[1]; ++y)
        for (number x = 0; x < many[0]; ++x) {
          const number image = digits[0][x] + 3 * digits[1][y] + 9 * digits[2][z];
          f(image, vec3(p + shift(image)));
        }
  }

  [[nodiscard]] bool contains(const vec3& p) const {
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0 && !(p[k] >= lower_[k] && p[k] < upper_[k])) return false;
    return true;
  }
  /// The image of a point that lies in the box.
  [[nodiscard]] vec3 wrapped(vec3 p) const {
    for (int k = 0; k < 3; ++k) {
      const real low = lower_[k], high = upper_[k], period = period_[k];
      if (!(period > 0) || (p[k] >= low && p[k] < high)) continue;
      if (p[k] >= high && p[k] < high + period)
        p[k] -= period;
      else if (p[k] < low && p[k] >= low - period)
        p[k] += period;
      else
        p[k] -= period * std::floor((p[k] - low) / period);
      // A point that round-off puts on the upper side belongs to the lower one.
      if (p[k] >= high || p[k] < low) p[k] = low;
    }
    return p;
  }
  /// The image of `p` that is nearest to `to`.
  [[nodiscard]] vec3 nearest(vec3 p, const vec3& to) const {
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0) p[k] -= period_[k] * std::round((p[k] - to[k]) / period_[k]);
    return p;
  }

 private:
  vec3 lower_{0, 0, 0}, upper_{0, 0, 0}, period_{0, 0, 0};
};

}  // namespace talus
