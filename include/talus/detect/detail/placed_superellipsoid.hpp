#pragma once
// Posed superellipsoids, and the difference of two.
#include <cmath>

#include "talus/detect/detail/convex_climb.hpp"
#include "talus/shape/superellipsoid.hpp"

namespace talus::detail {

/// A posed superellipsoid. All lengths are multiples of a unit.
template <class Real>
class placed_superellipsoid {
  using vector = vector3<Real>;

 public:
  placed_superellipsoid(const superellipsoid& s, const quat& turn, const vector& at, Real unit)
      : shape_(s), centre_(at), axes_(turn.toRotationMatrix()) {
    shape_.radii = shape_.radii / unit;
  }
  [[nodiscard]] const vector& centre() const { return centre_; }
  [[nodiscard]] vector support(const vector& direction) const {
    return centre_ + axes_ * shape_.support(axes_.transpose() * direction);
  }
  /// The derivative of that along unit directions.
  [[nodiscard]] bending bends(const vector& direction) const {
    bending b = shape_.bending_along(axes_.transpose() * direction);
    b.bound(Real(1e12));
    for (vector& v : b.along) v = axes_ * v;
    return b;
  }
  [[nodiscard]] Real size() const { return shape_.radii.maxCoeff(); }
  /// The function whose level is the surface, with derivatives times `size`.
  [[nodiscard]] surface_level level(const vector& p, Real size) const {
    return turned(shape_.level(axes_.transpose() * (p - centre_)), axes_, size);
  }
  /// The matrix of the ellipsoid with the same radii, whose furthest point along n is M n over the
  /// root of n.M n.
  [[nodiscard]] matrix3<Real> ellipsoid() const {
    matrix3<Real> m;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        m(i, j) = 0;
        for (int k = 0; k < 3; ++k)
          m(i, j) += axes_(i, k) * axes_(j, k) * (shape_.radii[k] * shape_.radii[k]);
      }
    return m;
  }

 private:
  superellipsoid shape_;
  vector centre_;
  matrix3<Real> axes_;
};

/// The difference of two superellipsoids, for climb().
template <class Real>
struct superellipsoid_pair {
  using vector = vector3<Real>;
  const placed_superellipsoid<Real>&a, &b;

  [[nodiscard]] difference_point<Real> at(const vector& n) const {
    difference_point<Real> p{a.support(-n), b.support(n), {}};
    p.w = p.a - p.b;
    return p;
  }
  [[nodiscard]] symmetric_2<Real> bend(const vector& n, const difference_point<Real>&,
                                       const vector& t, const vector& u) const {
    symmetric_2<Real> sum;
    for (const bending& m : {a.bends(-n), b.bends(n)})
      for (int k = 0; k < 2; ++k) {
        const Real x = t.dot(m.along[k]), y = u.dot(m.along[k]);
        sum.aa += m.factor[k] * x * x, sum.ab += m.factor[k] * x * y;
        sum.bb += m.factor[k] * y * y;
      }
    return sum;
  }
  /// The best normal of two ellipsoids of one form and orientation.
  [[nodiscard]] vector start() const {
    const matrix3<Real> s = a.ellipsoid() + b.ellipsoid();
    const vector x = s.col(0), y = s.col(1), z = s.col(2), d = a.centre() - b.centre();
    return vector(y.cross(z).dot(d), z.cross(x).dot(d), x.cross(y).dot(d));
  }
};

}  // namespace talus::detail
