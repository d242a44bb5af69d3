#pragma once
// The lengths of the steps of a run, and the fastest approach of bodies in steps of each length:
// the number of steps in a contact depends on both.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "talus/core/math.hpp"

namespace talus::detail {

/// The lengths of all steps, equal on all ranks and in ascending order.
class step_lengths {
 public:
  static constexpr std::size_t most = 64;  ///< lengths that are kept apart
  struct entry {
    real dt = 0;
    real fastest = 0;  ///< approach along the normal of a contact, on this rank
  };

  /// Length of the steps under way, 0 before the first.
  [[nodiscard]] real now() const { return now_; }
  /// A step of another length begins; in those before, bodies approached by `fastest`.
  [[gnu::cold]] void change(real dt, real fastest) {
    note(fastest);
    now_ = dt;
    const auto at = place();
    if (at == all_.end() || at->dt != dt) all_.insert(at, {dt, 0});
    if (all_.size() > most) merge_closest();
  }
  /// In the steps under way bodies approached by `fastest`.
  void note(real fastest) {
    if (const auto at = place(); at != all_.end()) at->fastest = std::max(at->fastest, fastest);
  }
  /// All lengths so far. Of more than 64, those closest to each other count as the longer one.
  [[nodiscard]] const std::vector<entry>& all() const { return all_; }

 private:
  [[nodiscard]] std::vector<entry>::iterator place() {
    return std::lower_bound(all_.begin(), all_.end(), now_,
                            [](const entry& x, real dt) { return x.dt < dt; });
  }
  void merge_closest() {
    std::size_t closest = 0;
    for (std::size_t k = 1; k + 1 < all_.size(); ++k)
      if (all_[k + 1].dt * all_[closest].dt < all_[closest + 1].dt * all_[k].dt) closest = k;
    all_[closest + 1].fastest = std::max(all_[closest + 1].fastest, all_[closest].fastest);
    all_.erase(all_.begin() + static_cast<std::ptrdiff_t>(closest));
  }

  real now_ = 0;
  std::vector<entry> all_;
};

}  // namespace talus::detail
