#pragma once
// Groups of bodies between which no contact acts.
#include <cstddef>
#include <cstdint>

#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Groups of islands: no contact connects movable bodies of two groups, so that each group can be
/// solved by itself. There are none where the contacts of a step fit the cache anyway.
class body_groups {
 public:
  void clear() { size_ = 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::uint32_t of(std::int32_t body) const {
    return group_[static_cast<std::size_t>(body)];
  }

  /// Finds the groups of `bodies` bodies. each_manifold(f) calls f(a, b) for each manifold, with
  /// the movable bodies that it connects; b is -1 if there is only one. Islands that follow each
  /// other in the order of the bodies share a group until it has `least` manifolds.
  template <class Each>
  void find(std::size_t bodies, std::uint32_t least, Each&& each_manifold) {
    islands_.reset(bodies);
    each_manifold([&](std::int32_t a, std::int32_t b) {
      if (b >= 0) islands_.join(a, b);
    });
    load_.assign(bodies, 0);
    each_manifold([&](std::int32_t a, std::int32_t) { ++load_[islands_.root(a)]; });
    group_.resize(bodies);
    std::uint32_t group = 0, load = 0;
    for (std::size_t i = 0; i < bodies; ++i) {
      const std::uint32_t root = islands_.root(i);
      if (root != i) {  // the root comes before it
        group_[i] = group_[root];
        continue;
      }
      if (load >= least) ++group, load = 0;
      group_[i] = group, load += load_[i];
    }
    size_ = group + 1;
  }

 private:
  disjoint_sets islands_;
  plain_vector<std::uint32_t> load_;   ///< manifolds of the island of a root
  plain_vector<std::uint32_t> group_;  ///< of each body
  std::size_t size_ = 0;
};

}  // namespace talus::detail
