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
  real fall = 0;  ///< what to add for the work on the mean of the free velocities and the last
  bool shared = false;  ///< boundary contacts act on these bodies

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
  /// far below what contacts take from the free velocities.
  [[nodiscard]] bool adds_energy() const {
    const real round_off = 4e-15 * size;
    return work > round_off && work + rise > round_off && (!shared || work + fall > round_off);
  }
  /// The least d in [0, 1] with which the impulses do not add energy, or add as little as they can.
  [[nodiscard]] real excess() const {
    if (!adds_energy()) return 0;
    const real least = std::min(root(work, slope), root(work + rise, slope + rise_slope));
    return least <= 1 ? least : slope > 0 ? real{1} : real{0};
  }

 private:
  /// Where gain - d * falls + d^2/2 * square is 0 or least; infinite where it rises from d = 0.
  [[nodiscard]] real root(real gain, real falls) const {
    if (!(falls > 0)) return std::numeric_limits<real>::infinity();
    const real under = falls * falls - 2 * square * gain;
    return under > 0 ? 2 * gain / (falls + std::sqrt(under)) : falls / square;
  }
};

}  // namespace talus::detail
