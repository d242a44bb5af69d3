#pragma once
// Tangents to a contact normal.
#include <cmath>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Rows (n, t1, t2): an orthonormal frame around the unit normal n (Duff et al. 2017). Equal
/// normals have one frame: the sign of a zero has no effect.
template <class Real>
[[nodiscard]] matrix3<Real> frame_around(const vector3<Real>& n) {
  const Real sign = n[2] < 0 ? Real{-1} : Real{1}, p = -1 / (sign + n[2]), q = n[0] * n[1] * p;
  return {n[0],
          n[1],
          n[2],  //
          1 + sign * n[0] * n[0] * p,
          sign * q,
          -sign * n[0],  //
          q,
          sign + n[1] * n[1] * p,
          -n[1]};
}

}  // namespace talus::detail
