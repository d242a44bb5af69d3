#pragma once
// Eight numbers worked on at once, whatever the precision of velocities: see core/wide.hpp.
#include <cstdint>

#include "talus/core/wide.hpp"

namespace talus::detail {

// As with wides, everything here is inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

using octet = wide<double>;
using octet_rows = wide_rows<double>;
using octet_mask = std::int64_t __attribute__((vector_size(8 * sizeof(std::int64_t))));
static_assert(sizeof(real) == sizeof(double));

[[nodiscard]] [[gnu::always_inline]] inline octet eight(real x) { return every_lane<double>(x); }

/// Bit k is that of lane k.
[[nodiscard]] [[gnu::always_inline]] inline unsigned bits_of(const octet_mask& m) {
#if defined(__AVX512F__)
  return _mm512_cmplt_epi64_mask(reinterpret_cast<__m512i>(m), _mm512_setzero_si512());
#else
  unsigned bits = 0;
  for (int k = 0; k < 8; ++k) bits |= (m[k] != 0 ? 1u : 0u) << k;
  return bits;
#endif
}

template <class At>
[[nodiscard]] [[gnu::always_inline]] inline octet_rows gather(At&& at) {
  return gather<double>(at);
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
