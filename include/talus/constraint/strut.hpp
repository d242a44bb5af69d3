#pragma once
// A strut between two points: a spring and a damper, a cylinder that a motor drives.
#include <stdexcept>

#include "talus/constraint/rod.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_strut_has_from_to_limits_motor_spring_and_friction {

/// A massless strut with ball joints at both ends, which changes its length. Its travel is by how
/// much it is longer than when the bodies were joined. Alone it holds nothing: give it a spring, a
/// motor (a hydraulic cylinder), limits or friction. For a constant length take a rod.
struct strut final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "strut";
  static constexpr int rows = detail::rows_of_axis;
  static constexpr bool has_travel = true, roams = true;

  vec3 from{0, 0, 0};        ///< on the first body, in the world
  vec3 to{0, 0, 1};          ///< on the second body
  joint_limits limits = {};  ///< of the travel
  force_motor motor = {};    ///< of the travel; a positive force pushes the points apart
  joint_spring spring = {};  ///< of the travel
  real friction = 0;         ///< the largest force of friction, of either sign

  /// Throws invalid_argument that names the wrong value.
  void validate() const {
    detail::require_point(name, "first point", from),
        detail::require_point(name, "second point", to);
    if (from == to)
      detail::fail<std::invalid_argument>(
          "the points of a strut must be different, but both are {}: a strut of length 0 has no "
          "direction",
          detail::text(from));
    detail::require_rules(name, detail::rules_of(limits, motor, spring, friction));
  }

  struct anchors {
    detail::joint_frames frames;
    real length = 0;
    detail::axis_rules way;
  };
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_between(from, to, a, b), (to - from).norm(),
            detail::rules_of(limits, motor, spring, friction)};
  }
  /// How far the points are from each other without travel.
  [[nodiscard]] static real room(const anchors& x) { return x.length; }
  static void write(const anchors& x, detail::line_writer& to) { to.stretch(x.length, x.way); }
  static void drive(anchors& x, const force_motor& m) { x.way.motor = detail::motor_of(m); }
};

}  // namespace a_strut_has_from_to_limits_motor_spring_and_friction

}  // namespace talus
