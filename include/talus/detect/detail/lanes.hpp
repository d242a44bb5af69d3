#pragma once
// The distance test of one ball against eight at a time, in the widest registers of the target.
#include <cstdint>
#include <cstring>

#include "talus/core/math.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace talus::detail {

inline constexpr std::uint32_t lanes = 8;

struct ball {
  real x, y, z, reach;
};

// The register and the comparison whose result is a bit for each lane.
#if defined(__AVX512F__)
using ball_register = __m512d;
inline std::uint32_t not_above(ball_register a, ball_register b) {
  return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ);
}
#elif defined(__AVX__)
using ball_register = __m256d;
inline std::uint32_t not_above(ball_register a, ball_register b) {
  return static_cast<std::uint32_t>(_mm256_movemask_pd(_mm256_cmp_pd(a, b, _CMP_LE_OQ)));
}
#elif defined(__SSE2__)
using ball_register = __m128d;
inline std::uint32_t not_above(ball_register a, ball_register b) {
  return static_cast<std::uint32_t>(_mm_movemask_pd(_mm_cmple_pd(a, b)));
}
#else
using ball_register = real;
inline std::uint32_t not_above(ball_register a, ball_register b) { return a <= b; }
#endif

/// Bit q is set if the ball touches the q-th of eight balls given as arrays of their coordinates.
/// The result is the same, to the bit, for any width of registers.
inline std::uint32_t touching(const ball& a, const real* x, const real* y, const real* z,
                              const real* reach) {
  constexpr std::uint32_t width = sizeof(ball_register) / sizeof(real);
  std::uint32_t bits = 0;
  for (std::uint32_t q = 0; q < lanes; q += width) {
    ball_register dx, dy, dz, sum;
    std::memcpy(&dx, x + q, sizeof dx);
    std::memcpy(&dy, y + q, sizeof dy);
    std::memcpy(&dz, z + q, sizeof dz);
    std::memcpy(&sum, reach + q, sizeof sum);
    dx = a.x - dx, dy = a.y - dy, dz = a.z - dz, sum = a.reach + sum;
    bits |= not_above(dx * dx + dy * dy + dz * dz, sum * sum) << q;
  }
  return bits;
}

}  // namespace talus::detail
