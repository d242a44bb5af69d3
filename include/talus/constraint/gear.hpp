#pragma once
// A pair of gears: two bodies turn about their axes at a constant ratio.
#include <cmath>
#include <stdexcept>

#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_gear_has_first_axis_second_axis_and_ratio {

/// Couples the rotations of two bodies about axes that are fixed in the world: the angle of the
/// second is `ratio` times that of the first. Other joints hold the bodies on their axes, and bear
/// what the teeth push them apart with. Its torque is that on the first body.
struct gear final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "gear";
  static constexpr int rows = 1;

  vec3 first_axis{0, 0, 1};   ///< of any length
  vec3 second_axis{0, 0, 1};  ///< of any length
  real ratio = -1;            ///< not 0; negative for external gears on parallel axes

  /// Throws invalid_argument that names the wrong value.
  void validate() const {
    detail::require_axis(name, "first axis", first_axis);
    detail::require_axis(name, "second axis", second_axis);
    if (!std::isfinite(ratio) || ratio == 0)
      detail::fail<std::invalid_argument>("the ratio of a gear must be finite and not 0, but is {}",
                                          detail::text(ratio));
  }

  struct anchors {
    detail::joint_frames frames;
    quat first{1, 0, 0, 0}, second{1, 0, 0, 0};  ///< frames around the axes, in the world
    real ratio = -1;
    real distance = 0;  ///< of the bodies
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    anchors x;
    x.first = detail::rotation_to(first_axis), x.second = detail::rotation_to(second_axis);
    x.frames.turn_a = a.orientation.conjugate() * x.first;
    x.frames.turn_b = b.orientation.conjugate() * x.second;
    x.ratio = ratio, x.distance = (b.position - a.position).norm();
    return x;
  }
  /// How far the points may be from each other.
  [[nodiscard]] static real room(const anchors& x) { return x.distance; }
  static void write(const anchors& x, detail::line_writer& to) {
    to.hold_ratio(x.first.toRotationMatrix(), x.second.toRotationMatrix(), x.ratio);
  }
};

}  // namespace a_gear_has_first_axis_second_axis_and_ratio

}  // namespace talus
