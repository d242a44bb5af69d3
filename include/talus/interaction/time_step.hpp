#pragma once
// How many steps a soft contact takes at the advised time step.
#include "talus/core/math.hpp"

namespace talus::detail {

/// Steps that a contact takes at least at a fifth of the critical time step.
inline constexpr real steps_of_contact = 20;
/// Some more, so that one more or less at the ends of a contact leaves as many.
inline constexpr real steps_in_critical = (steps_of_contact + 1) / 5;

/// Whether an impact is one of its own: faster than what gravity makes of a contact while it
/// lasts, as it does where bodies come to rest on each other.
[[nodiscard]] inline bool is_impact(real speed, real duration, real gravity) {
  return speed > gravity * duration;
}

}  // namespace talus::detail
