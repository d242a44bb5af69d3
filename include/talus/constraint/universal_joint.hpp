#pragma once
// A universal joint: two axes, one in each body, cross at a point and stay perpendicular.
#include <cmath>
#include <stdexcept>

#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_universal_joint_has_at_first_axis_second_axis_first_limits_first_spring_first_friction_second_limits_second_spring_and_second_friction {

/// Cardan's joint. Its first angle is that of the cross about the axis of the first body, its
/// second that of the second body about its own axis.
struct universal_joint final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "universal_joint";
  static constexpr int rows = 4 + 2 * detail::rows_of_axis;
  static constexpr bool has_angle = true;

  vec3 at{0, 0, 0};           ///< where the axes cross, in the world, when the bodies are joined
  vec3 first_axis{0, 0, 1};   ///< in the first body, of any length
  vec3 second_axis{1, 0, 0};  ///< in the second body, perpendicular to it
  joint_limits first_limits = {};   ///< of the first angle
  joint_spring first_spring = {};   ///< of the first angle
  real first_friction = 0;          ///< the largest torque of friction
  joint_limits second_limits = {};  ///< of the second angle
  joint_spring second_spring = {};  ///< of the second angle
  real second_friction = 0;         ///< the largest torque of friction

  /// Throws invalid_argument that names the wrong value.
  void validate() const {
    detail::require_point(name, "point", at);
    detail::require_axis(name, "first axis", first_axis);
    detail::require_axis(name, "second axis", second_axis);
    if (std::abs(unit(first_axis).dot(unit(second_axis))) > 1e-9)
      detail::fail<std::invalid_argument>(
          "the axes of a universal_joint must be perpendicular, but are {} and {}",
          detail::text(first_axis), detail::text(second_axis));
    detail::require_rules(
        name, detail::rules_of(first_limits, torque_motor{}, first_spring, first_friction));
    detail::require_rules(
        name, detail::rules_of(second_limits, torque_motor{}, second_spring, second_friction));
  }

  struct anchors {
    detail::joint_frames frames;
    detail::axis_rules first, second;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_at(at, detail::rotation_to(first_axis, second_axis), a, b),
            detail::rules_of(first_limits, torque_motor{}, first_spring, first_friction),
            detail::rules_of(second_limits, torque_motor{}, second_spring, second_friction)};
  }
  static void write(const anchors& x, detail::line_writer& to) {
    // The first axis of the frame is the second axis of the joint, its third the first one.
    const mat3 &a = to.g.axes_a, &b = to.g.axes_b;
    to.hold_point();
    to.hold(detail::line_of_cosine(to.g, 2, 0));
    to.turn_about(a.col(2), portable::atan2(b.col(0).dot(a.col(1)), b.col(0).dot(a.col(0))),
                  x.first);
    to.turn_about(b.col(0), portable::atan2(a.col(2).dot(b.col(1)), a.col(2).dot(b.col(2))),
                  x.second);
  }
};

}  // namespace
   // a_universal_joint_has_at_first_axis_second_axis_first_limits_first_spring_first_friction_second_limits_second_spring_and_second_friction

}  // namespace talus
