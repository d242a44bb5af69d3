#pragma once
// One contact point of two bodies, as found by the narrow phase.
#include <cstdint>

#include "talus/core/math.hpp"

namespace talus {

namespace detail {
/// Contact points of two flat faces, or of a face and the edge of a cylinder, at most.
inline constexpr int most_corners = 16;
}  // namespace detail

/// A point at which two bodies touch, or nearly touch.
struct contact_geometry {
  vec3 normal;   ///< unit, from body b towards body a
  vec3 point;    ///< midway between the two surfaces, in the world
  real gap = 0;  ///< signed distance of the surfaces along the normal; overlap < 0
  /// Identifies the point within its pair, the same from step to step: 32 bits for the touching
  /// parts, and 16 above for each body that is a union, its part.
  std::uint64_t feature = 0;

  /// The contact with the roles of the two bodies exchanged.
  [[nodiscard]] contact_geometry swapped() const { return {-normal, point, gap, feature}; }
};

}  // namespace talus
