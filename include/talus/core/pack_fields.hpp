#pragma once
// Structs of numbers of several things as one struct of packs with the same fields, and the
// reverse.
#include <cstddef>
#include <cstring>
#include <type_traits>

#include "talus/core/pack.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/pack_vector.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// A struct of packs, field by field that of the numbers in `Numbers`.
template <class Pack, class Packs, class Numbers>
inline constexpr bool same_fields =
    std::is_trivially_copyable_v<Packs>&& std::is_trivially_copyable_v<Numbers> &&
    (std::is_empty_v<Packs>
         ? std::is_empty_v<Numbers>
         : sizeof(Packs) % sizeof(Pack) == 0 && sizeof(Packs) == lanes_of<Pack> * sizeof(Numbers));

/// Four fields begin at each of these, and cover all; the last four may overlap those before.
template <class F>
[[gnu::always_inline]] inline void each_four_fields(std::size_t count, F&& f) {
  std::size_t first = 0;
  for (; first + 4 <= count; first += 4) f(first);
  if (first < count) f(count - 4);
}

/// `at(l)` is a reference to the struct of lane l.
template <class Pack, class Packs, class At>
[[gnu::always_inline]] inline void gather_fields(Packs& packs, At&& at) {
  using numbers = std::remove_cvref_t<decltype(at(0))>;
  using number = lane_of<Pack>;
  static_assert(same_fields<Pack, Packs, numbers>);
  const auto byte = [&](int l) __attribute__((always_inline)) {
    return reinterpret_cast<const char*>(&at(l));
  };
  if constexpr (!std::is_empty_v<Packs>) {
    constexpr std::size_t count = sizeof(Packs) / sizeof(Pack);
    Pack fields[count];
    if constexpr (count >= 4) {
      each_four_fields(
          count, [&](std::size_t first) __attribute__((always_inline)) {
            const auto rows = gather<Pack>([&](int l) __attribute__((always_inline)) {
              return row_at<number, const char>{byte(l) + first * sizeof(number)};
            });
            fields[first] = rows.x, fields[first + 1] = rows.y;
            fields[first + 2] = rows.z, fields[first + 3] = rows.w;
          });
    } else {
      for (std::size_t f = 0; f < count; ++f)
        for (int l = 0; l < lanes_of<Pack>; ++l) {
          number x;
          std::memcpy(&x, byte(l) + f * sizeof x, sizeof x);
          put_lane(fields[f], static_cast<std::size_t>(l), x);
        }
    }
    std::memcpy(static_cast<void*>(&packs), fields, sizeof fields);
  }
}
/// The reverse, to as many things as there are lanes.
template <class Pack, class Packs, class At>
[[gnu::always_inline]] inline void scatter_fields(const Packs& packs, At&& at) {
  using numbers = std::remove_cvref_t<decltype(at(0))>;
  using number = lane_of<Pack>;
  static_assert(same_fields<Pack, Packs, numbers>);
  const auto byte = [&](int l) __attribute__((always_inline)) {
    return reinterpret_cast<char*>(&at(l));
  };
  if constexpr (!std::is_empty_v<Packs>) {
    constexpr std::size_t count = sizeof(Packs) / sizeof(Pack);
    Pack fields[count];
    std::memcpy(fields, static_cast<const void*>(&packs), sizeof fields);
    if constexpr (count >= 4) {
      each_four_fields(
          count, [&](std::size_t first) __attribute__((always_inline)) {
            const pack_rows<Pack> rows{fields[first], fields[first + 1], fields[first + 2],
                                       fields[first + 3]};
            scatter(
                rows, [&](int l) __attribute__((always_inline)) {
                  return row_at<number, char>{byte(l) + first * sizeof(number)};
                });
          });
    } else {
      for (std::size_t f = 0; f < count; ++f)
        for (int l = 0; l < lanes_of<Pack>; ++l) {
          const number x = lane(fields[f], static_cast<std::size_t>(l));
          std::memcpy(byte(l) + f * sizeof x, &x, sizeof x);
        }
    }
  }
}
/// All lanes alike.
template <class Pack, class Packs, class Numbers>
[[gnu::always_inline]] inline void spread_fields(Packs& packs, const Numbers& numbers) {
  gather_fields<Pack>(packs, [&](int) -> const Numbers& { return numbers; });
}

/// The first three numbers of the rows of the lanes, with 0 for the fourth one.
template <class Pack>
[[gnu::always_inline]] inline void rows_of_lanes(const vectors_of<Pack>& v,
                                                 row_pack<lane_of<Pack>> (&rows)[lanes_of<Pack>]) {
  static_assert(lanes_of<Pack> == 8);
  const pack_rows<Pack> turned = transposed(v.x, v.y, v.z, Pack{});
  const Pack each[4] = {turned.x, turned.y, turned.z, turned.w};
  for (int i = 0; i < 4; ++i) {
    rows[i] = __builtin_shufflevector(each[i], each[i], 0, 1, 2, 3);
    rows[i + 4] = __builtin_shufflevector(each[i], each[i], 4, 5, 6, 7);
  }
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
