#pragma once
// A cylindrical joint: two bodies slide along a common axis, and turn about it.
#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_cylindrical_joint_has_at_axis_turn_limits_turn_motor_turn_spring_turn_friction_travel_limits_travel_motor_travel_spring_and_travel_friction {

/// A joint that lets bodies turn about an axis and slide along it. The angle and the travel are 0
/// when the bodies are joined.
struct cylindrical_joint final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "cylindrical_joint";
  static constexpr int rows = 4 + 2 * detail::rows_of_axis;
  static constexpr bool has_angle = true, has_travel = true, roams = true;

  vec3 at{0, 0, 0};               ///< a point of the axis, in the world, when the bodies are joined
  vec3 axis{0, 0, 1};             ///< its direction, of any length
  joint_limits turn_limits = {};  ///< of the angle
  torque_motor turn_motor = {};   ///< of the angle
  joint_spring turn_spring = {};  ///< of the angle
  real turn_friction = 0;         ///< the largest torque of friction
  joint_limits travel_limits = {};  ///< of the travel
  force_motor travel_motor = {};    ///< of the travel
  joint_spring travel_spring = {};  ///< of the travel
  real travel_friction = 0;         ///< the largest force of friction

  /// Throws invalid_argument that names the wrong value.
  void validate() const {
    detail::require_point(name, "point", at), detail::require_axis(name, "axis", axis);
    detail::require_rules(name,
                          detail::rules_of(turn_limits, turn_motor, turn_spring, turn_friction));
    detail::require_rules(
        name, detail::rules_of(travel_limits, travel_motor, travel_spring, travel_friction));
  }

  struct anchors {
    detail::joint_frames frames;
    detail::axis_rules turn, way;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_at(at, detail::rotation_to(axis), a, b),
            detail::rules_of(turn_limits, turn_motor, turn_spring, turn_friction),
            detail::rules_of(travel_limits, travel_motor, travel_spring, travel_friction)};
  }
  static void write(const anchors& x, detail::line_writer& to) {
    to.hold(detail::line_along(to.g, 0)), to.hold(detail::line_along(to.g, 1));
    to.hold_axis();
    to.turn(x.turn), to.travel(x.way);
  }
  static void drive(anchors& x, const torque_motor& m) { x.turn.motor = detail::motor_of(m); }
  static void drive(anchors& x, const force_motor& m) { x.way.motor = detail::motor_of(m); }
};

}  // namespace
   // a_cylindrical_joint_has_at_axis_turn_limits_turn_motor_turn_spring_turn_friction_travel_limits_travel_motor_travel_spring_and_travel_friction

}  // namespace talus
