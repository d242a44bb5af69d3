#pragma once
// Four numbers in one register (or two, or four, as the target has them): a vector and one more.
#include <cstring>
#include <type_traits>
#include <utility>

#include "talus/core/math.hpp"

namespace talus::detail {

// Without AVX a quad of doubles is two registers, and compilers remark on how such arguments are
// passed; all functions here are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <class Real>
struct quad_type;
template <>
struct quad_type<double> {
  using type = double __attribute__((vector_size(4 * sizeof(double))));
};
template <>
struct quad_type<float> {
  using type = float __attribute__((vector_size(4 * sizeof(float))));
};
template <class Real>
using quad_of = typename quad_type<Real>::type;
using quad = quad_of<real>;

/// The number of which a quad has four; of wider vectors too.
template <class Lanes>
using lane_of = std::remove_cvref_t<decltype(std::declval<const Lanes&>()[0])>;

/// Where four numbers begin that follow each other in one object.
template <class Real, class Byte>
struct row_at {
  Byte* begin;
};
/// The three components of a vector, or a number, and what follows in the object that it is part
/// of: bytes of that object, so that nothing is read beyond it.
template <class Real, class Whole, class Part>
[[nodiscard]] [[gnu::always_inline]] inline auto row_from(Whole& whole, const Part& part) {
  static_assert(std::is_trivially_copyable_v<Whole>, "its bytes are copied");
  using byte = std::conditional_t<std::is_const_v<Whole>, const char, char>;
  const auto offset = reinterpret_cast<const char*>(&part) - reinterpret_cast<const char*>(&whole);
  return row_at<Real, byte>{reinterpret_cast<byte*>(&whole) + offset};
}
template <class Whole, class Real>
[[nodiscard]] [[gnu::always_inline]] inline auto row_of(Whole& whole, const vector3<Real>& part) {
  return row_from<Real>(whole, part);
}
template <class Real, class Byte>
[[nodiscard]] [[gnu::always_inline]] inline quad_of<Real> load(const row_at<Real, Byte>& row) {
  quad_of<Real> q;
  std::memcpy(&q, row.begin, sizeof q);
  return q;
}
template <class Real>
[[gnu::always_inline]] inline void store(const row_at<Real, char>& row, const quad_of<Real>& q) {
  std::memcpy(row.begin, &q, sizeof q);
}
template <class Quad>
[[nodiscard]] inline vector3<lane_of<Quad>> xyz(const Quad& q) {
  return {q[0], q[1], q[2]};
}

/// With 0 for the fourth number.
template <class Quad>
[[nodiscard]] inline Quad without_fourth(const Quad& q) {
  return __builtin_shufflevector(q, Quad{0, 0, 0, 0}, 0, 1, 2, 4);
}
/// Of the four products.
template <class Quad>
[[nodiscard]] inline lane_of<Quad> sum_of_products(const Quad& a, const Quad& b) {
  const Quad p = a * b;
  return (p[0] + p[2]) + (p[1] + p[3]);
}
/// The fourth number is 0 if it is for one of the two.
template <class Quad>
[[nodiscard]] inline Quad cross(const Quad& a, const Quad& b) {
  const auto turn = [](const Quad& q) { return __builtin_shufflevector(q, q, 1, 2, 0, 3); };
  return turn(a * turn(b) - turn(a) * b);
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
