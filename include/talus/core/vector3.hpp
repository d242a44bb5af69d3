#pragma once
// Three numbers, as a value: nothing but the numbers, so that copying bytes copies the vector.
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <iosfwd>
#include <type_traits>

namespace talus {

namespace detail {
template <class T>
concept number = std::is_arithmetic_v<T>;

/// A vector of another library: it knows its length at compile time, and gives its components by
/// (i), as Eigen's vectors and expressions do.
template <class V, int Size>
concept foreign_vector = requires(const V& v) {
  requires V::SizeAtCompileTime == Size;
  { v(0) } -> std::convertible_to<double>;
};
/// A matrix of another library: its size is known at compile time, and m(i, j) returns its
/// elements, as for Eigen's matrices and expressions.
template <class M, int Rows, int Columns>
concept foreign_matrix = requires(const M& m) {
  requires M::RowsAtCompileTime == Rows&& M::ColsAtCompileTime == Columns;
  { m(0, 0) } -> std::convertible_to<double>;
};
}  // namespace detail

/// Column vector of three scalars in the frame of the world unless a name says otherwise. Its
/// functions are spelled as those of Eigen, whose vectors convert from and to it. A vector that is
/// declared without a value has none.
template <class Real>
class vector3 {
 public:
  using Scalar = Real;

  vector3() = default;
  constexpr vector3(Real x, Real y, Real z) : at_{x, y, z} {}
  template <detail::foreign_vector<3> V>
  vector3(const V& v)
      : at_{static_cast<Real>(v(0)), static_cast<Real>(v(1)), static_cast<Real>(v(2))} {}
  template <class V>
  requires(detail::foreign_vector<V, 3>&& std::is_default_constructible_v<V>) operator V() const {
    V v;
    for (int k = 0; k < 3; ++k) v(k) = static_cast<typename V::Scalar>(at_[k]);
    return v;
  }

  [[nodiscard]] static constexpr vector3 Zero() { return {0, 0, 0}; }
  [[nodiscard]] static constexpr vector3 Ones() { return {1, 1, 1}; }
  [[nodiscard]] static constexpr vector3 Constant(Real x) { return {x, x, x}; }
  [[nodiscard]] static constexpr vector3 Unit(std::ptrdiff_t axis) {
    vector3 e = Zero();
    e.at_[axis] = 1;
    return e;
  }
  [[nodiscard]] static constexpr vector3 UnitX() { return {1, 0, 0}; }
  [[nodiscard]] static constexpr vector3 UnitY() { return {0, 1, 0}; }
  [[nodiscard]] static constexpr vector3 UnitZ() { return {0, 0, 1}; }

  [[nodiscard]] constexpr Real& operator[](std::ptrdiff_t i) { return at_[i]; }
  [[nodiscard]] constexpr const Real& operator[](std::ptrdiff_t i) const { return at_[i]; }
  [[nodiscard]] constexpr Real& operator()(std::ptrdiff_t i) { return at_[i]; }
  [[nodiscard]] constexpr const Real& operator()(std::ptrdiff_t i) const { return at_[i]; }
  [[nodiscard]] constexpr Real& x() { return at_[0]; }
  [[nodiscard]] constexpr Real& y() { return at_[1]; }
  [[nodiscard]] constexpr Real& z() { return at_[2]; }
  [[nodiscard]] constexpr Real x() const { return at_[0]; }
  [[nodiscard]] constexpr Real y() const { return at_[1]; }
  [[nodiscard]] constexpr Real z() const { return at_[2]; }
  [[nodiscard]] constexpr Real* data() { return at_; }
  [[nodiscard]] constexpr const Real* data() const { return at_; }
  [[nodiscard]] constexpr Real* begin() { return at_; }
  [[nodiscard]] constexpr Real* end() { return at_ + 3; }
  [[nodiscard]] constexpr const Real* begin() const { return at_; }
  [[nodiscard]] constexpr const Real* end() const { return at_ + 3; }
  [[nodiscard]] static constexpr std::ptrdiff_t size() { return 3; }

  [[nodiscard]] constexpr Real dot(const vector3& b) const {
    return at_[0] * b[0] + at_[1] * b[1] + at_[2] * b[2];
  }
  [[nodiscard]] constexpr vector3 cross(const vector3& b) const {
    return {at_[1] * b[2] - at_[2] * b[1], at_[2] * b[0] - at_[0] * b[2],
            at_[0] * b[1] - at_[1] * b[0]};
  }
  [[nodiscard]] constexpr Real squaredNorm() const { return dot(*this); }
  [[nodiscard]] Real norm() const { return std::sqrt(squaredNorm()); }
  /// At length one; the zero vector stays.
  [[nodiscard]] vector3 normalized() const {
    const Real square = squaredNorm();
    if (!(square > 0)) return *this;
    const Real length = std::sqrt(square);
    return {at_[0] / length, at_[1] / length, at_[2] / length};
  }
  void normalize() { *this = normalized(); }
  void setZero() { *this = Zero(); }

  // Component by component.
  [[nodiscard]] constexpr vector3 cwiseProduct(const vector3& b) const {
    return {at_[0] * b[0], at_[1] * b[1], at_[2] * b[2]};
  }
  [[nodiscard]] constexpr vector3 cwiseQuotient(const vector3& b) const {
    return {at_[0] / b[0], at_[1] / b[1], at_[2] / b[2]};
  }
  [[nodiscard]] constexpr vector3 cwiseInverse() const {
    return {1 / at_[0], 1 / at_[1], 1 / at_[2]};
  }
  [[nodiscard]] vector3 cwiseAbs() const {
    return {std::abs(at_[0]), std::abs(at_[1]), std::abs(at_[2])};
  }
  [[nodiscard]] constexpr vector3 cwiseMin(const vector3& b) const {
    return {std::min(at_[0], b[0]), std::min(at_[1], b[1]), std::min(at_[2], b[2])};
  }
  [[nodiscard]] constexpr vector3 cwiseMax(const vector3& b) const {
    return {std::max(at_[0], b[0]), std::max(at_[1], b[1]), std::max(at_[2], b[2])};
  }

  [[nodiscard]] constexpr Real sum() const { return at_[0] + at_[1] + at_[2]; }
  [[nodiscard]] constexpr Real minCoeff() const { return std::min({at_[0], at_[1], at_[2]}); }
  [[nodiscard]] constexpr Real maxCoeff() const { return std::max({at_[0], at_[1], at_[2]}); }
  /// The largest component, and which one it is: the first of equal ones.
  template <std::integral Index>
  constexpr Real maxCoeff(Index* axis) const {
    *axis = 0;
    for (int k = 1; k < 3; ++k)
      if (at_[k] > at_[*axis]) *axis = static_cast<Index>(k);
    return at_[*axis];
  }
  [[nodiscard]] bool allFinite() const {
    return std::isfinite(at_[0]) && std::isfinite(at_[1]) && std::isfinite(at_[2]);
  }
  /// Whether the difference is small against the shorter of the two.
  [[nodiscard]] bool isApprox(const vector3& b, Real part = Real(1e-12)) const {
    return (*this - b).squaredNorm() <= part * part * std::min(squaredNorm(), b.squaredNorm());
  }
  template <class Other>
  [[nodiscard]] constexpr vector3<Other> cast() const {
    return {static_cast<Other>(at_[0]), static_cast<Other>(at_[1]), static_cast<Other>(at_[2])};
  }

  friend constexpr vector3 operator+(const vector3& a, const vector3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
  }
  friend constexpr vector3 operator-(const vector3& a, const vector3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  }
  friend constexpr vector3 operator-(const vector3& a) { return {-a[0], -a[1], -a[2]}; }
  template <detail::number S>
  friend constexpr vector3 operator*(S s, const vector3& a) {
    const auto f = static_cast<Real>(s);
    return {f * a[0], f * a[1], f * a[2]};
  }
  template <detail::number S>
  friend constexpr vector3 operator*(const vector3& a, S s) {
    return s * a;
  }
  template <detail::number S>
  friend constexpr vector3 operator/(const vector3& a, S s) {
    const auto f = static_cast<Real>(s);
    return {a[0] / f, a[1] / f, a[2] / f};
  }
  friend constexpr bool operator==(const vector3& a, const vector3& b) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
  }
  constexpr vector3& operator+=(const vector3& b) { return *this = *this + b; }
  constexpr vector3& operator-=(const vector3& b) { return *this = *this - b; }
  template <detail::number S>
  constexpr vector3& operator*=(S s) {
    return *this = s * *this;
  }
  template <detail::number S>
  constexpr vector3& operator/=(S s) {
    return *this = *this / s;
  }
  /// The components with blanks between them.
  template <class Char, class Traits>
  requires requires(std::basic_ostream<Char, Traits>& out, Real x) { out << x; }
  friend std::basic_ostream<Char, Traits>& operator<<(std::basic_ostream<Char, Traits>& out,
                                                      const vector3& a) {
    return out << a[0] << ' ' << a[1] << ' ' << a[2];
  }

 private:
  Real at_[3];
};

namespace detail {

template <class T>
concept small_vector = std::same_as<T, vector3<double>> || std::same_as<T, vector3<float>>;

/// The vector in another scalar; itself where that is its own.
template <class Real, small_vector V>
[[nodiscard]] [[gnu::always_inline]] inline decltype(auto) in_scalar(const V& a) {
  if constexpr (std::same_as<typename V::Scalar, Real>)
    return (a);
  else
    return a.template cast<Real>();
}
/// The largest component, whatever its sign.
template <small_vector V>
[[nodiscard]] inline typename V::Scalar max_norm(const V& a) {
  return a.cwiseAbs().maxCoeff();
}
template <small_vector V>
[[nodiscard]] inline V lower_of(const V& a, const V& b) {
  return a.cwiseMin(b);
}
template <small_vector V>
[[nodiscard]] inline V upper_of(const V& a, const V& b) {
  return a.cwiseMax(b);
}
template <small_vector V>
[[nodiscard]] inline typename V::Scalar least_of(const V& a) {
  return a.minCoeff();
}
// As functions, which packs of vectors have too.
template <class Real>
[[nodiscard]] [[gnu::always_inline]] inline Real dot(const vector3<Real>& a,
                                                     const vector3<Real>& b) {
  return a.dot(b);
}
template <class Real>
[[nodiscard]] [[gnu::always_inline]] inline vector3<Real> crossed(const vector3<Real>& a,
                                                                  const vector3<Real>& b) {
  return a.cross(b);
}
/// The vector (x, x, x).
template <class Real>
[[nodiscard]] inline vector3<Real> thrice(Real x) {
  return {x, x, x};
}
template <small_vector V>
[[nodiscard]] inline V product(const V& a, const V& b) {
  return a.cwiseProduct(b);
}
template <small_vector V>
[[nodiscard]] inline bool all_finite(const V& a) {
  return a.allFinite();
}

}  // namespace detail
}  // namespace talus
