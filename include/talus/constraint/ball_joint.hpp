#pragma once
// A ball joint: one point of a body stays at one point of another, and both turn freely about it.
#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_ball_joint_has_at {

/// Holds a point of one body at a point of another: a spherical joint.
struct ball_joint final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "ball_joint";
  static constexpr int rows = 3;

  vec3 at{0, 0, 0};  ///< the common point, in the world, when the bodies are joined

  /// Throws invalid_argument unless the point is finite.
  void validate() const { detail::require_point(name, "point", at); }

  struct anchors {
    detail::joint_frames frames;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_at(at, {1, 0, 0, 0}, a, b)};
  }
  static void write(const anchors&, detail::line_writer& to) { to.hold_point(); }
};

}  // namespace a_ball_joint_has_at

}  // namespace talus
