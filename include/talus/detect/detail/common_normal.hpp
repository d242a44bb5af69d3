#pragma once
// The common normal of two superellipsoids. The point that a normal belongs to moves without bound
// where the surface is flat, so the points themselves are unknowns beside the normal here.
#include <algorithm>
#include <array>
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
  [[nodiscard]] const superellipsoid& shape() const { return shape_; }
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
  /// The function that is 1 on the surface, with its derivatives times `size`.
  [[nodiscard]] nested_norm gauge(const vector& p, Real size) const {
    const vector local = axes_.transpose() * (p - centre_);
    nested_norm n = shape_.gauge(off_the_axis(local));
    n.gradient = size * (axes_ * n.gradient.cwiseQuotient(shape_.radii));
    for (vector& v : n.curvature.along) v = axes_ * v.cwiseQuotient(shape_.radii);
    for (Real& f : n.curvature.factor) f *= size;
    return n;
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

/// The points of two superellipsoids with opposite normals on one line, by Newton's method for the
/// point of a, the normal, the gap, and the lengths of the two gradients.
template <class Real>
class common_normal {
  using vector = vector3<Real>;

 public:
  common_normal(const superellipsoid_pair<Real>& pair, const vector& on_a, const vector& normal,
                Real gap)
      : a_(pair.a),
        b_(pair.b),
        size_a_(a_.shape().radii.maxCoeff()),
        size_b_(b_.shape().radii.maxCoeff()),
        now_{on_a, normal, gap, 0, 0} {}

  /// Whether they are found to rounding errors, within 40 steps.
  [[nodiscard]] bool find() {
    now_.of_a = a_.gauge(now_.on_a, size_a_).gradient.norm();
    now_.of_b = b_.gauge(now_.on_b(), size_b_).gradient.norm();
    residual rest = residual_of(now_);
    for (int k = 0; k < 40 && rest.size > Real(2e-15); ++k) {
      if (!solve(rest)) break;
      bool better = false;
      Real part = 1;
      for (int half = 0; half < 6 && !better; ++half, part *= Real(0.4)) {
        const unknowns next = now_.moved(part, step_);
        const residual r = residual_of(next);
        better = r.size < rest.size * (1 - Real(0.1) * part);
        if (better) now_ = next, rest = r;
      }
      if (!better) break;
    }
    return rest.size < Real(1e-12) && now_.of_a > 0 && now_.of_b > 0;
  }
  [[nodiscard]] vector normal() const { return now_.normal.normalized(); }
  [[nodiscard]] Real gap() const { return now_.gap; }
  /// Halfway between the two points.
  [[nodiscard]] vector middle() const { return now_.on_a - Real(0.5) * now_.gap * now_.normal; }

 private:
  static constexpr std::size_t count = 9;

  struct unknowns {
    vector on_a, normal;
    Real gap, of_a, of_b;
    [[nodiscard]] vector on_b() const { return on_a - gap * normal; }
    [[nodiscard]] unknowns moved(Real part, const std::array<Real, count>& by) const {
      return {on_a + part * vector(by[0], by[1], by[2]),
              normal + part * vector(by[3], by[4], by[5]), gap + part * by[6], of_a + part * by[7],
              of_b + part * by[8]};
    }
  };
  struct residual {
    nested_norm a, b;
    std::array<Real, count> values;
    Real size;
  };

  [[nodiscard]] residual residual_of(const unknowns& x) const {
    residual r{a_.gauge(x.on_a, size_a_), b_.gauge(x.on_b(), size_b_), {}, 0};
    const vector of_a = r.a.gradient + x.of_a * x.normal, of_b = r.b.gradient - x.of_b * x.normal;
    r.values = {of_a[0],       of_a[1],       of_a[2],
                of_b[0],       of_b[1],       of_b[2],
                r.a.value - 1, r.b.value - 1, Real(0.5) * (x.normal.squaredNorm() - 1)};
    for (const Real v : r.values) r.size += v * v;
    r.size = std::sqrt(r.size);
    return r;
  }
  /// The step of Newton's method, by elimination; false if there is none.
  [[nodiscard]] bool solve(const residual& r) {
    std::array<std::array<Real, count + 1>, count> m{};
    const vector &n = now_.normal, bent = bent_by(r.b.curvature, n);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        m[i][j] = entry(r.a.curvature, i, j);
        m[3 + i][j] = entry(r.b.curvature, i, j);
        m[3 + i][3 + j] = -now_.gap * m[3 + i][j];
      }
      m[i][3 + i] += now_.of_a, m[3 + i][3 + i] -= now_.of_b;
      m[i][7] = n[at(i)], m[3 + i][6] = -bent[at(i)], m[3 + i][8] = -n[at(i)];
      m[6][i] = r.a.gradient[at(i)] / size_a_;
      m[7][i] = r.b.gradient[at(i)] / size_b_;
      m[7][3 + i] = -now_.gap * m[7][i];
      m[8][3 + i] = n[at(i)];
    }
    m[7][6] = -r.b.gradient.dot(n) / size_b_;
    for (std::size_t i = 0; i < count; ++i) m[i][count] = -r.values[i];
    for (std::size_t i = 0; i < count; ++i) {
      std::size_t best = i;
      for (std::size_t j = i + 1; j < count; ++j)
        if (std::abs(m[j][i]) > std::abs(m[best][i])) best = j;
      if (!(std::abs(m[best][i]) > 0)) return false;
      std::swap(m[i], m[best]);
      for (std::size_t j = i + 1; j < count; ++j) {
        const Real f = m[j][i] / m[i][i];
        if (f == 0) continue;
        for (std::size_t k = i; k <= count; ++k) m[j][k] -= f * m[i][k];
      }
    }
    for (std::size_t i = count; i-- > 0;) {
      Real sum = m[i][count];
      for (std::size_t k = i + 1; k < count; ++k) sum -= m[i][k] * step_[k];
      step_[i] = sum / m[i][i];
      if (!std::isfinite(step_[i])) return false;
    }
    return true;
  }
  [[nodiscard]] static std::ptrdiff_t at(std::size_t i) { return static_cast<std::ptrdiff_t>(i); }
  [[nodiscard]] static Real entry(const bending& b, std::size_t i, std::size_t j) {
    return b.factor[0] * b.along[0][at(i)] * b.along[0][at(j)] +
           b.factor[1] * b.along[1][at(i)] * b.along[1][at(j)];
  }
  [[nodiscard]] static vector bent_by(const bending& b, const vector& v) {
    return (b.factor[0] * b.along[0].dot(v)) * b.along[0] +
           (b.factor[1] * b.along[1].dot(v)) * b.along[1];
  }

  const placed_superellipsoid<Real>&a_, &b_;
  Real size_a_, size_b_;
  unknowns now_;
  std::array<Real, count> step_{};
};

}  // namespace talus::detail
