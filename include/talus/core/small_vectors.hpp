#pragma once
// Sums and products of vectors and matrices of three, as values.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <type_traits>

namespace talus {

/// Column vector of three scalars in the frame of the world unless a name says otherwise.
template <class Real>
using vector3 = Eigen::Matrix<Real, 3, 1>;

template <class Real>
using matrix3 = Eigen::Matrix<Real, 3, 3>;

// Eigen makes a type of each expression, and each such type costs the compiler 20 ms or more: half
// of what a scenario took. For three numbers a value is as fast. Namespaces inside talus find these
// operators before Eigen's as long as they declare none of the same name.
namespace detail {
template <class T>
concept small_vector = std::same_as<T, vector3<double>> || std::same_as<T, vector3<float>>;
template <class T>
concept small_matrix = std::same_as<T, matrix3<double>> || std::same_as<T, matrix3<float>>;
template <class T>
concept number = std::is_arithmetic_v<T>;
template <class T>
inline constexpr bool is_transpose = false;
template <class M>
inline constexpr bool is_transpose<Eigen::Transpose<M>> = small_matrix<std::remove_const_t<M>>;
template <class T>
concept small_transpose = is_transpose<T>;
template <small_transpose T>
[[nodiscard]] inline matrix3<typename T::Scalar> written_out(const T& transpose) {
  const auto& a = transpose.nestedExpression();
  matrix3<typename T::Scalar> b;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) b(i, j) = a(j, i);
  return b;
}
}  // namespace detail

template <detail::small_vector V>
[[nodiscard]] inline V operator+(const V& a, const V& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <detail::small_vector V>
[[nodiscard]] inline V operator-(const V& a, const V& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <detail::small_vector V>
[[nodiscard]] inline V operator-(const V& a) {
  return {-a[0], -a[1], -a[2]};
}
template <detail::number S, detail::small_vector V>
[[nodiscard]] inline V operator*(S s, const V& a) {
  const auto f = static_cast<typename V::Scalar>(s);
  return {f * a[0], f * a[1], f * a[2]};
}
template <detail::number S, detail::small_vector V>
[[nodiscard]] inline V operator*(const V& a, S s) {
  return s * a;
}
template <detail::number S, detail::small_vector V>
[[nodiscard]] inline V operator/(const V& a, S s) {
  const auto f = static_cast<typename V::Scalar>(s);
  return {a[0] / f, a[1] / f, a[2] / f};
}
template <detail::small_vector V>
[[nodiscard]] inline bool operator==(const V& a, const V& b) {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}
template <detail::small_vector V>
inline V& operator+=(V& a, const V& b) {
  a[0] += b[0], a[1] += b[1], a[2] += b[2];
  return a;
}
template <detail::small_vector V>
inline V& operator-=(V& a, const V& b) {
  a[0] -= b[0], a[1] -= b[1], a[2] -= b[2];
  return a;
}
template <detail::number S, detail::small_vector V>
inline V& operator*=(V& a, S s) {
  return a = s * a;
}
template <detail::number S, detail::small_vector V>
inline V& operator/=(V& a, S s) {
  return a = a / s;
}

template <detail::small_matrix M>
[[nodiscard]] inline M operator+(const M& a, const M& b) {
  M c;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) c(i, j) = a(i, j) + b(i, j);
  return c;
}
template <detail::small_matrix M>
[[nodiscard]] inline M operator-(const M& a, const M& b) {
  M c;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) c(i, j) = a(i, j) - b(i, j);
  return c;
}
template <detail::number S, detail::small_matrix M>
[[nodiscard]] inline M operator*(S s, const M& a) {
  M c;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) c(i, j) = s * a(i, j);
  return c;
}
template <detail::small_matrix M>
inline M& operator+=(M& a, const M& b) {
  return a = a + b;
}
template <detail::small_matrix M>
[[nodiscard]] inline M operator*(const M& a, const M& b) {
  M c;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return c;
}
template <detail::small_matrix M, std::same_as<vector3<typename M::Scalar>> V>
[[nodiscard]] inline V operator*(const M& a, const V& x) {
  return {a(0, 0) * x[0] + a(0, 1) * x[1] + a(0, 2) * x[2],
          a(1, 0) * x[0] + a(1, 1) * x[1] + a(1, 2) * x[2],
          a(2, 0) * x[0] + a(2, 1) * x[1] + a(2, 2) * x[2]};
}
template <detail::small_transpose T, std::same_as<vector3<typename T::Scalar>> V>
[[nodiscard]] inline V operator*(const T& transpose, const V& x) {
  const auto& a = transpose.nestedExpression();
  return {a(0, 0) * x[0] + a(1, 0) * x[1] + a(2, 0) * x[2],
          a(0, 1) * x[0] + a(1, 1) * x[1] + a(2, 1) * x[2],
          a(0, 2) * x[0] + a(1, 2) * x[1] + a(2, 2) * x[2]};
}
template <detail::small_transpose T, std::same_as<matrix3<typename T::Scalar>> M>
[[nodiscard]] inline M operator*(const M& a, const T& transpose) {
  return a * detail::written_out(transpose);
}
template <detail::small_transpose T, std::same_as<matrix3<typename T::Scalar>> M>
[[nodiscard]] inline M operator*(const T& transpose, const M& b) {
  return detail::written_out(transpose) * b;
}

namespace detail {

/// The vector in another scalar; itself where that is its own.
template <class Real, small_vector V>
[[nodiscard]] [[gnu::always_inline]] inline decltype(auto) in_scalar(const V& a) {
  if constexpr (std::same_as<typename V::Scalar, Real>)
    return (a);
  else
    return vector3<Real>{static_cast<Real>(a[0]), static_cast<Real>(a[1]), static_cast<Real>(a[2])};
}

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
  matrix3<typename V::Scalar> x;
  x(0, 0) = 0, x(0, 1) = -a[2], x(0, 2) = a[1];
  x(1, 0) = a[2], x(1, 1) = 0, x(1, 2) = -a[0];
  x(2, 0) = -a[1], x(2, 1) = a[0], x(2, 2) = 0;
  return x;
}
/// s on the diagonal.
template <class Real>
[[nodiscard]] inline matrix3<Real> diagonal_matrix(Real s) {
  matrix3<Real> d;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) d(i, j) = i == j ? s : 0;
  return d;
}
template <small_matrix M>
[[nodiscard]] inline typename M::Scalar trace(const M& a) {
  return a(0, 0) + a(1, 1) + a(2, 2);
}
/// The largest component, whatever its sign.
template <small_vector V>
[[nodiscard]] inline typename V::Scalar max_norm(const V& a) {
  return std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])});
}
template <small_vector V>
[[nodiscard]] inline V lower_of(const V& a, const V& b) {
  return {std::min(a[0], b[0]), std::min(a[1], b[1]), std::min(a[2], b[2])};
}
template <small_vector V>
[[nodiscard]] inline V upper_of(const V& a, const V& b) {
  return {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])};
}
template <small_vector V>
[[nodiscard]] inline typename V::Scalar least_of(const V& a) {
  return std::min({a[0], a[1], a[2]});
}
/// The vector (x, x, x).
template <class Real>
[[nodiscard]] inline vector3<Real> thrice(Real x) {
  return {x, x, x};
}
/// Component by component.
template <small_vector V>
[[nodiscard]] inline V product(const V& a, const V& b) {
  return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}
template <small_vector V>
[[nodiscard]] inline bool all_finite(const V& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

}  // namespace detail
}  // namespace talus
