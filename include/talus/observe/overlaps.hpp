#pragma once
// Overlaps in every step, as found by detection at its start.
#include <array>

#include "talus/core/exact_sum.hpp"
#include "talus/observe/penetration.hpp"
#include "talus/parallel/exact_reduction.hpp"
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
    const double radius = detail::mean_radius(w);
    detail::exact_sum sum = r.sum;
    std::uint64_t count = r.count;
    std::array<double, 2> most{r.deepest, r.worst};
    detail::sum_exactly(w.link(), sum);
    w.link().reduce(reduction::sum, std::span(&count, 1));
    w.link().reduce(reduction::max, most);
    o.mean = count > 0 ? sum.value() / static_cast<double>(count) / radius : 0;
    o.max = most[0] / radius;
    o.worst = most[1] / radius;
  }
  return o;
}

}  // namespace talus
