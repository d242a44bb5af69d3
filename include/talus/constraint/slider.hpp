#pragma once
// A slider: two bodies slide along a common axis without turning.
#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_slider_has_at_axis_limits_motor_spring_and_friction {

/// A prismatic joint. Its travel is 0 when the bodies are joined.
struct slider final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "slider";
  static constexpr int rows = 5 + detail::rows_of_axis;
  static constexpr bool has_travel = true, roams = true;

  vec3 at{0, 0, 0};          ///< a point of the axis, in the world, when the bodies are joined
  vec3 axis{0, 0, 1};        ///< its direction, of any length; the second body slides along it
  joint_limits limits = {};  ///< of the travel
  force_motor motor = {};    ///< of the travel
  joint_spring spring = {};  ///< of the travel
  real friction = 0;         ///< the largest force of friction, of either sign

  /// Throws invalid_argument that names the wrong value.
  void validate() const {
    detail::require_point(name, "point", at), detail::require_axis(name, "axis", axis);
    detail::require_rules(name, detail::rules_of(limits, motor, spring, friction));
  }

  struct anchors {
    detail::joint_frames frames;
    detail::axis_rules way;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_at(at, detail::rotation_to(axis), a, b),
            detail::rules_of(limits, motor, spring, friction)};
  }
  static void write(const anchors& x, detail::line_writer& to) {
    to.hold(detail::line_along(to.g, 0)), to.hold(detail::line_along(to.g, 1));
    for (int k = 0; k < 3; ++k) to.hold(detail::line_of_cosine(to.g, k, (k + 1) % 3));
    to.travel(x.way);
  }
  static void drive(anchors& x, const force_motor& m) { x.way.motor = detail::motor_of(m); }
};

}  // namespace a_slider_has_at_axis_limits_motor_spring_and_friction

}  // namespace talus
