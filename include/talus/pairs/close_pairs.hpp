#pragma once
// Which kept candidate pairs are within reach, eight at a time.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "talus/contact/place.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/state/candidate_pairs.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Writes the numbers of those of `size` pairs that are within reach to `close`, which has room for
/// one more, and returns how many they are. If `Forget`, the others lose their place in the
/// history. `a` and `b` are the bodies of the two shapes: structs in which `reach` follows
/// `position`. There are no branches, because about half of the pairs of a neighbour list are
/// apart, in no order that a processor could predict.
template <bool Forget = true, class BodyA, class BodyB>
[[nodiscard, gnu::always_inline]] inline std::size_t find_close(close_pair* pairs, std::size_t size,
                                                                const BodyA* a, const BodyB* b,
                                                                std::uint32_t* close) {
  using number = wide_pack<real>;
  constexpr std::size_t lanes = lanes_of<number>;
  std::size_t count = 0;
  const auto compare = [&](std::size_t first, const close_pair* of_lane, std::size_t left)
      __attribute__((always_inline)) {
    const auto of_a = gather<number>([&](int l) __attribute__((always_inline)) {
      return row_of(a[of_lane[l].i], a[of_lane[l].i].position);
    });
    const auto of_b = gather<number>([&](int l) __attribute__((always_inline)) {
      return row_of(b[of_lane[l].j], b[of_lane[l].j].position);
    });
    const auto d = vectors_in(of_a) - vectors_in(of_b);
    const number reach = of_a.w + of_b.w;
    const unsigned apart = bits_of(dot(d, d) > reach * reach);
    for (std::size_t l = 0; l < left; ++l) {
      const unsigned away = apart >> l & 1;
      close[count] = static_cast<std::uint32_t>(first + l);
      count += away ^ 1;
      // Without a branch: history_place::none has all bits.
      if constexpr (!Forget) continue;
      history_place& last = pairs[first + l].last;
      last = static_cast<history_place>(static_cast<std::uint32_t>(last) | -away);
    }
  };
  const std::size_t full = size / lanes * lanes;
  for (std::size_t first = 0; first < full; first += lanes) compare(first, pairs + first, lanes);
  if (full < size) {
    close_pair rest[lanes];
    for (std::size_t l = 0; l < lanes; ++l) rest[l] = pairs[std::min(full + l, size - 1)];
    compare(full, rest, size - full);
  }
  return count;
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
