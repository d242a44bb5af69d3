#pragma once
// One point of touch between two bodies, as the narrow phase finds it.
#include <cstdint>

#include "talus/core/math.hpp"

namespace talus {

/// Where two bodies touch, or nearly do.
struct contact_geometry {
  vec3 normal;   ///< unit, from body b towards body a
  vec3 point;    ///< midway between the two surfaces, in the world
  real gap = 0;  ///< signed distance of the surfaces along the normal; overlap < 0
  /// Names the point within its pair, the same from step to step: 32 bits for the parts that meet,
  /// and 16 above for each body that is a union, its part.
  std::uint64_t feature = 0;

  /// The same contact with the two bodies exchanged.
  [[nodiscard]] contact_geometry swapped() const { return {-normal, point, gap, feature}; }
};

}  // namespace talus
