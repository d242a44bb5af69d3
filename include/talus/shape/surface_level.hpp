#pragma once
// A surface as the level of a convex function, and its curvature.
#include <algorithm>
#include <cmath>

#include "talus/core/math.hpp"

namespace talus {

namespace detail {

/// The sum of two matrices factor v v^T.
struct bending {
  real factor[2] = {0, 0};
  vec3 along[2];

  /// Each factor at most such that the matrix is at most `most`.
  void bound(real most) {
    for (int k = 0; k < 2; ++k) factor[k] = std::min(factor[k], most / along[k].squaredNorm());
  }
  /// Returns a matrix whose eigenvalues across the direction `n`, a unit vector, are at most
  /// `most`.
  [[nodiscard]] mat3 within(const vec3& n, real most) const {
    bending b = *this;
    b.bound(real(1e6) * most);
    const vec3 t = n.cross(vec3::Unit(std::abs(n[0]) < real(0.6) ? 0 : 1)).normalized(),
               u = n.cross(t);
    real tt = 0, tu = 0, uu = 0;
    for (int k = 0; k < 2; ++k) {
      const real x = t.dot(b.along[k]), y = u.dot(b.along[k]);
      tt += b.factor[k] * x * x, tu += b.factor[k] * x * y, uu += b.factor[k] * y * y;
    }
    const real mean = (tt + uu) / 2, apart = (tt - uu) / 2;
    const real half = std::sqrt(apart * apart + tu * tu);
    if (mean - half > most) {
      tt = uu = most, tu = 0;
    } else if (mean + half > most) {
      // The direction of the larger one has twice the angle whose cosine is apart / half.
      const real cut = (mean + half - most) / 2, c = apart / half, s = tu / half;
      tt -= cut * (1 + c), tu -= cut * s, uu -= cut * (1 - c);
    }
    mat3 m;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        m(i, j) = tt * t[i] * t[j] + tu * (t[i] * u[j] + u[i] * t[j]) + uu * u[i] * u[j];
    return m;
  }
};

}  // namespace detail

/// A convex function that is proportional along each ray from the centre of a shape and 1 on its
/// surface, at one point: its value and derivatives.
struct surface_level {
  real value = 0;
  vec3 gradient{0, 0, 0};
  detail::bending curvature;  ///< the second derivative
};

namespace detail {

/// From the frame of a shape to that of its axes, with derivatives times `size`.
[[nodiscard]] inline surface_level turned(surface_level l, const mat3& axes, real size) {
  l.gradient = size * (axes * l.gradient);
  for (vec3& v : l.curvature.along) v = axes * v;
  for (real& f : l.curvature.factor) f *= size;
  return l;
}

}  // namespace detail

}  // namespace talus
