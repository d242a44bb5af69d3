#pragma once
// One level of the broad phase: its cell size, and the bucket of each cell.
#include <algorithm>
#include <cstdint>
#include <limits>

#include "talus/core/math.hpp"

namespace talus::detail {

/// One cell size. Cell (x, y, z) is bucket (x + y*row + z*slab + shift) & mask. If the cells in use
/// span a small box, that numbering is exact (mask all ones, one empty cell between rows, so that
/// neighbours of border cells exist). Otherwise it is a hash whose 27 neighbour buckets are all
/// different; the distance test rejects other bodies in them.
struct grid_level {
  struct span3 {
    std::int64_t low[3], high[3];
  };

  real cell = 0, inverse = 0;             ///< edge and its reciprocal, a length
  real largest = 0;                       ///< reach of its bodies, a length, rounded up
  real slack = 0;                         ///< bound of the rounding in coordinates
  vec3 low{0, 0, 0}, high{0, 0, 0};       ///< of the centres
  span3 cells{};                          ///< in use
  std::uint32_t first = 0, last = 0;      ///< entries
  std::uint32_t bucket = 0, buckets = 0;  ///< the first one, and how many
  std::uint32_t row = 0, slab = 0, shift = 0, mask = 0;

  [[nodiscard]] std::int64_t cell_of(real v) const {
    const real scaled = v * inverse;
    const auto i = static_cast<std::int64_t>(scaled);
    return i - (scaled < static_cast<real>(i));
  }
  [[nodiscard]] std::uint32_t bucket_of(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return (static_cast<std::uint32_t>(x) + static_cast<std::uint32_t>(y) * row +
            static_cast<std::uint32_t>(z) * slab + shift) &
           mask;
  }
  [[nodiscard]] bool exact() const { return mask == ~std::uint32_t{0}; }
  /// Cell edge, bucket numbering and number of buckets, from the bounds, the largest reach and the
  /// number of its bodies.
  void lay_out();
};

inline void grid_level::lay_out() {
  constexpr real epsilon = std::numeric_limits<real>::epsilon();
  const real furthest = std::max(max_norm(low), max_norm(high));
  slack = 8 * epsilon * furthest;
  // Wide enough that a ball and all that touch it span at most three cells despite rounding.
  cell = std::max(2 * largest * (1 + real(1e-6)) + 2 * slack, real(1e-300));
  largest *= 1 + real(1e-9);
  inverse = 1 / cell;
  real extent[3];
  for (int d = 0; d < 3; ++d) {
    cells.low[d] = cell_of(low[d]);
    cells.high[d] = cell_of(high[d]);
    extent[d] = real(cells.high[d] - cells.low[d] + 2);
  }
  const std::uint32_t count = last - first;
  if (extent[0] * extent[1] * extent[2] <= 8 * real(count) + 64) {
    row = std::uint32_t(extent[0]);
    slab = row * std::uint32_t(extent[1]);
    mask = ~std::uint32_t{0};
    shift = 0;
    shift = 0 - bucket_of(cells.low[0], cells.low[1], cells.low[2]);
    buckets = bucket_of(cells.high[0], cells.high[1], cells.high[2]) + row + slab + 2;
    return;
  }
  buckets = 256;
  while (buckets < 2 * real(count) && buckets < (std::uint32_t{1} << 31)) buckets *= 2;
  mask = buckets - 1;
  shift = 0;
  // Rows and slabs a golden section apart spread lines and sheets of cells evenly; both odd.
  row = std::uint32_t(real(0.6180339887498949) * buckets) | 1u;
  slab = std::uint32_t(real(0.7548776662466927) * buckets) | 1u;
  const auto rows_apart = [&] {
    for (int y = 0; y <= 2; ++y)
      for (int z = -2; z <= 2; ++z) {
        if (y == 0 && z <= 0) continue;
        const std::uint32_t d = (std::uint32_t(y) * row + std::uint32_t(z) * slab) & mask;
        if (std::min(d, buckets - d) < 3) return false;
      }
    return true;
  };
  while (!rows_apart()) slab += 2;
}

}  // namespace talus::detail
