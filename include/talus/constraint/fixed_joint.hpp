#pragma once
// A fixed joint: two bodies move as one.
#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_fixed_joint_has_at {

/// Holds two bodies in their present relative pose: a weld.
struct fixed_joint final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "fixed_joint";
  static constexpr int rows = 6;

  vec3 at{0, 0, 0};  ///< the point to which torque() refers, in the world

  /// Throws invalid_argument unless the point is finite.
  void validate() const { detail::require_point(name, "point", at); }

  struct anchors {
    detail::joint_frames frames;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_at(at, {1, 0, 0, 0}, a, b)};
  }
  static void write(const anchors&, detail::line_writer& to) {
    to.hold_point();
    for (int k = 0; k < 3; ++k) to.hold(detail::line_of_cosine(to.g, k, (k + 1) % 3));
  }
};

}  // namespace a_fixed_joint_has_at

}  // namespace talus
