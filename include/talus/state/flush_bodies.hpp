#pragma once
// The fixed bodies with flat faces that this rank holds, and which of them touch each other.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// A fixed or global body: where it was when the neighbours were found.
struct flush_body {
  std::uint32_t shape = 0, index = 0;  ///< of the scenario, and in its store
  bool global = false, driven = false;
  system_id id = no_id;
  pose at;
  real radius = 0;                      ///< 0 for a plane
  vec3 lower{0, 0, 0}, upper{0, 0, 0};  ///< of the box around it, with its skin

  [[nodiscard]] bool may_contain(const vec3& p, real tolerance) const {
    const auto within = [&](int k) {
      return p[k] >= lower[k] - tolerance && p[k] <= upper[k] + tolerance;
    };
    return within(0) && within(1) && within(2);
  }
};

/// The neighbours of a body in a list: planes, then others sorted along an axis.
struct flush_range {
  std::uint32_t first = 0, sorted = 0;
  int axis = 0;
};

struct flush_bodies {
  bool known = false;
  plain_vector<flush_body> all;
  /// Numbers in `all` of the bodies that touch body k, from ranges[k] to ranges[k + 1].
  plain_vector<std::uint32_t> near;
  plain_vector<real> furthest;  ///< along the axis, of those that are sorted up to each
  plain_vector<flush_range> ranges;
  /// Number in `all` of a body of a shape, or -1: global ones, then fixed ones.
  std::vector<plain_vector<std::int32_t>> numbers;
  plain_vector<plain_pair<system_id, std::uint32_t>> of_ids;  ///< of fixed ones, sorted

  /// Whether some touch.
  [[nodiscard]] bool any() const { return !near.empty(); }
  [[nodiscard]] bool touches_any(std::uint32_t k) const {
    return ranges[k].first != ranges[k + 1].first;
  }
  [[nodiscard]] std::int32_t number_of(std::size_t shape, bool global, std::size_t index) const {
    const auto& of = numbers[2 * shape + !global];
    return index < of.size() ? of[index] : -1;
  }
  /// Calls f(number) for the bodies that touch body k and may contain the point, until it returns
  /// false.
  template <class F>
  void each_near(std::uint32_t k, const vec3& p, real tolerance, F&& f) const {
    const auto [first, sorted, axis] = ranges[k];
    const real x = p[axis];
    for (std::uint32_t n = first; n < sorted; ++n)
      if (!f(near[n])) return;
    std::uint32_t n = sorted, end = ranges[k + 1].first;
    while (n < end) {  // to the first one that begins beyond the point
      const std::uint32_t middle = n + (end - n) / 2;
      if (all[near[middle]].lower[axis] <= x + tolerance)
        n = middle + 1;
      else
        end = middle;
    }
    while (n > sorted && furthest[n - 1] >= x - tolerance)
      if (const std::uint32_t other = near[--n]; all[other].may_contain(p, tolerance))
        if (!f(other)) return;
  }
};
struct no_flush_bodies {};

}  // namespace talus::detail
