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
#include "talus/parallel/exact_reduction.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus {

/// The removed bodies.
struct removed {
  std::uint64_t count = 0;  ///< of bodies
  /// of bodies
  real mass = 0;
};

namespace detail {

/// Of one rank; `all` are the numbers that a checkpoint holds.
class removed_sum {
 public:
  removed all;

  void add(real mass) {
    exact_ = exact();
    exact_ += mass;
    ++all.count, all.mass = exact_.value();
  }
  [[nodiscard]] exact_sum exact() const {
    exact_sum sum = exact_;
    if (sum.value() != all.mass) (sum = {}) += all.mass;  // a restart has set it
    return sum;
  }

 private:
  exact_sum exact_;
};

}  // namespace detail

/// The outflow through one region; made by remove_in().
class outflow {
 public:
  explicit outflow(std::shared_ptr<const detail::removed_sum> count) : count_(std::move(count)) {}
  /// By this rank. (After a restart the numbers of all ranks are on rank 0.)
  [[nodiscard]] const removed& here() const { return count_->all; }
  /// Collective: by all ranks. The mass is summed exactly over the ranks.
  template <class World>
  [[nodiscard]] removed total(World& w) const {
    w.require_all_ranks("outflow::total");
    detail::exact_sum mass = count_->exact();
    std::uint64_t count = count_->all.count;
    detail::sum_exactly(w.link(), mass);
    w.link().reduce(reduction::sum, std::span(&count, 1));
    return {count, mass.value()};
  }

 private:
  std::shared_ptr<const detail::removed_sum> count_;
};

/// Removes the bodies whose centre is in a region (anything with contains(point), such as
/// box_region or half_space) after each step of simulate(); fixed ones stay. `name` identifies its
/// counts in checkpoints and must be unique. All ranks make the same call.
template <class World, class Region>
outflow remove_in(World& w, const Region& region, const std::string& name = "outflow") {
  w.require_all_ranks("remove_in");
  const auto count = std::make_shared<detail::removed_sum>();
  if constexpr (World::scenario_type::template has_feature<checkpoints>) {
    w.keep_sum(name + " bodies", count->all.count);
    w.keep_sum(name + " mass", count->all.mass);
  }
  w.after_each_step([&w, region, count] {
    w.destroy_if([&](const auto& b) {
      if (b.is_fixed() || !region.contains(b.position())) return false;
      count->add(b.mass());
      return true;
    });
  });
  return outflow(count);
}

}  // namespace talus
