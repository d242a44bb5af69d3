#pragma once
// Rotations as unit quaternions.
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>

#include "talus/core/matrix3.hpp"
#include "talus/core/portable_trigonometry.hpp"

namespace talus {

/// Quaternion w + xi + yj + zk; of length one it rotates body coordinates into world coordinates.
/// Its functions are spelled as those of Eigen, whose quaternions convert from and to it.
template <class Real>
class quaternion {
 public:
  using Scalar = Real;
  using vector = vector3<Real>;

  quaternion() = default;
  constexpr quaternion(Real w, Real x, Real y, Real z) : at_{x, y, z, w} {}
  /// The quaternion of a rotation matrix (Shepperd 1978).
  explicit quaternion(const matrix3<Real>& m) {
    Real t = m(0, 0) + (m(1, 1) + m(2, 2));
    if (t > 0) {
      t = std::sqrt(t + 1);
      w() = Real(0.5) * t;
      t = Real(0.5) / t;
      x() = (m(2, 1) - m(1, 2)) * t, y() = (m(0, 2) - m(2, 0)) * t, z() = (m(1, 0) - m(0, 1)) * t;
    } else {
      int i = m(1, 1) > m(0, 0) ? 1 : 0;
      if (m(2, 2) > m(i, i)) i = 2;
      const int j = (i + 1) % 3, k = (j + 1) % 3;
      t = std::sqrt(m(i, i) - m(j, j) - m(k, k) + 1);
      at_[i] = Real(0.5) * t;
      t = Real(0.5) / t;
      w() = (m(k, j) - m(j, k)) * t;
      at_[j] = (m(j, i) + m(i, j)) * t, at_[k] = (m(k, i) + m(i, k)) * t;
    }
  }
  /// A quaternion of another library, as Eigen's: it has coeffs(), x first.
  template <class Q>
  requires(!std::same_as<Q, quaternion> &&
           requires(const Q& q) {
             { q.w() } -> std::convertible_to<double>;
             q.coeffs();
           }) quaternion(const Q& q)
      : quaternion(static_cast<Real>(q.w()), static_cast<Real>(q.x()), static_cast<Real>(q.y()),
                   static_cast<Real>(q.z())) {}
  /// A rotation by an angle about an axis, as Eigen's AngleAxis is.
  template <class T>
  requires requires(const T& t) {
    { t.angle() } -> std::convertible_to<double>;
    { t.axis() } -> std::convertible_to<vector>;
  }
  explicit quaternion(const T& t) {
    const auto half = portable::sincos(static_cast<double>(t.angle()) / 2);
    const auto s = static_cast<Real>(half.sine);
    const vector axis = t.axis();
    *this = {static_cast<Real>(half.cosine), s * axis[0], s * axis[1], s * axis[2]};
  }
  template <class Q>
  requires(!std::same_as<Q, quaternion> && requires { typename Q::AngleAxisType; }) operator Q()
      const {
    using number = typename Q::Scalar;
    return Q(static_cast<number>(w()), static_cast<number>(x()), static_cast<number>(y()),
             static_cast<number>(z()));
  }

  [[nodiscard]] static constexpr quaternion Identity() { return {1, 0, 0, 0}; }

  [[nodiscard]] constexpr Real& x() { return at_[0]; }
  [[nodiscard]] constexpr Real& y() { return at_[1]; }
  [[nodiscard]] constexpr Real& z() { return at_[2]; }
  [[nodiscard]] constexpr Real& w() { return at_[3]; }
  [[nodiscard]] constexpr Real x() const { return at_[0]; }
  [[nodiscard]] constexpr Real y() const { return at_[1]; }
  [[nodiscard]] constexpr Real z() const { return at_[2]; }
  [[nodiscard]] constexpr Real w() const { return at_[3]; }
  [[nodiscard]] constexpr vector vec() const { return {at_[0], at_[1], at_[2]}; }
  /// x, y, z, w.
  [[nodiscard]] constexpr std::array<Real, 4>& coeffs() { return at_; }
  [[nodiscard]] constexpr const std::array<Real, 4>& coeffs() const { return at_; }

  [[nodiscard]] constexpr Real squaredNorm() const {
    return (x() * x() + z() * z()) + (y() * y() + w() * w());
  }
  [[nodiscard]] Real norm() const { return std::sqrt(squaredNorm()); }
  void normalize() {
    const Real square = squaredNorm();
    if (!(square > 0)) return;
    const Real length = std::sqrt(square);
    for (Real& c : at_) c /= length;
  }
  [[nodiscard]] quaternion normalized() const {
    quaternion q = *this;
    q.normalize();
    return q;
  }
  [[nodiscard]] constexpr quaternion conjugate() const { return {w(), -x(), -y(), -z()}; }
  [[nodiscard]] constexpr quaternion inverse() const {
    const Real square = squaredNorm();
    return {w() / square, -x() / square, -y() / square, -z() / square};
  }
  [[nodiscard]] constexpr Real dot(const quaternion& q) const {
    return (x() * q.x() + z() * q.z()) + (y() * q.y() + w() * q.w());
  }
  /// Angle of the rotation from one to the other, in radians.
  [[nodiscard]] Real angularDistance(const quaternion& q) const {
    const quaternion d = *this * q.conjugate();
    return static_cast<Real>(2 * portable::atan2(d.vec().norm(), std::abs(d.w())));
  }

  /// Whether the coefficients differ by little.
  [[nodiscard]] bool isApprox(const quaternion& q, Real part = Real(1e-12)) const {
    const quaternion d{w() - q.w(), x() - q.x(), y() - q.y(), z() - q.z()};
    return d.squaredNorm() <= part * part * std::min(squaredNorm(), q.squaredNorm());
  }

  [[nodiscard]] constexpr matrix3<Real> toRotationMatrix() const {
    const Real tx = 2 * x(), ty = 2 * y(), tz = 2 * z();
    const Real twx = tx * w(), twy = ty * w(), twz = tz * w();
    const Real txx = tx * x(), txy = ty * x(), txz = tz * x();
    const Real tyy = ty * y(), tyz = tz * y(), tzz = tz * z();
    return {1 - (tyy + tzz), txy - twz,       txz + twy,  //
            txy + twz,       1 - (txx + tzz), tyz - twx,  //
            txz - twy,       tyz + twx,       1 - (txx + tyy)};
  }

  /// The rotation by b and then by a.
  friend constexpr quaternion operator*(const quaternion& a, const quaternion& b) {
    return {(a.w() * b.w() - a.y() * b.y()) - (a.z() * b.z() + a.x() * b.x()),
            (a.w() * b.x() + a.y() * b.z()) - (a.z() * b.y() - a.x() * b.w()),
            (a.w() * b.y() + a.y() * b.w()) + (a.z() * b.x() - a.x() * b.z()),
            (a.w() * b.z() - a.y() * b.x()) + (a.z() * b.w() + a.x() * b.y())};
  }
  /// The vector turned.
  friend constexpr vector operator*(const quaternion& q, const vector& v) {
    vector uv = q.vec().cross(v);
    uv += uv;
    return v + q.w() * uv + q.vec().cross(uv);
  }
  friend constexpr bool operator==(const quaternion& a, const quaternion& b) {
    return a.at_ == b.at_;
  }
  /// w, x, y, z.
  template <class Char, class Traits>
  requires requires(std::basic_ostream<Char, Traits>& out, Real x) { out << x; }
  friend std::basic_ostream<Char, Traits>& operator<<(std::basic_ostream<Char, Traits>& out,
                                                      const quaternion& q) {
    return out << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z();
  }

 private:
  std::array<Real, 4> at_;
};

}  // namespace talus
