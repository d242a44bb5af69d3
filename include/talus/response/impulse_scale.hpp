#pragma once
// By how much impulses have to shrink so that they add no energy.
#include <algorithm>
#include <cmath>
#include <limits>

#include "talus/core/math.hpp"

namespace talus::detail {

/// What the impulses of one step do to the energy of some bodies, and how it changes where some of
/// these impulses are scaled by a common factor. With the factor 1 - d the work is
/// work - d * slope + d^2/2 * square, and the change of the energy is
/// work + rise - d * (slope + rise_slope) + d^2/2 * square.
struct impulse_work {
  real work = 0;        ///< of all impulses on the mean of the velocities before and after
  real slope = 0;       ///< of the scaled impulses on the velocities that they act at
  real square = 0;      ///< of the scaled impulses, through the inverse masses
  real size = 0;        ///< sum of the absolute values that `work` is made of
  real rise = 0;        ///< what to add for the change of kinetic and potential energy
  real rise_slope = 0;  ///< what to add to the slope for it
  bool shared = false;  ///< boundary contacts act on some of these bodies
  real fall = 0;  ///< what to add, for those, for the work on the mean of free and last velocities

  impulse_work& operator+=(const impulse_work& x) {
    work += x.work, slope += x.slope, square += x.square, size += x.size;
    rise += x.rise, rise_slope += x.rise_slope, fall += x.fall;
    shared = shared || x.shared;
    return *this;
  }
  /// Whether impulses add energy beyond round-off. An exact solution may do work on bodies that
  /// gravity brings together within the step, but then they lose more energy than that; and it
  /// may add energy where a bounce ends above its contact, but then it does no work. The work of
  /// boundary contacts is that of an iteration before the last. Where bodies rest, this error is
  /// far below what contacts take from the free velocities of these bodies.
  [[nodiscard]] bool adds_energy() const {
    const real least = round_off(size);
    return work > least && work + rise > least && (!shared || work + fall > least);
  }
  [[nodiscard]] static real round_off(real size) { return 4e-15 * size; }
  /// The least d in [0, 1] with which the impulses do not add energy, or add as little as they can.
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
  /// Where gain - d * falls + d^2/2 * square is 0 for the first time.
  [[nodiscard]] real root(real gain, real falls) const {
    const real under = falls * falls - 2 * square * gain;
    return falls > 0 && under >= 0 ? 2 * gain / (falls + std::sqrt(under)) : never;
  }
  /// Where it is least.
  [[nodiscard]] real minimum(real falls) const { return falls > 0 ? falls / square : never; }
};

}  // namespace talus::detail
