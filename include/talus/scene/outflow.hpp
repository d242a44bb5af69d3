#pragma once
// Bodies that leave: those whose centre is in a region after a step are removed and counted.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "talus/body/features.hpp"
#include "talus/core/math.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus {

/// What has gone out.
struct removed {
  std::uint64_t bodies = 0;
  real mass = 0;
};

/// What one region has removed; made by remove_in().
class outflow {
 public:
  /// By this rank. (After a restart the numbers of all ranks are on rank 0.)
  [[nodiscard]] const removed& here() const { return *count_; }
  /// Collective: by all ranks. The last bits of the mass depend on the number of ranks.
  template <class World>
  [[nodiscard]] removed total(World& w) const {
    w.require_all_ranks("outflow::total");
    std::array<double, 2> sums{static_cast<double>(count_->bodies), count_->mass};
    w.link().reduce(reduction::sum, std::span(sums));
    return {static_cast<std::uint64_t>(sums[0]), sums[1]};
  }

 private:
  template <class World, class Region>
  friend outflow remove_in(World& w, const Region& region, const std::string& name);
  std::shared_ptr<removed> count_ = std::make_shared<removed>();
};

/// Removes the bodies whose centre is in a region (anything with contains(point), such as
/// box_region or half_space) after each step of simulate(); fixed ones stay. `name` is that of its
/// counts in checkpoints, one for each. All ranks call it alike.
template <class World, class Region>
outflow remove_in(World& w, const Region& region, const std::string& name = "outflow") {
  w.require_all_ranks("remove_in");
  outflow gone;
  if constexpr (World::scenario_type::template has_feature<checkpoints>) {
    w.keep_sum(name + " bodies", gone.count_->bodies);
    w.keep_sum(name + " mass", gone.count_->mass);
  }
  w.after_each_step([&w, region, count = gone.count_] {
    w.destroy_if([&](const auto& b) {
      if (b.is_fixed() || !region.contains(b.position())) return false;
      ++count->bodies, count->mass += b.mass();
      return true;
    });
  });
  return gone;
}

}  // namespace talus
