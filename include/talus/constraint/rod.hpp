#pragma once
// A rod and a rope: the distance of two points is constant, or has a largest value.
#include <stdexcept>

#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"

namespace talus {

namespace detail {

/// The frames of a joint between two points of the world.
[[nodiscard]] inline joint_frames frames_between(const vec3& from, const vec3& to, const pose& a,
                                                 const pose& b) {
  joint_frames x = frames_at(from, {1, 0, 0, 0}, a, b);
  x.on_b = b.to_body(to);
  return x;
}

}  // namespace detail

inline namespace a_rod_has_from_and_to {

/// A massless rod with ball joints at both ends. Its length is the distance of the points when the
/// bodies are joined.
struct rod final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "rod";
  static constexpr int rows = 1;

  vec3 from{0, 0, 0};  ///< on the first body, in the world
  vec3 to{0, 0, 1};    ///< on the second body

  /// Throws invalid_argument unless the points are finite and different.
  void validate() const {
    detail::require_point(name, "first point", from),
        detail::require_point(name, "second point", to);
    if (from == to)
      detail::fail<std::invalid_argument>(
          "the points of a rod must be different, but both are {}: take a ball_joint",
          detail::text(from));
  }

  struct anchors {
    detail::joint_frames frames;
    real length = 0;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_between(from, to, a, b), (to - from).norm()};
  }
  /// How far the points may be from each other.
  [[nodiscard]] static real room(const anchors& x) { return x.length; }
  static void write(const anchors& x, detail::line_writer& to) {
    to.hold(detail::line_of_distance(to.g, x.length));
  }
};

}  // namespace a_rod_has_from_and_to

inline namespace a_rope_has_from_to_length_and_restitution {

/// A massless rope: the distance of two points is at most its length.
struct rope final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "rope";
  static constexpr int rows = 1;

  vec3 from{0, 0, 0};    ///< on the first body, in the world
  vec3 to{0, 0, 1};      ///< on the second body
  real length = 0;       ///< 0: the distance of the points when the bodies are joined
  real restitution = 0;  ///< when it becomes taut, in [0, 1]

  /// Throws invalid_argument that names the wrong value.
  void validate() const {
    detail::require_point(name, "first point", from),
        detail::require_point(name, "second point", to);
    const real distance = (to - from).norm();
    if (!(length >= 0) || !std::isfinite(length) || (length == 0 && distance == 0))
      detail::fail<std::invalid_argument>(
          "the length of a rope must be finite and above 0, but is {}", detail::text(length));
    if (length > 0 && length < distance * (1 - 1e-12))
      detail::fail<std::invalid_argument>(
          "a rope of length {} does not reach from {} to {}, which are {} apart",
          detail::text(length), detail::text(from), detail::text(to), detail::text(distance));
    if (!(restitution >= 0 && restitution <= 1))
      detail::fail<std::invalid_argument>("the restitution of a rope must be in [0, 1], but is {}",
                                          detail::text(restitution));
  }

  struct anchors {
    detail::joint_frames frames;
    real length = 0, restitution = 0;
  };
  /// What the bodies carry of it, for their present poses.
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {detail::frames_between(from, to, a, b), length > 0 ? length : (to - from).norm(),
            restitution};
  }
  /// How far the points may be from each other.
  [[nodiscard]] static real room(const anchors& x) { return x.length; }
  static void write(const anchors& x, detail::line_writer& to) {
    to.reach(x.length, x.restitution);
  }
};

}  // namespace a_rope_has_from_to_length_and_restitution

}  // namespace talus
