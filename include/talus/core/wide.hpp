#pragma once
// Eight doubles or sixteen floats worked on at once: one register, or two or four, as the target
// has them. The same arithmetic, to the bit, whatever the width.
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
struct wide_type;
template <>
struct wide_type<double> {
  using type = double __attribute__((vector_size(8 * sizeof(double))));
};
template <>
struct wide_type<float> {
  using type = float __attribute__((vector_size(16 * sizeof(float))));
};
template <class Real>
using wide = typename wide_type<Real>::type;

/// Numbers in a wide.
template <class Real>
inline constexpr int lanes_in = sizeof(wide<Real>) / sizeof(Real);

template <class Real>
[[nodiscard]] [[gnu::always_inline]] inline wide<Real> every_lane(Real x) {
  return x - wide<Real>{};
}
/// Lane by lane, b where one of both is not a number (as std::max(b, a)).
template <class Wide>
[[nodiscard]] [[gnu::always_inline]] inline Wide larger(const Wide& a, const Wide& b) {
  return a > b ? a : b;
}

/// The widest register for a part of the lanes, and its square root.
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
template <class Wide>
[[nodiscard]] [[gnu::always_inline]] inline Wide square_root(Wide x) {
#if defined(__AVX512F__)
  if constexpr (sizeof(lane_of<Wide>) == 8)
    return _mm512_maskz_sqrt_pd(0xff, x);
  else
    return _mm512_maskz_sqrt_ps(0xffff, x);
#else
  using parted = root_part<lane_of<Wide>>;
  {
    typename parted::type parts[sizeof x / sizeof(typename parted::type)];
    std::memcpy(parts, &x, sizeof x);
    for (auto& p : parts) p = parted::of(p);
    std::memcpy(&x, parts, sizeof x);
    return x;
  }
#endif
}

/// Three components and one more number of as many things as there are lanes.
template <class Real>
struct wide_rows {
  wide<Real> x, y, z, w;
};

/// A quad of each thing to a wide of each component, or the reverse. Quads come as (i, i + 4), or
/// (i, i + 4, i + 8, i + 12), in one register, so that with floats all shuffles stay within quads,
/// and with doubles within pairs of them.
template <class Wide>
[[nodiscard]] [[gnu::always_inline]] inline wide_rows<lane_of<Wide>> transposed(const Wide& a,
                                                                                const Wide& b,
                                                                                const Wide& c,
                                                                                const Wide& d) {
  if constexpr (sizeof(lane_of<Wide>) == 8) {
    const Wide p = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    const Wide q = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
    const Wide r = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
    const Wide t = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
    return {__builtin_shufflevector(p, r, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(q, t, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(p, r, 2, 3, 10, 11, 6, 7, 14, 15),
            __builtin_shufflevector(q, t, 2, 3, 10, 11, 6, 7, 14, 15)};
  } else {
    const Wide p =
        __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
    const Wide q =
        __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
    const Wide r =
        __builtin_shufflevector(c, d, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
    const Wide t =
        __builtin_shufflevector(c, d, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
    return {
        __builtin_shufflevector(p, r, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
        __builtin_shufflevector(p, r, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31),
        __builtin_shufflevector(q, t, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
        __builtin_shufflevector(q, t, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)};
  }
}

[[nodiscard]] [[gnu::always_inline]] inline wide<double> side_by_side(const quad_of<double>& low,
                                                                      const quad_of<double>& high) {
#if defined(__AVX512F__)
  return _mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(low), high, 1);
#else
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}
[[nodiscard]] [[gnu::always_inline]] inline wide<float> side_by_side(const quad_of<float>& a,
                                                                     const quad_of<float>& b,
                                                                     const quad_of<float>& c,
                                                                     const quad_of<float>& d) {
#if defined(__AVX512F__)
  const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(a), b, 1);
  const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(c), d, 1);
  return _mm512_castpd_ps(_mm512_maskz_insertf64x4(
      0xff, _mm512_castpd256_pd512(_mm256_castps_pd(low)), _mm256_castps_pd(high), 1));
#else
  const auto low = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
  const auto high = __builtin_shufflevector(c, d, 0, 1, 2, 3, 4, 5, 6, 7);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#endif
}

/// `at(i)` is the row of thing i: a vector and the number behind it.
template <class Real, class At>
[[nodiscard]] [[gnu::always_inline]] inline wide_rows<Real> gather(At&& at) {
  wide<Real> pairs[4];
  for (int i = 0; i < 4; ++i)
    if constexpr (lanes_in<Real> == 8)
      pairs[i] = side_by_side(load(at(i)), load(at(i + 4)));
    else
      pairs[i] = side_by_side(load(at(i)), load(at(i + 4)), load(at(i + 8)), load(at(i + 12)));
  return transposed(pairs[0], pairs[1], pairs[2], pairs[3]);
}
/// The reverse, thing 0 last: it wins where several are the same.
template <class Real, class At>
[[gnu::always_inline]] inline void scatter(const wide_rows<Real>& rows, At&& at) {
  const wide_rows<Real> turned = transposed(rows.x, rows.y, rows.z, rows.w);
  const wide<Real> pairs[4] = {turned.x, turned.y, turned.z, turned.w};
  for (int i = 3; i >= 0; --i) {
    const auto& x = pairs[i];
    if constexpr (lanes_in<Real> == 16) {
      store(at(i + 12), __builtin_shufflevector(x, x, 12, 13, 14, 15));
      store(at(i + 8), __builtin_shufflevector(x, x, 8, 9, 10, 11));
    }
    store(at(i + 4), __builtin_shufflevector(x, x, 4, 5, 6, 7));
    store(at(i), __builtin_shufflevector(x, x, 0, 1, 2, 3));
  }
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
