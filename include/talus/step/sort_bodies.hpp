#pragma once
// Sorts bodies so that neighbours in space are neighbours in memory, if they no longer are: along
// Morton's curve (Morton 1966). Only the order of bodies and contacts changes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/sort.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

inline constexpr std::uint64_t steps_between_sorts = 256;
/// Fewer bodies fit the nearest cache in any order.
inline constexpr std::size_t fewest_to_sort = 4096;
/// Consecutive bodies are about two mean spacings apart when sorted, and a third of the scene
/// otherwise.
inline constexpr real most_scattered = 4;

/// The position of a point on the curve: interleaved bits of the three coordinates.
[[nodiscard]] inline std::uint64_t along_curve(const std::array<std::uint32_t, 3>& cell) {
  std::uint64_t code = 0;
  for (int k = 0; k < 3; ++k) {
    std::uint64_t x = cell[static_cast<std::size_t>(k)] & 0x1fffffu;
    x = (x | x << 32) & 0x001f00000000ffffull;
    x = (x | x << 16) & 0x001f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    x = (x | x << 2) & 0x1249249249249249ull;
    code |= x << k;
  }
  return code;
}

/// Mean distance, in mean spacings, of consecutive points.
[[nodiscard]] inline real scatter_of(std::span<const vec3> points) {
  real sum[3] = {}, square[3] = {}, way = 0, last[3] = {};
  for (std::size_t i = 0; i < points.size(); ++i) {
    real step = 0;
    for (int k = 0; k < 3; ++k) {
      const real x = points[i][k], d = i > 0 ? x - last[k] : 0;
      sum[k] += x, square[k] += x * x, step += d * d;
      last[k] = x;
    }
    way += std::sqrt(step);
  }
  const auto n = static_cast<real>(points.size());
  real width[3], widest = 0;  // of a box with these variances
  for (int k = 0; k < 3; ++k) {
    const real mean = sum[k] / n;
    width[k] = std::sqrt(std::max(12 * (square[k] / n - mean * mean), real(0)));
    widest = std::max(widest, width[k]);
  }
  real volume = 1;  // a flat scene has at least the thickness of its spacing
  for (const real w : width) volume *= std::max(w, widest / std::sqrt(n));
  return volume > 0 ? way / n / portable::cbrt(volume / n) : 0;
}

/// For each place, the index of the point that moves there.
[[nodiscard]] inline plain_vector<std::uint32_t> order_along_curve(std::span<const vec3> points) {
  real low[3], widest = 1e-300;
  for (int k = 0; k < 3; ++k) {
    real high = low[k] = points.front()[k];
    for (const vec3& p : points) low[k] = std::min(low[k], p[k]), high = std::max(high, p[k]);
    widest = std::max(widest, high - low[k]);
  }
  plain_vector<plain_pair<std::uint64_t, std::uint32_t>> codes(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::array<std::uint32_t, 3> cell;
    for (std::size_t k = 0; k < 3; ++k)
      cell[k] = static_cast<std::uint32_t>((points[i][static_cast<std::ptrdiff_t>(k)] - low[k]) /
                                           widest * 0x1fffff);
    codes[i] = {along_curve(cell), static_cast<std::uint32_t>(i)};
  }
  sort_values(codes);
  plain_vector<std::uint32_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = codes[i].second;
  return order;
}

/// Sorts the bodies owned here if that will pay. References to bodies by index are rebuilt by id.
template <class Scenario>
void sort_bodies(population<Scenario>& s) {
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    if (store.locals < fewest_to_sort) return;
    const auto points = std::span<const vec3>(store.position).first(store.locals);
    if (!(scatter_of(points) > most_scattered)) return;
    store.permute_locals(order_along_curve(points));
    s.changed = true;
  });
}

}  // namespace talus::detail
