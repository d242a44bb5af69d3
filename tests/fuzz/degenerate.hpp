#pragma once
// Poses in which faces, edges or centres of two bodies coincide.
#include <algorithm>
#include <talus/core/random.hpp>

namespace fuzz {

using talus::quat;
using talus::random_stream;
using talus::real;
using talus::vec3;

/// The space of a body: a ball, and the half edges of the box around it along the axes of the
/// world.
struct occupied {
  vec3 at{0, 0, 0};
  real radius = 0;
  vec3 half{0, 0, 0};
  vec3 velocity{0, 0, 0};
};

/// A rotation that maps axes to axes: up to two quarter or half turns.
inline quat axis_aligned(random_stream& r) {
  const auto turn = [&] {
    const auto axis = r.integer(3), quarters = r.integer(3);
    const vec3 about = vec3::Unit(static_cast<int>(axis));
    if (quarters == 0) return quat(1, 0, 0, 0);
    return quarters == 1 ? talus::rotation(about, talus::pi / 2)
                         : quat(0, about[0], about[1], about[2]);
  };
  const quat first = turn();
  return turn() * first;
}

/// A centre at which a body touches or overlaps another, and the direction to the other one.
struct degenerate_pose {
  vec3 at{0, 0, 0}, towards{0, 0, 0};
};
/// Along each axis the centres coincide, two sides lie flush, the boxes around the two touch, or
/// anything between. If `apart`, they touch along one axis at least, so that the bodies do not
/// overlap.
inline degenerate_pose degenerate_place(random_stream& r, const occupied& other, const vec3& half,
                                        bool apart) {
  degenerate_pose pose{.at = other.at};
  const int facing = static_cast<int>(r.integer(3));
  for (int i = 0; i < 3; ++i) {
    const real side = r.integer(2) ? 1 : -1;
    const auto kind = r.integer(5);
    const real both = other.half[i] + half[i], between = both * r.uniform();
    const bool touches = kind == 0 || (apart && i == facing);
    pose.at[i] += side * (touches     ? both
                          : kind == 1 ? other.half[i] - half[i]
                          : kind == 2 ? between
                                      : real(0));
    if (i == facing) pose.towards[i] = -side;
  }
  return pose;
}

}  // namespace fuzz
