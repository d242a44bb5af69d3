#pragma once
// Random numbers, points and rotations for tests; the same on every machine for one seed.
#include <random>

#include "talus/core/math.hpp"

namespace talus {

struct generator {
  std::mt19937_64 engine;
  real operator()(real low, real high) {
    return low + (high - low) * real(engine() >> 11) * 0x1p-53;
  }
  /// In a box about the origin.
  vec3 point(const vec3& half) {
    const real x = (*this)(-half[0], half[0]), y = (*this)(-half[1], half[1]);
    return {x, y, (*this)(-half[2], half[2])};
  }
  vec3 point(real half) { return point(vec3(half, half, half)); }
  vec3 direction() {
    for (;;) {
      const vec3 v = point(1);
      if (v.squaredNorm() < 1 && v.squaredNorm() > 1e-3) return v.normalized();
    }
  }
  quat turn() { return rotation(direction(), (*this)(0, 2 * pi)); }
};

}  // namespace talus
