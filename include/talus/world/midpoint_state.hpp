#pragma once
// What a world keeps for integrator<moreau_midpoint>.
#include <array>
#include <cstddef>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// How a body with an inertia tensor was turned in the middle of the last step, with the spin that
/// it had right after it.
struct earlier_turn {
  quat orientation{1, 0, 0, 0};
  vec3 spin{0, 0, 0};
  bool known = false;  ///< it is found when a contact asks for it
};
/// Of the bodies of each finite shape, in the order of their store; empty for round shapes. It
/// lasts for one search for contacts.
template <std::size_t Shapes>
struct midpoint_state {
  std::array<plain_vector<earlier_turn>, Shapes> earlier;
};

}  // namespace talus::detail
