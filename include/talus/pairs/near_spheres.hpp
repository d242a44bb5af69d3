#pragma once
// Which kept candidate pairs of spheres are within reach of each other, eight at a time.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "talus/contact/place.hpp"
#include "talus/detect/sphere_batch.hpp"
#include "talus/state/candidate_pairs.hpp"

namespace talus::detail {

/// Writes the indices of those of `size` pairs of `spheres` that are within reach, and returns how
/// many. The others lose their place in the history. (`near` has room for one more.)
[[nodiscard]] inline std::size_t near_spheres(const moving_sphere* spheres, close_pair* pairs,
                                              std::size_t size, std::uint32_t* near) {
  constexpr std::size_t lanes = sphere_batch::capacity;
  std::size_t count = 0;
  const auto test = [&](const close_pair* group, auto&& at) {
    return spheres_within_reach(
        [&](int k) -> const moving_sphere& { return spheres[group[at(k)].i]; },
        [&](int k) -> const moving_sphere& { return spheres[group[at(k)].j]; });
  };
  const auto note = [&](std::size_t k, bool is_near) {
    near[count] = static_cast<std::uint32_t>(k);
    count += is_near ? 1 : 0;
    pairs[k].last = is_near ? pairs[k].last : history_place::none;
  };
  std::size_t first = 0;
  for (; first + lanes <= size; first += lanes) {
    const unsigned bits = test(pairs + first, [](int k) { return k; });
#pragma GCC unroll 8
    for (std::size_t k = 0; k < lanes; ++k) note(first + k, (bits >> k & 1u) != 0);
  }
  if (first == size) return count;
  const int last = static_cast<int>(size - first) - 1;
  const unsigned bits = test(pairs + first, [&](int k) { return std::min(k, last); });
  for (std::size_t k = 0; first + k < size; ++k) note(first + k, (bits >> k & 1u) != 0);
  return count;
}

}  // namespace talus::detail
