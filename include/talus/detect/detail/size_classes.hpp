#pragma once
// Assigns bodies to grid levels: reaches are binned by their leading bits, and neighbouring bins
// are merged if that makes the search cheaper.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Bins of reaches, two per power of two, counted downwards from the largest reach. Smaller reaches
/// belong to the last bin.
class size_classes {
 public:
  static constexpr unsigned bins = 64;

  /// Reads all reaches (finite, not negative) and decides. O(n + bins²), no allocation.
  void plan(std::span<const real> reaches, real smallest, real largest) {
    top_ = key(largest);
    levels_ = 1;
    if (reaches.empty() || top_ == key(smallest)) {
      level_of_bin_.fill(0);
      return;
    }
    std::array<bin, bins> all{};
    for (const real r : reaches) {
      bin& b = all[bin_of(r)];
      b.count += 1;
      b.sum += r;
      b.largest = std::max(b.largest, r);
    }
    merge(all);
  }

  /// Number of levels, the coarsest first; some may be empty of bodies only when there are none.
  [[nodiscard]] unsigned levels() const { return levels_; }
  [[nodiscard]] unsigned level_of(real reach) const { return level_of_bin_[bin_of(reach)]; }

 private:
  struct bin {
    real count = 0, sum = 0, largest = 0;
  };

  static unsigned key(real r) { return unsigned(std::bit_cast<std::uint64_t>(r + real(0)) >> 51); }
  [[nodiscard]] unsigned bin_of(real r) const { return std::min(top_ - key(r), bins - 1); }

  // Cheapest partition of the occupied bins into runs (dynamic programming over the run's end).
  // In units of one distance test (they go eight at a time): a body tests half of the 27 cells of
  // its own level, where bodies of its own bin may lie packed; and for every coarser level it finds
  // some rows of cells, worth about 200 tests as measured, and tests what about 10 cells hold.
  void merge(const std::array<bin, bins>& all) {
    std::array<unsigned, bins> used;
    unsigned n = 0;
    std::array<real, bins + 1> finer{};  // bodies in bins from this one on (finer to the back)
    for (unsigned i = 0; i < bins; ++i)
      if (all[i].count > 0) used[n++] = i;
    for (unsigned i = n; i-- > 0;) finer[i] = finer[i + 1] + all[used[i]].count;

    std::array<real, bins + 1> best;
    std::array<unsigned, bins + 1> from{};
    best.fill(std::numeric_limits<real>::infinity());
    best[0] = 0;
    for (unsigned first = 0; first < n; ++first) {
      real count = 0, own = 0, probed = 0;
      for (unsigned last = first; last < n; ++last) {
        const bin& b = all[used[last]];
        const real ratio = all[used[first]].largest * b.count / b.sum;
        const real packed = ratio * ratio * ratio;  // bodies in a cell; not a number for points
        count += b.count;
        own += b.count * std::min(b.count, real(13.5) * packed);
        probed += b.count * std::min(b.count, 10 * packed);
        const real cost = best[first] + own + finer[last + 1] * (200 + probed / count);
        if (cost < best[last + 1]) {
          best[last + 1] = cost;
          from[last + 1] = first;
        }
      }
    }
    std::array<bool, bins> starts{};
    for (unsigned end = n; end > 0; end = from[end]) starts[used[from[end]]] = true;
    unsigned level = 0;
    for (unsigned i = 0; i < bins; ++i) {
      if (starts[i] && i != used[0]) ++level;
      level_of_bin_[i] = std::uint8_t(level);
    }
    levels_ = level + 1;
  }

  unsigned top_ = 0;
  unsigned levels_ = 1;
  std::array<std::uint8_t, bins> level_of_bin_{};
};

}  // namespace talus::detail
