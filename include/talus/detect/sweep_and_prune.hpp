#pragma once
// Broad phase: all pairs of balls that touch, by sorting them along one axis.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/policy.hpp"
#include "talus/detect/placeable.hpp"

namespace talus {

/// Balls in the order of their lowest coordinate along the axis with the largest spread (sort and
/// sweep; Baraff 1992, Cohen et al. 1995). Each ball is compared with those that begin before it
/// ends. The cost of a build is n log n; that of a search grows with the number of balls that
/// overlap along the axis. The order of pairs depends on the input alone.
class sorted_balls {
 public:
  /// Sorts the balls and replaces the previous ones. `reaches` are radii (length) with the contact
  /// margin. Throws unplaceable, which carries the index of the body.
  void build(std::span<const vec3> centres, std::span<const real> reaches);

  [[nodiscard]] std::size_t size() const { return balls_.size(); }
  /// Memory held, in bytes.
  [[nodiscard]] std::size_t bytes() const { return balls_.capacity() * sizeof(ball); }

  /// Calls f(i, j) once for every unordered pair i != j with |ci - cj| <= ri + rj.
  template <class F>
  void pairs(F&& f) const {
    for (auto a = balls_.begin(); a != balls_.end(); ++a)
      for (auto b = a + 1; b != balls_.end() && b->low <= a->high; ++b)
        if (touch(*a, *b)) f(a->index, b->index);
  }
  /// Calls f(i of this, j of other) for every such pair with |ci - cj| <= ri + rj.
  template <class F>
  void pairs_with(const sorted_balls& other, F&& f) const {
    for (const ball& a : balls_)
      other.each_touching(other.along_axis(a.centre, a.reach, a.index),
                          [&](const ball& b) { f(a.index, b.index); });
  }
  /// Calls f(i) for every ball i with |ci - centre| <= ri + reach, for any finite reach.
  template <class F>
  void query(const vec3& centre, real reach, F&& f) const {
    each_touching(along_axis(centre, reach, 0), [&](const ball& b) { f(b.index); });
  }

 private:
  struct ball {
    real low, high;  ///< along the axis, with room for the rounding of the sums
    vec3 centre;
    real reach;
    std::uint32_t index;
  };

  [[nodiscard]] ball along_axis(const vec3& centre, real reach, std::uint32_t index) const {
    const real x = centre[axis_], room = 4e-16 * (std::abs(x) + reach);
    return {x - reach - room, x + reach + room, centre, reach, index};
  }
  [[nodiscard]] static bool touch(const ball& a, const ball& b) {
    const real dx = a.centre[0] - b.centre[0], dy = a.centre[1] - b.centre[1],
               dz = a.centre[2] - b.centre[2], sum = a.reach + b.reach;
    return dx * dx + dy * dy + dz * dz <= sum * sum;
  }
  template <class F>
  void each_touching(const ball& a, F&& f) const {
    auto b = std::lower_bound(balls_.begin(), balls_.end(), a.low - widest_,
                              [](const ball& x, real low) { return x.low < low; });
    for (; b != balls_.end() && b->low <= a.high; ++b)
      if (touch(a, *b)) f(*b);
  }

  int axis_ = 0;
  real widest_ = 0;  ///< the largest extent of a ball along the axis
  std::vector<ball> balls_;
};

/// Balls sorted along one axis, for few bodies or bodies in a row: the cost grows faster than the
/// number of bodies if many overlap along each axis.
struct sweep_and_prune final {
  using talus_part_of = roles::broad_phase;
  using search = sorted_balls;
  static constexpr const char* name = "sweep_and_prune";
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/detect/sweep_and_prune_definitions.hpp"
#endif
