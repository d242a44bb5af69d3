#pragma once
// Outflow: bodies whose centre is in a region after a step are removed and counted.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "talus/body/features.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/math.hpp"
#include "talus/core/region_check.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus {

/// The removed bodies.
struct removed {
  std::uint64_t count = 0;  ///< of bodies
  /// The mass of these bodies
  real mass = 0;
};

namespace detail {

/// By one rank.
struct removed_sum {
  std::uint64_t count = 0;
  exact_sum mass;
};

}  // namespace detail

/// The outflow through one region; made by remove_in().
class outflow {
 public:
  explicit outflow(std::shared_ptr<const detail::removed_sum> count) : count_(std::move(count)) {}
  /// By this rank. (After a restart the numbers of all ranks are on rank 0.)
  [[nodiscard]] removed here() const { return {count_->count, count_->mass.value()}; }
  /// Collective: by all ranks. The mass is summed exactly over the ranks.
  template <class World>
  [[nodiscard]] removed total(World& w) const {
    w.require_all_ranks("outflow::total", false);  // kept, as after each call of simulate()
    detail::exact_sum mass = count_->mass;
    std::uint64_t count = count_->count;
    detail::sum_exactly(w.link(), mass);
    w.link().reduce(reduction::sum, std::span(&count, 1));
    return {count, mass.value()};
  }

 private:
  std::shared_ptr<const detail::removed_sum> count_;
};

/// Removes the bodies whose centre is in a region (anything with contains(point), such as
/// box_region or half_space) after each step of simulate(); fixed ones stay. `name` identifies its
/// counts in checkpoints and must be unique. All ranks make the same call. Throws invalid_argument
/// for a region in which no point lies.
template <class World, class Region>
outflow remove_in(World& w, const Region& region, const std::string& name = "outflow") {
  w.require_all_ranks("remove_in", false);
  detail::require_region(region, "remove_in");
  const auto count = std::make_shared<detail::removed_sum>();
  if constexpr (World::scenario_type::template has_feature<checkpoints>) {
    w.keep_sum(name + " bodies", count->count);
    w.keep_sum(name + " mass", count->mass);
  }
  w.after_each_step(name, [&w, region, count] {
    w.destroy_if([&](const auto& b) {
      if (b.is_fixed() || !region.contains(b.position())) return false;
      ++count->count, count->mass += b.mass();
      return true;
    });
  });
  return outflow(count);
}

}  // namespace talus
