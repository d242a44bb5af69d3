#pragma once
// The position and axes of a box for detection, computed once per step for all its pairs.
#include "talus/core/math.hpp"
#include "talus/shape/box.hpp"

namespace talus::detail {

/// A box in the world with its axes.
template <class Real>
struct box_place {
  vector3<Real> position, half;
  matrix3<Real> axes;  ///< in the columns

  [[nodiscard]] vector3<Real> to_world(const vector3<Real>& p) const { return position + axes * p; }
};

template <class Real>
[[nodiscard]] box_place<Real> place_of(const box& b, const pose& at) {
  return {at.position, b.half(), at.orientation.toRotationMatrix()};
}

}  // namespace talus::detail
