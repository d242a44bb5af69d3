#pragma once
// A contact in the form used by the solvers of whole islands, for any kind.
#include <array>
#include <cstdint>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Data of one contact for the Delassus operator.
struct island_contact {
  std::int32_t a = 0, b = -1;  ///< bodies; b = -1 if it cannot move
  mat3 axes;                   ///< rows: normal from b to a, two tangents
  vec3 arm_a, arm_b;           ///< from the centres of mass to the contact point
  real target_velocity = 0, friction = 0;
  vec3 impulse;                     ///< on a, in the world
  std::array<real, 2> drive{0, 0};  ///< tangential velocity of a against b by immovable bodies
  real correction_rate = 0;         ///< of separation, for the position correction
};

}  // namespace talus::detail
