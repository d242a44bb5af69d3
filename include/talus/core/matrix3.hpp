#pragma once
// Three times three numbers, as a value.
#include <cmath>
#include <cstddef>

#include "talus/core/vector3.hpp"

namespace talus {

/// Matrix of three rows and columns, stored column after column. Its functions are spelled as those
/// of Eigen, whose matrices convert from and to it. A matrix that is declared without a value has
/// none.
template <class Real>
class matrix3 {
 public:
  using Scalar = Real;

  matrix3() = default;
  /// Row by row.
  constexpr matrix3(Real xx, Real xy, Real xz, Real yx, Real yy, Real yz, Real zx, Real zy, Real zz)
      : at_{xx, yx, zx, xy, yy, zy, xz, yz, zz} {}
  template <detail::foreign_matrix<3, 3> M>
  matrix3(const M& m) {
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) (*this)(i, j) = static_cast<Real>(m(i, j));
  }
  template <class M>
  requires(detail::foreign_matrix<M, 3, 3>&& std::is_default_constructible_v<M>) operator M()
      const {
    M m;
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) m(i, j) = static_cast<typename M::Scalar>((*this)(i, j));
    return m;
  }

  [[nodiscard]] static constexpr matrix3 Zero() { return {0, 0, 0, 0, 0, 0, 0, 0, 0}; }
  [[nodiscard]] static constexpr matrix3 Identity() { return {1, 0, 0, 0, 1, 0, 0, 0, 1}; }

  [[nodiscard]] constexpr Real& operator()(std::ptrdiff_t i, std::ptrdiff_t j) {
    return at_[3 * j + i];
  }
  [[nodiscard]] constexpr const Real& operator()(std::ptrdiff_t i, std::ptrdiff_t j) const {
    return at_[3 * j + i];
  }
  [[nodiscard]] constexpr Real* data() { return at_; }
  [[nodiscard]] constexpr const Real* data() const { return at_; }
  [[nodiscard]] constexpr vector3<Real> col(std::ptrdiff_t j) const {
    return {at_[3 * j], at_[3 * j + 1], at_[3 * j + 2]};
  }
  [[nodiscard]] constexpr vector3<Real> row(std::ptrdiff_t i) const {
    return {at_[i], at_[3 + i], at_[6 + i]};
  }
  [[nodiscard]] constexpr vector3<Real> diagonal() const { return {at_[0], at_[4], at_[8]}; }
  void setZero() { *this = Zero(); }

  [[nodiscard]] constexpr matrix3 transpose() const {
    return {at_[0], at_[1], at_[2], at_[3], at_[4], at_[5], at_[6], at_[7], at_[8]};
  }
  [[nodiscard]] constexpr Real determinant() const {
    const matrix3& m = *this;
    const auto minor = [&](int a, int b, int c) {
      return m(0, a) * (m(1, b) * m(2, c) - m(1, c) * m(2, b));
    };
    return minor(0, 1, 2) - minor(1, 0, 2) + minor(2, 0, 1);
  }
  [[nodiscard]] constexpr matrix3 inverse() const {
    const vector3<Real> a = col(0), b = col(1), c = col(2);
    const vector3<Real> x = b.cross(c), y = c.cross(a), z = a.cross(b);
    return matrix3(x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]) / a.dot(x);
  }
  [[nodiscard]] Real norm() const {
    Real sum = 0;
    for (const Real x : at_) sum += x * x;
    return std::sqrt(sum);
  }

  friend constexpr matrix3 operator+(const matrix3& a, const matrix3& b) {
    matrix3 c;
    for (int k = 0; k < 9; ++k) c.at_[k] = a.at_[k] + b.at_[k];
    return c;
  }
  friend constexpr matrix3 operator-(const matrix3& a, const matrix3& b) {
    matrix3 c;
    for (int k = 0; k < 9; ++k) c.at_[k] = a.at_[k] - b.at_[k];
    return c;
  }
  friend constexpr matrix3 operator-(const matrix3& a) { return -1 * a; }
  template <detail::number S>
  friend constexpr matrix3 operator*(S s, const matrix3& a) {
    const auto f = static_cast<Real>(s);
    matrix3 c;
    for (int k = 0; k < 9; ++k) c.at_[k] = f * a.at_[k];
    return c;
  }
  template <detail::number S>
  friend constexpr matrix3 operator*(const matrix3& a, S s) {
    return s * a;
  }
  template <detail::number S>
  friend constexpr matrix3 operator/(const matrix3& a, S s) {
    const auto f = static_cast<Real>(s);
    matrix3 c;
    for (int k = 0; k < 9; ++k) c.at_[k] = a.at_[k] / f;
    return c;
  }
  friend constexpr matrix3 operator*(const matrix3& a, const matrix3& b) {
    matrix3 c;
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i)
        c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
    return c;
  }
  friend constexpr vector3<Real> operator*(const matrix3& a, const vector3<Real>& x) {
    return {a(0, 0) * x[0] + a(0, 1) * x[1] + a(0, 2) * x[2],
            a(1, 0) * x[0] + a(1, 1) * x[1] + a(1, 2) * x[2],
            a(2, 0) * x[0] + a(2, 1) * x[1] + a(2, 2) * x[2]};
  }
  friend constexpr bool operator==(const matrix3& a, const matrix3& b) {
    for (int k = 0; k < 9; ++k)
      if (!(a.at_[k] == b.at_[k])) return false;
    return true;
  }
  constexpr matrix3& operator+=(const matrix3& b) { return *this = *this + b; }
  constexpr matrix3& operator-=(const matrix3& b) { return *this = *this - b; }
  template <detail::number S>
  constexpr matrix3& operator*=(S s) {
    return *this = s * *this;
  }
  /// Row by row.
  template <class Char, class Traits>
  requires requires(std::basic_ostream<Char, Traits>& out, Real x) { out << x; }
  friend std::basic_ostream<Char, Traits>& operator<<(std::basic_ostream<Char, Traits>& out,
                                                      const matrix3& a) {
    return out << a.row(0) << '\n' << a.row(1) << '\n' << a.row(2);
  }

 private:
  Real at_[9];
};

namespace detail {

template <class T>
concept small_matrix = std::same_as<T, matrix3<double>> || std::same_as<T, matrix3<float>>;

/// The matrix with a_i b_j.
template <small_vector V>
[[nodiscard]] inline matrix3<typename V::Scalar> outer(const V& a, const V& b) {
  matrix3<typename V::Scalar> c;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) c(i, j) = a[i] * b[j];
  return c;
}
/// The matrix X with X b = a x b.
template <small_vector V>
[[nodiscard]] inline matrix3<typename V::Scalar> cross_matrix(const V& a) {
  return {0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0};
}
/// s on the diagonal.
template <class Real>
requires(std::is_arithmetic_v<Real>) [[nodiscard]] inline matrix3<Real> diagonal_matrix(Real s) {
  return {s, 0, 0, 0, s, 0, 0, 0, s};
}
template <small_vector V>
[[nodiscard]] inline matrix3<typename V::Scalar> diagonal_matrix(const V& d) {
  return {d[0], 0, 0, 0, d[1], 0, 0, 0, d[2]};
}
template <small_matrix M>
[[nodiscard]] inline typename M::Scalar trace(const M& a) {
  return a(0, 0) + a(1, 1) + a(2, 2);
}

}  // namespace detail
}  // namespace talus
