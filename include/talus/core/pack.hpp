#pragma once
// Several numbers worked on at once, lane by lane: the same arithmetic, to the bit, in whatever
// registers the target has.
#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

#include "talus/core/math.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace talus::detail {

// A pack may be several registers, and compilers remark on how such arguments are passed; all
// functions of packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

template <class T, int N>
struct pack_type {
  typedef T type __attribute__((vector_size(N * sizeof(T))));  // of an alias g++ drops it
};
template <class T>
struct pack_type<T, 1> {
  using type = T;
};
/// N numbers, where N is a power of two. One lane is the number itself, so that what is written for
/// packs computes single numbers too.
template <class T, int N>
using pack = typename pack_type<T, N>::type;

template <class Pack>
struct lane_type {
  using type = std::remove_cvref_t<decltype(std::declval<const Pack&>()[0])>;
};
template <class Pack>
requires std::is_arithmetic_v<Pack>
struct lane_type<Pack> {
  using type = Pack;
};
/// The number of which a pack has several.
template <class Pack>
using lane_of = typename lane_type<std::remove_cvref_t<Pack>>::type;
/// How many.
template <class Pack>
inline constexpr int lanes_of = sizeof(Pack) / sizeof(lane_of<Pack>);
/// What a comparison of packs gives: all bits or none in each lane; of one lane a bool.
template <class Pack>
using mask_of = std::remove_cvref_t<decltype(std::declval<Pack>() < std::declval<Pack>())>;

/// A pack of as many numbers as fill a cache line, 64 bytes: eight doubles, sixteen floats.
template <class Real>
using wide_pack = pack<Real, 64 / sizeof(Real)>;

template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack every_lane(lane_of<Pack> x) {
  return x - Pack{};
}
/// Lane by lane, a where the mask holds, b elsewhere.
template <class Mask, class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack choose(const Mask& m, const Pack& a,
                                                        const Pack& b) {
#if !defined(__AVX512F__)
  // Of packs wider than a register g++ would choose lane by lane.
  if constexpr (lanes_of < Pack >> 1 && sizeof(Pack) == sizeof(Mask))
    return reinterpret_cast<Pack>((m & reinterpret_cast<Mask>(a)) |
                                  (~m & reinterpret_cast<Mask>(b)));
  else
#endif
    return m ? a : b;
}
/// Lane by lane, b where one of both is not a number (as std::max(b, a)).
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack larger(const Pack& a, const Pack& b) {
  return choose(a > b, a, b);
}
/// Lane by lane, b where one of both is not a number (as std::min(b, a)).
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack smaller(const Pack& a, const Pack& b) {
  return choose(a < b, a, b);
}
/// Lane by lane the number without its sign.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack size_of_lanes(const Pack& x) {
  using mask = mask_of<Pack>;
  const auto sign = reinterpret_cast<mask>(every_lane<Pack>(lane_of<Pack>(-0.0)));
  return reinterpret_cast<Pack>(reinterpret_cast<mask>(x) & ~sign);
}

/// The widest register for a part of the lanes, and its square root.
template <class Real>
struct root_part_of_one {
  using type = Real;
  static type of(type p) { return std::sqrt(p); }
};
template <class Real>
struct root_part : root_part_of_one<Real> {};
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
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack square_root(Pack x) {
  using number = lane_of<Pack>;
  if constexpr (lanes_of<Pack> == 1) {
    return std::sqrt(x);
#if defined(__AVX512F__)
  } else if constexpr (sizeof x == 64 && sizeof(number) == 8) {
    return _mm512_maskz_sqrt_pd(0xff, x);
  } else if constexpr (sizeof x == 64) {
    return _mm512_maskz_sqrt_ps(0xffff, x);
#endif
  } else {
    using part = std::conditional_t<sizeof x % sizeof(typename root_part<number>::type) == 0,
                                    root_part<number>, root_part_of_one<number>>;
    typename part::type parts[sizeof x / sizeof(typename part::type)];
    std::memcpy(parts, &x, sizeof x);
    for (auto& p : parts) p = part::of(p);
    std::memcpy(&x, parts, sizeof x);
    return x;
  }
}

/// The lanes where m does not hold.
template <class Mask>
[[nodiscard]] [[gnu::always_inline]] inline Mask inverted(const Mask& m) {
  if constexpr (std::is_same_v<Mask, bool>)
    return !m;
  else
    return ~m;
}
/// The lanes where both hold.
template <class Mask>
[[nodiscard]] [[gnu::always_inline]] inline Mask both(const Mask& a, const Mask& b) {
  if constexpr (std::is_same_v<Mask, bool>)
    return a && b;
  else
    return a & b;
}
/// The lanes where one of them holds, or both.
template <class Mask>
[[nodiscard]] [[gnu::always_inline]] inline Mask either(const Mask& a, const Mask& b) {
  if constexpr (std::is_same_v<Mask, bool>)
    return a || b;
  else
    return a | b;
}
/// The mask holds in lane l too.
template <class Mask>
[[gnu::always_inline]] inline void include_lane(Mask& m, std::size_t l) {
  if constexpr (std::is_same_v<Mask, bool>)
    m = true;
  else
    m[l] = -1;
}
/// Bit k is that of lane k, of at most 32.
template <class Mask>
[[nodiscard]] [[gnu::always_inline]] inline unsigned bits_of(const Mask& m) {
  if constexpr (std::is_same_v<Mask, bool>) {
    return m ? 1 : 0;
#if defined(__AVX512F__)
  } else if constexpr (sizeof m == 64 && lanes_of<Mask> == 8) {
    return _mm512_cmplt_epi64_mask(reinterpret_cast<__m512i>(m), _mm512_setzero_si512());
#endif
  } else {
    unsigned bits = 0;
    for (int k = 0; k < lanes_of<Mask>; ++k) bits |= (m[k] != 0 ? 1u : 0u) << k;
    return bits;
  }
}
template <class Mask>
[[nodiscard]] [[gnu::always_inline]] inline bool any_lane(const Mask& m) {
  return bits_of(m) != 0;
}
template <class Mask>
[[nodiscard]] [[gnu::always_inline]] inline bool all_lanes(const Mask& m) {
  return !any_lane(inverted(m));
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
