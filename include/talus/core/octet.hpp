#pragma once
// Eight numbers worked on at once: one register, or two or four, as the target has them. The same
// arithmetic, to the bit, whatever the width.
#include <cmath>
#include <cstring>
#include <type_traits>

#include "talus/core/math.hpp"
#include "talus/core/quad.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace talus::detail {

// As with quads, everything here is inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <class Real>
struct octet_type;
template <>
struct octet_type<double> {
  using type = double __attribute__((vector_size(8 * sizeof(double))));
};
template <>
struct octet_type<float> {
  using type = float __attribute__((vector_size(8 * sizeof(float))));
};
template <class Real>
using octet_of = typename octet_type<Real>::type;

template <class Real>
[[nodiscard]] inline octet_of<Real> eight(Real x) {
  return octet_of<Real>{x, x, x, x, x, x, x, x};
}
/// Lane by lane, b where one of both is not a number (as std::max(b, a)).
template <class Octet>
[[nodiscard]] inline Octet larger(const Octet& a, const Octet& b) {
  return a > b ? a : b;
}

/// The widest register that takes some of an octet's lanes, and the square root of it.
template <class Real>
struct root_part {
  using type = Real;
  static type of(type p) { return std::sqrt(p); }
};
#if defined(__AVX__)
template <>
struct root_part<double> {
  using type = __m256d;
  static type of(type p) { return _mm256_sqrt_pd(p); }
};
template <>
struct root_part<float> {
  using type = __m256;
  static type of(type p) { return _mm256_sqrt_ps(p); }
};
#elif defined(__SSE2__)
template <>
struct root_part<double> {
  using type = __m128d;
  static type of(type p) { return _mm_sqrt_pd(p); }
};
template <>
struct root_part<float> {
  using type = __m128;
  static type of(type p) { return _mm_sqrt_ps(p); }
};
#endif
template <class Octet>
[[nodiscard]] inline Octet square_root(Octet x) {
  using parted = root_part<lane_of<Octet>>;
#if defined(__AVX512F__)
  if constexpr (sizeof x == 64)
    return _mm512_maskz_sqrt_pd(0xff, x);
  else
#endif
  {
    typename parted::type parts[sizeof x / sizeof(typename parted::type)];
    std::memcpy(parts, &x, sizeof x);
    for (auto& p : parts) p = parted::of(p);
    std::memcpy(&x, parts, sizeof x);
    return x;
  }
}

/// Three components and one more number of eight things.
template <class Real>
struct octet_rows {
  octet_of<Real> x, y, z, w;
};

/// Eight quads, one of each thing, to four octets, one of each component. Quads come as (i, i + 4)
/// in one register, so that all but two of the shuffles stay within halves.
template <class Octet>
[[nodiscard]] inline octet_rows<lane_of<Octet>> transposed(const Octet (&pairs)[4]) {
  const auto p = __builtin_shufflevector(pairs[0], pairs[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const auto q = __builtin_shufflevector(pairs[0], pairs[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const auto r = __builtin_shufflevector(pairs[2], pairs[3], 0, 8, 2, 10, 4, 12, 6, 14);
  const auto t = __builtin_shufflevector(pairs[2], pairs[3], 1, 9, 3, 11, 5, 13, 7, 15);
  return {__builtin_shufflevector(p, r, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(q, t, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(p, r, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(q, t, 2, 3, 10, 11, 6, 7, 14, 15)};
}

template <class Quad>
[[nodiscard]] inline octet_of<lane_of<Quad>> side_by_side(const Quad& low, const Quad& high) {
#if defined(__AVX512F__)
  if constexpr (sizeof(Quad) == 32)
    return _mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(low), high, 1);
  else
#endif
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// `at(i)` is where the quad of thing i begins: a vector and the number behind it.
template <class Real, class At>
[[nodiscard]] inline octet_rows<Real> gather(At&& at) {
  octet_of<Real> pairs[4];
  for (int i = 0; i < 4; ++i) pairs[i] = side_by_side(load(at(i)), load(at(i + 4)));
  return transposed(pairs);
}
/// The reverse, thing 0 last: it wins where several are the same.
template <class Real, class At>
inline void scatter(const octet_rows<Real>& rows, At&& at) {
  const auto p = __builtin_shufflevector(rows.x, rows.y, 0, 8, 2, 10, 4, 12, 6, 14);
  const auto q = __builtin_shufflevector(rows.x, rows.y, 1, 9, 3, 11, 5, 13, 7, 15);
  const auto r = __builtin_shufflevector(rows.z, rows.w, 0, 8, 2, 10, 4, 12, 6, 14);
  const auto t = __builtin_shufflevector(rows.z, rows.w, 1, 9, 3, 11, 5, 13, 7, 15);
  const octet_of<Real> pairs[4] = {__builtin_shufflevector(p, r, 0, 1, 8, 9, 4, 5, 12, 13),
                                   __builtin_shufflevector(q, t, 0, 1, 8, 9, 4, 5, 12, 13),
                                   __builtin_shufflevector(p, r, 2, 3, 10, 11, 6, 7, 14, 15),
                                   __builtin_shufflevector(q, t, 2, 3, 10, 11, 6, 7, 14, 15)};
  for (int i = 3; i >= 0; --i) {
    store<Real>(at(i + 4), __builtin_shufflevector(pairs[i], pairs[i], 4, 5, 6, 7));
    store<Real>(at(i), __builtin_shufflevector(pairs[i], pairs[i], 0, 1, 2, 3));
  }
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
