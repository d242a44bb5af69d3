#pragma once
// By how much impulses have to shrink so that they add no energy.
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"

namespace talus::detail {

/// The work of the impulses of one step on some bodies, and how it changes where some of these
/// impulses are scaled by a common factor. With the factor 1 - d the work is
/// work - d * slope + d^2/2 * square.
struct impulse_work {
  real work = 0;    ///< of all impulses on the mean of the velocities before and after
  real slope = 0;   ///< of the scaled impulses on the velocities that they act at
  real square = 0;  ///< of the scaled impulses, through the inverse masses
  real size = 0;    ///< sum of the absolute values that `work` is made of

  impulse_work& operator+=(const impulse_work& x) {
    work += x.work, slope += x.slope, square += x.square, size += x.size;
    return *this;
  }
  /// Whether the work is positive beyond round-off.
  [[nodiscard]] bool adds_energy() const { return work > 4e-15 * size; }
  /// The least d in [0, 1] that makes the work 0, or as small as it gets.
  [[nodiscard]] real excess() const {
    if (!adds_energy() || !(slope > 0)) return 0;
    const real root = slope * slope - 2 * square * work;
    const real d = 2 * work / (slope + std::sqrt(std::max(root, real{0})));
    return std::min(d, real{1});
  }
};

}  // namespace talus::detail
