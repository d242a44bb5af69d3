#pragma once
// Eight reals worked on at once: one register, or two or four, as the target has them. The same
// arithmetic, to the bit, whatever the width.
#include <cmath>
#include <cstdint>
#include <cstring>

#include "talus/core/math.hpp"
#include "talus/core/quad.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace talus::detail {

// As with quads, everything here is inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

using octet = real __attribute__((vector_size(8 * sizeof(real))));
using octet_mask = std::int64_t __attribute__((vector_size(8 * sizeof(std::int64_t))));
static_assert(sizeof(real) == sizeof(std::int64_t));

[[nodiscard]] inline octet eight(real x) { return octet{x, x, x, x, x, x, x, x}; }
/// Lane by lane, b where one of both is not a number (as std::max(b, a)).
[[nodiscard]] inline octet larger(const octet& a, const octet& b) { return a > b ? a : b; }
[[nodiscard]] inline octet square_root(octet x) {
#if defined(__AVX512F__)
  return _mm512_maskz_sqrt_pd(0xff, x);
#else
#if defined(__AVX__)
  using part = __m256d;
  const auto root = [](part p) { return _mm256_sqrt_pd(p); };
#elif defined(__SSE2__)
  using part = __m128d;
  const auto root = [](part p) { return _mm_sqrt_pd(p); };
#else
  using part = real;
  const auto root = [](part p) { return std::sqrt(p); };
#endif
  part parts[sizeof(octet) / sizeof(part)];
  std::memcpy(parts, &x, sizeof x);
  for (part& p : parts) p = root(p);
  std::memcpy(&x, parts, sizeof x);
  return x;
#endif
}

/// Bit k is that of lane k.
[[nodiscard]] inline unsigned bits_of(const octet_mask& m) {
#if defined(__AVX512F__)
  return _mm512_cmplt_epi64_mask(reinterpret_cast<__m512i>(m), _mm512_setzero_si512());
#else
  unsigned bits = 0;
  for (int k = 0; k < 8; ++k) bits |= (m[k] != 0 ? 1u : 0u) << k;
  return bits;
#endif
}

/// Three components and one more number of eight things.
struct octet_rows {
  octet x, y, z, w;
};

/// Eight quads, one of each thing, to four octets, one of each component. Quads come as (i, i + 4)
/// in one register, so that all but two of the shuffles stay within halves.
[[nodiscard]] inline octet_rows transposed(const octet (&pairs)[4]) {
  const octet p = __builtin_shufflevector(pairs[0], pairs[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const octet q = __builtin_shufflevector(pairs[0], pairs[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const octet r = __builtin_shufflevector(pairs[2], pairs[3], 0, 8, 2, 10, 4, 12, 6, 14);
  const octet t = __builtin_shufflevector(pairs[2], pairs[3], 1, 9, 3, 11, 5, 13, 7, 15);
  return {__builtin_shufflevector(p, r, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(q, t, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(p, r, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(q, t, 2, 3, 10, 11, 6, 7, 14, 15)};
}

[[nodiscard]] inline octet side_by_side(const quad& low, const quad& high) {
#if defined(__AVX512F__)
  return _mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(low), high, 1);
#else
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}

/// `at(i)` is where the quad of thing i begins: a vector and the number behind it.
template <class At>
[[nodiscard]] inline octet_rows gather(At&& at) {
  octet pairs[4];
  for (int i = 0; i < 4; ++i) pairs[i] = side_by_side(load(at(i)), load(at(i + 4)));
  return transposed(pairs);
}
/// The reverse, thing 0 last: it wins where several are the same.
template <class At>
inline void scatter(const octet_rows& rows, At&& at) {
  const octet p = __builtin_shufflevector(rows.x, rows.y, 0, 8, 2, 10, 4, 12, 6, 14);
  const octet q = __builtin_shufflevector(rows.x, rows.y, 1, 9, 3, 11, 5, 13, 7, 15);
  const octet r = __builtin_shufflevector(rows.z, rows.w, 0, 8, 2, 10, 4, 12, 6, 14);
  const octet t = __builtin_shufflevector(rows.z, rows.w, 1, 9, 3, 11, 5, 13, 7, 15);
  const octet pairs[4] = {__builtin_shufflevector(p, r, 0, 1, 8, 9, 4, 5, 12, 13),
                          __builtin_shufflevector(q, t, 0, 1, 8, 9, 4, 5, 12, 13),
                          __builtin_shufflevector(p, r, 2, 3, 10, 11, 6, 7, 14, 15),
                          __builtin_shufflevector(q, t, 2, 3, 10, 11, 6, 7, 14, 15)};
  for (int i = 3; i >= 0; --i) {
    store(at(i + 4), __builtin_shufflevector(pairs[i], pairs[i], 4, 5, 6, 7));
    store(at(i), __builtin_shufflevector(pairs[i], pairs[i], 0, 1, 2, 3));
  }
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
