#pragma once
// Whether a region can hold a point.
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// Throws invalid_argument, with the name of the function that was given it, for a region of known
/// bounds that holds no point: its corners are interchanged, or one of its numbers is NaN.
template <class Region>
void require_region(const Region& region, const char* what) {
  if constexpr (requires { region.extent().lower; }) {
    const auto bounds = region.extent();
    for (int k = 0; k < 3; ++k)
      if (!(bounds.lower[k] <= bounds.upper[k]))
        fail<std::invalid_argument>(
            "{} was given a region from {} to {}, in which no point lies: give its lowest corner "
            "first, a radius of 0 or more, and numbers everywhere",
            what, bounds.lower, bounds.upper);
  }
}

}  // namespace talus::detail
