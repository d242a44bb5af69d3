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

/// The three components at `xyz` and the number that follows them in memory.
template <class Real>
[[nodiscard]] inline quad_of<Real> load(const vector3<Real>& xyz) {
  quad_of<Real> q;
  std::memcpy(&q, reinterpret_cast<const char*>(&xyz), sizeof q);
  return q;
}
template <class Real>
inline void store(vector3<Real>& xyz, const quad_of<Real>& q) {
  std::memcpy(reinterpret_cast<char*>(&xyz), &q, sizeof q);
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
