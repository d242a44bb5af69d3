#pragma once
// Four reals in one register (or two, or four, as the target has them): a vector and one more.
#include <cstring>

#include "talus/core/math.hpp"

namespace talus::detail {

// Without AVX a quad is two registers, and compilers remark on how such arguments are passed; all
// functions here are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

using quad = real __attribute__((vector_size(4 * sizeof(real))));

/// The three components at `xyz` and the number that follows them in memory.
[[nodiscard]] inline quad load(const vec3& xyz) {
  quad q;
  std::memcpy(&q, reinterpret_cast<const char*>(&xyz), sizeof q);
  return q;
}
inline void store(vec3& xyz, const quad& q) {
  std::memcpy(reinterpret_cast<char*>(&xyz), &q, sizeof q);
}
[[nodiscard]] inline vec3 xyz(const quad& q) { return {q[0], q[1], q[2]}; }

/// With 0 for the fourth number.
[[nodiscard]] inline quad without_fourth(const quad& q) {
  return __builtin_shufflevector(q, quad{0, 0, 0, 0}, 0, 1, 2, 4);
}
/// Of the four products.
[[nodiscard]] inline real sum_of_products(const quad& a, const quad& b) {
  const quad p = a * b;
  return (p[0] + p[2]) + (p[1] + p[3]);
}
/// The fourth number is 0 if it is for one of the two.
[[nodiscard]] inline quad cross(const quad& a, const quad& b) {
  const auto turn = [](const quad& q) { return __builtin_shufflevector(q, q, 1, 2, 0, 3); };
  return turn(a * turn(b) - turn(a) * b);
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
