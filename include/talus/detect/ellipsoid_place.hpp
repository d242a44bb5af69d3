#pragma once
// The position and form of an ellipsoid for detection, computed once per step for all its pairs.
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/shape/ellipsoid.hpp"

namespace talus::detail {

/// An ellipsoid in the world, as the symmetric matrix M whose support point along n is
/// M n / sqrt(n.M n). In this order, because vectors are read together with the number that follows
/// them.
template <class Real>
struct ellipsoid_place {
  vector3<Real> position;
  Real reach = 0;         ///< distance from the centre at which it may meet others in this step
  vector3<Real> first;    ///< M(0, 0), M(0, 1), M(0, 2)
  Real radius = 0;        ///< of the bounding sphere
  vector3<Real> further;  ///< M(1, 1), M(1, 2), M(2, 2)
  Real inner = 0;         ///< radius of the largest ball about the centre that is inside
};

/// The place of an ellipsoid for a search of its neighbours within `reach`.
template <class Real>
[[nodiscard]] ellipsoid_place<Real> place_of(const ellipsoid& e, const pose& at, Real reach) {
  const matrix3<Real> axes = at.orientation.toRotationMatrix();
  const auto entry = [&](int i, int j) {
    Real sum = 0;
    for (int k = 0; k < 3; ++k) sum += axes(i, k) * axes(j, k) * (e.radii[k] * e.radii[k]);
    return sum;
  };
  return {at.position,
          reach,
          {entry(0, 0), entry(0, 1), entry(0, 2)},
          e.bounding_radius(),
          {entry(1, 1), entry(1, 2), entry(2, 2)},
          e.inner_radius()};
}

/// The matrix of a place, by its rows.
template <class Real>
[[nodiscard]] pack_matrix<Real> matrix_of(const ellipsoid_place<Real>& e) {
  const vector3<Real>&x = e.first, &y = e.further;
  return {{x[0], x[1], x[2]}, {x[1], y[0], y[1]}, {x[2], y[1], y[2]}};
}

/// Two ellipsoids that overlap by more may have a shallower way out than a search from their
/// centres finds (convex_contact.hpp). The arguments are their inner and outer radii.
template <class Number>
[[nodiscard]] [[gnu::always_inline]] inline Number certain_overlap(const Number& inner_a,
                                                                   const Number& outer_a,
                                                                   const Number& inner_b,
                                                                   const Number& outer_b) {
  const auto every = [](lane_of<Number> x) { return every_lane<Number>(x); };
  // The smallest radius of curvature of an ellipsoid is that at the ends of its longest axis.
  const Number curvatures = inner_a * (inner_a / outer_a) + inner_b * (inner_b / outer_b);
  return smaller(every(0.1) * smaller(inner_a, inner_b), every(0.5) * curvatures);
}

}  // namespace talus::detail
