#pragma once
// The number of steps of a soft contact at the advised time step.
#include "talus/core/math.hpp"

namespace talus::detail {

/// Minimum number of steps of a contact at a fifth of the critical time step.
inline constexpr real steps_of_contact = 20;
/// A few more, so that the count stays above it with one more or less at the ends of a contact.
inline constexpr real steps_in_critical = (steps_of_contact + 1) / 5;

/// Whether an impact is distinct: faster than the speed that gravity adds during the contact, as it
/// does when bodies come to rest on each other.
[[nodiscard]] inline bool is_impact(real speed, real duration, real gravity) {
  return speed > gravity * duration;
}

}  // namespace talus::detail
