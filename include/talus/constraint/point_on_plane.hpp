#pragma once
// A point of one body stays in a plane of another.
#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

inline namespace a_point_on_plane_has_at_and_normal {

/// A point of the second body moves freely in a plane that the first one carries.
struct point_on_plane final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "point_on_plane";
  static constexpr int rows = 1;
  static constexpr bool roams = true;

  vec3 at{0, 0, 0};      ///< the point, in the world, when the bodies are joined
  vec3 normal{0, 0, 1};  ///< of the plane, of any length

  /// Throws invalid_argument unless both are finite, and the normal is not 0.
  void validate() const {
    detail::require_point(name, "point", at), detail::require_axis(name, "normal", normal);
  }

  struct anchors {
    detail::joint_frames frames;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_at(at, detail::rotation_to(normal), a, b)};
  }
  static void write(const anchors&, detail::line_writer& to) {
    to.hold(detail::line_along(to.g, 2));
    to.note(to.g.gap.norm());
  }
};

}  // namespace a_point_on_plane_has_at_and_normal

}  // namespace talus
