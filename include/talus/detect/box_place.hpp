#pragma once
// The position and axes of a box for detection, computed once per step for all its pairs.
#include "talus/core/math.hpp"
#include "talus/shape/box.hpp"

namespace talus::detail {

/// A box in the world with its axes. In this order, because vectors are read together with the
/// number that follows them.
template <class Real>
struct box_place {
  vector3<Real> position;
  Real reach = 0;  ///< distance from the centre at which it may meet others in this step
  vector3<Real> half;
  Real radius = 0;     ///< of the bounding sphere
  matrix3<Real> axes;  ///< in the columns

  [[nodiscard]] vector3<Real> to_world(const vector3<Real>& p) const { return position + axes * p; }
};

template <class Real>
[[nodiscard]] box_place<Real> place_of(const box& b, const pose& at) {
  return {at.position, 0, b.half(), 0, at.orientation.toRotationMatrix()};
}
/// The place of a box for a search of its neighbours within `reach`.
template <class Real>
[[nodiscard]] box_place<Real> place_of(const box& b, const pose& at, Real reach) {
  return {at.position, reach, b.half(), b.bounding_radius(), at.orientation.toRotationMatrix()};
}

}  // namespace talus::detail
