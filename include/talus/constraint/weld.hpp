#pragma once
// A weld: two bodies move as one, until a load breaks it.
#include <algorithm>
#include <stdexcept>

#include "talus/constraint/fixed_joint.hpp"
#include "talus/constraint/joint_axis.hpp"
#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_weld_has_at_largest_force_and_largest_torque {

/// A fixed joint that is removed after the first step in which its mean force or torque is above
/// the largest one. From the next step on the bodies are free, and may touch each other.
struct weld final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "weld";
  static constexpr int rows = fixed_joint::rows;

  vec3 at{0, 0, 0};                ///< the point to which its torque refers, in the world
  real largest_force = no_limit;   ///< mass times length over squared time; above 0
  real largest_torque = no_limit;  ///< the same times length; above 0

  /// Throws invalid_argument that names the wrong value.
  void validate() const {
    detail::require_point(name, "point", at);
    if (!(largest_force > 0) || !(largest_torque > 0))
      detail::fail<std::invalid_argument>(
          "the largest force and torque of a weld must be above 0, but are {} and {}",
          detail::text(largest_force), detail::text(largest_torque));
  }

  struct anchors {
    detail::joint_frames frames;
    real largest_force = no_limit, largest_torque = no_limit;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_at(at, {1, 0, 0, 0}, a, b), std::min(largest_force, no_limit),
            std::min(largest_torque, no_limit)};
  }
  static void write(const anchors& x, detail::line_writer& to) {
    fixed_joint::write({x.frames}, to);
  }
  /// Whether a force and a torque break it.
  [[nodiscard]] static bool breaks(const anchors& x, real force, real torque) {
    return force > x.largest_force || torque > x.largest_torque;
  }
};

}  // namespace a_weld_has_at_largest_force_and_largest_torque

}  // namespace talus
