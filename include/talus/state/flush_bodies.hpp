#pragma once
// The fixed bodies with flat faces that this rank holds, and which of them touch each other.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
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

struct flush_bodies {
  bool known = false;
  plain_vector<flush_body> all;
  /// Numbers in `all` of the bodies that touch body k: from first[k] on.
  plain_vector<std::uint32_t> first, near;
  /// Number in `all` of a body of a shape, or -1: global ones, then fixed ones.
  std::vector<plain_vector<std::int32_t>> numbers;

  /// Whether some touch.
  [[nodiscard]] bool any() const { return !near.empty(); }
  [[nodiscard]] std::int32_t number_of(std::size_t shape, bool global, std::size_t index) const {
    const auto& of = numbers[2 * shape + !global];
    return index < of.size() ? of[index] : -1;
  }
};
struct no_flush_bodies {};

}  // namespace talus::detail
