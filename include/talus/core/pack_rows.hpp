#pragma once
// Rows of four numbers that follow each other in memory - a vector and one more - as packs: one row
// in one pack, or the rows of many things as a pack for each of the four.
#include <cstring>
#include <type_traits>

#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// One row.
template <class Real>
using row_pack = pack<Real, 4>;

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
[[nodiscard]] [[gnu::always_inline]] inline row_pack<Real> load(const row_at<Real, Byte>& row) {
  row_pack<Real> q;
  std::memcpy(&q, row.begin, sizeof q);
  return q;
}
template <class Real>
[[gnu::always_inline]] inline void store(const row_at<Real, char>& row, const row_pack<Real>& q) {
  std::memcpy(row.begin, &q, sizeof q);
}
template <class Row>
[[nodiscard]] inline vector3<lane_of<Row>> xyz(const Row& q) {
  return {q[0], q[1], q[2]};
}

/// With 0 for the fourth number.
template <class Row>
[[nodiscard]] inline Row without_fourth(const Row& q) {
  return __builtin_shufflevector(q, Row{0, 0, 0, 0}, 0, 1, 2, 4);
}
/// The sum of the four products of corresponding elements.
template <class Row>
[[nodiscard]] inline lane_of<Row> sum_of_products(const Row& a, const Row& b) {
  const Row p = a * b;
  return (p[0] + p[2]) + (p[1] + p[3]);
}
/// The fourth number is 0 if it is for one of the two.
template <class Row>
[[nodiscard]] inline Row cross(const Row& a, const Row& b) {
  const auto turn = [](const Row& q) { return __builtin_shufflevector(q, q, 1, 2, 0, 3); };
  return turn(a * turn(b) - turn(a) * b);
}

/// Three components and one more number of as many things as there are lanes.
template <class Pack>
struct pack_rows {
  Pack x, y, z, w;
};

/// A row of each thing to a pack of each component, or the reverse. Rows come as (i, i + 4), or
/// (i, i + 4, i + 8, i + 12), in one register, so that with floats all shuffles stay within rows,
/// and with doubles within pairs of them.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline pack_rows<Pack> transposed(const Pack& a, const Pack& b,
                                                                       const Pack& c,
                                                                       const Pack& d) {
  if constexpr (sizeof(lane_of<Pack>) == 8) {
    const Pack p = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    const Pack q = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
    const Pack r = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
    const Pack t = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
    return {__builtin_shufflevector(p, r, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(q, t, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(p, r, 2, 3, 10, 11, 6, 7, 14, 15),
            __builtin_shufflevector(q, t, 2, 3, 10, 11, 6, 7, 14, 15)};
  } else {
    const Pack p =
        __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
    const Pack q =
        __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
    const Pack r =
        __builtin_shufflevector(c, d, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
    const Pack t =
        __builtin_shufflevector(c, d, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
    return {
        __builtin_shufflevector(p, r, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
        __builtin_shufflevector(p, r, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31),
        __builtin_shufflevector(q, t, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
        __builtin_shufflevector(q, t, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)};
  }
}

[[nodiscard]] [[gnu::always_inline]] inline wide_pack<double> side_by_side(
    const row_pack<double>& low, const row_pack<double>& high) {
#if defined(__AVX512F__)
  return _mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(low), high, 1);
#else
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}
[[nodiscard]] [[gnu::always_inline]] inline wide_pack<float> side_by_side(
    const row_pack<float>& a, const row_pack<float>& b, const row_pack<float>& c,
    const row_pack<float>& d) {
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

/// `at(i)` is the row of thing i.
template <class Pack, class At>
[[nodiscard]] [[gnu::always_inline]] inline pack_rows<Pack> gather(At&& at) {
  if constexpr (lanes_of<Pack> == 1) {
    const auto row = load(at(0));
    return {row[0], row[1], row[2], row[3]};
  } else {
    Pack rows[4];
    for (int i = 0; i < 4; ++i)
      if constexpr (lanes_of<Pack> == 8)
        rows[i] = side_by_side(load(at(i)), load(at(i + 4)));
      else
        rows[i] = side_by_side(load(at(i)), load(at(i + 4)), load(at(i + 8)), load(at(i + 12)));
    return transposed(rows[0], rows[1], rows[2], rows[3]);
  }
}
/// The reverse, thing 0 last: it wins where several are the same.
template <class Pack, class At>
[[gnu::always_inline]] inline void scatter(const pack_rows<Pack>& rows, At&& at) {
  if constexpr (lanes_of<Pack> == 1) {
    store(at(0), row_pack<Pack>{rows.x, rows.y, rows.z, rows.w});
  } else {
    const pack_rows<Pack> turned = transposed(rows.x, rows.y, rows.z, rows.w);
    const Pack each[4] = {turned.x, turned.y, turned.z, turned.w};
    for (int i = 3; i >= 0; --i) {
      const auto& x = each[i];
      if constexpr (lanes_of<Pack> == 16) {
        store(at(i + 12), __builtin_shufflevector(x, x, 12, 13, 14, 15));
        store(at(i + 8), __builtin_shufflevector(x, x, 8, 9, 10, 11));
      }
      store(at(i + 4), __builtin_shufflevector(x, x, 4, 5, 6, 7));
      store(at(i), __builtin_shufflevector(x, x, 0, 1, 2, 3));
    }
  }
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
