#pragma once
// Overlaps in every step, as found by detection at its start.
#include <array>

#include "talus/world/world.hpp"

namespace talus {

/// Overlaps at the start of the last step (the end of the one before), over the mean bounding
/// radius of the bodies that can move.
struct overlap_account {
  double mean = 0;  ///< over the points that overlap
  double max = 0;
  double worst = 0;  ///< the largest in any step so far
};

/// Collective: sums over all ranks. Needs features<penetration_monitor>. Costs no detection of its
/// own, and covers every step; measure_penetration measures the present state.
template <class Scenario>
[[nodiscard]] overlap_account measure_overlaps(world<Scenario>& w) {
  overlap_account o;
  if constexpr (detail::require_feature<Scenario, penetration_monitor>()) {
    w.require_all_ranks("measure_overlaps");
    const auto& r = detail::view_of(w).monitors.overlaps;
    std::array<double, 4> sums{r.sum, static_cast<double>(r.count), 0, 0};
    w.for_each_local([&](const auto& b) {
      if (!b.is_fixed()) sums[2] += b.shape().bounding_radius(), ++sums[3];
    });
    std::array<double, 2> most{r.deepest, r.worst};
    w.link().reduce(reduction::sum, sums);
    w.link().reduce(reduction::max, most);
    const double radius = sums[3] > 0 ? sums[2] / sums[3] : 1;
    o.mean = sums[1] > 0 ? sums[0] / sums[1] / radius : 0;
    o.max = most[0] / radius;
    o.worst = most[1] / radius;
  }
  return o;
}

}  // namespace talus
