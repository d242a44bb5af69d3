#pragma once
// A hinge: two bodies turn about a common axis, and do nothing else.
#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_hinge_has_at_axis_limits_motor_spring_and_friction {

/// A revolute joint. Its angle is 0 when the bodies are joined.
struct hinge final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "hinge";
  static constexpr int rows = 5 + detail::rows_of_axis;
  static constexpr bool has_angle = true;

  vec3 at{0, 0, 0};          ///< a point of the axis, in the world, when the bodies are joined
  vec3 axis{0, 0, 1};        ///< its direction, of any length; the second body turns about it
  joint_limits limits = {};  ///< of the angle
  torque_motor motor = {};   ///< of the angle
  joint_spring spring = {};  ///< of the angle
  real friction = 0;         ///< the largest torque of friction, of either sign

  /// Throws invalid_argument that names the wrong value.
  void validate() const {
    detail::require_point(name, "point", at), detail::require_axis(name, "axis", axis);
    detail::require_rules(name, detail::rules_of(limits, motor, spring, friction));
  }

  struct anchors {
    detail::joint_frames frames;
    detail::axis_rules turn;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_at(at, detail::rotation_to(axis), a, b),
            detail::rules_of(limits, motor, spring, friction)};
  }
  static void write(const anchors& x, detail::line_writer& to) {
    to.hold_point(), to.hold_axis(), to.turn(x.turn);
  }
  static void drive(anchors& x, const torque_motor& m) { x.turn.motor = detail::motor_of(m); }
};

}  // namespace a_hinge_has_at_axis_limits_motor_spring_and_friction

}  // namespace talus
