#pragma once
// The velocity bias of a contact: the solver works with the relative velocity minus the bias.
#include "talus/core/math.hpp"

namespace talus::detail {

/// Relative velocity of a against b, in the world, that a resting contact must leave. Some
/// integrators need it; with others nothing is stored.
template <bool Biased>
struct contact_bias {
  static constexpr bool biased = true;
  vec3 bias{0, 0, 0};
  real unused = 0;  ///< vectors are read together with the number that follows them
};
template <>
struct contact_bias<false> {
  static constexpr bool biased = false;
};

}  // namespace talus::detail
