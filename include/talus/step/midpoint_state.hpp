#pragma once
// State of a world for integrator<moreau_midpoint>.
#include <array>
#include <cstddef>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// The orientation of a body with an inertia tensor in the middle of the last step, and its spin
/// right after it.
struct earlier_turn {
  quat orientation{1, 0, 0, 0};
  vec3 spin{0, 0, 0};
  bool known = false;  ///< computed when a contact needs it
};
/// Earlier rotations of the bodies of each finite shape, in the order of their store; empty for
/// isotropic shapes. Valid for one search of contacts.
template <std::size_t Shapes>
struct midpoint_state {
  std::array<plain_vector<earlier_turn>, Shapes> earlier;
};

}  // namespace talus::detail
