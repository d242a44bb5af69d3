#pragma once
// The factor by which impulses must shrink so that they add no energy.
#include <algorithm>
#include <cmath>
#include <limits>

#include "talus/core/math.hpp"

namespace talus::detail {

/// The effect of the impulses of one step on the energy of some bodies, and its change if some of
/// these impulses are scaled by a common factor. With the factor 1 - d the work is work - d * slope
/// + d^2/2 * square, and the change of the energy is work + rise - d * (slope + rise_slope) + d^2/2
/// * square.
struct impulse_work {
  real work = 0;        ///< of all impulses on the mean of the velocities before and after
  real slope = 0;       ///< of the scaled impulses on the velocities at which they act
  real square = 0;      ///< of the scaled impulses, through the inverse masses
  real size = 0;        ///< sum of the absolute values of the terms of `work`
  real rise = 0;        ///< to be added for the change of kinetic and potential energy
  real rise_slope = 0;  ///< to be added to the slope for it
  bool shared = false;  ///< boundary contacts act on some of these bodies
  real fall = 0;  ///< to be added, for those, for the work on the mean of free and last velocities

  impulse_work& operator+=(const impulse_work& x) {
    work += x.work, slope += x.slope, square += x.square, size += x.size;
    rise += x.rise, rise_slope += x.rise_slope, fall += x.fall;
    shared = shared || x.shared;
    return *this;
  }
  /// Whether impulses add energy beyond round-off. An exact solution may do work on bodies that
  /// gravity brings together within the step, but then they lose more energy than that; and it may
  /// add energy if a bounce ends above its contact, but then it does no work. The work of boundary
  /// contacts is that of an iteration before the last. For resting bodies, this error is far below
  /// the energy that contacts take from their free velocities.
  [[nodiscard]] bool adds_energy() const {
    const real least = round_off(size);
    return work > least && work + rise > least && (!shared || work + fall > least);
  }
  [[nodiscard]] static real round_off(real size) { return 4e-15 * size; }
  /// The least d in [0, 1] with which the impulses add no energy, or as little as possible.
  [[nodiscard]] real excess() const {
    if (!adds_energy()) return 0;
    const real cure = std::min(root(work, slope), root(work + rise, slope + rise_slope));
    if (cure <= 1) return cure;
    if (cure < never) return 1;
    const real least = std::min(minimum(slope), minimum(slope + rise_slope));
    return least <= 1 ? least : slope > 0 ? real{1} : real{0};
  }

 private:
  static constexpr real never = std::numeric_limits<real>::infinity();
  /// The first d at which gain - d * falls + d^2/2 * square is 0.
  [[nodiscard]] real root(real gain, real falls) const {
    const real under = falls * falls - 2 * square * gain;
    return falls > 0 && under >= 0 ? 2 * gain / (falls + std::sqrt(under)) : never;
  }
  /// The d of its minimum.
  [[nodiscard]] real minimum(real falls) const { return falls > 0 ? falls / square : never; }
};

}  // namespace talus::detail
