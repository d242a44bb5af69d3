#pragma once
// Every broad phase refuses bodies without a valid position.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"

namespace talus {

/// A body that no broad phase can hold: its centre or reach is NaN or infinite, its reach is
/// negative, or its centre is so far out that rounding of the coordinates exceeds its size.
struct unplaceable : std::runtime_error {
  unplaceable(std::size_t which, const std::string& what)
      : std::runtime_error(what), index(which) {}
  std::size_t index;  ///< position in the arrays given to build()
};

namespace detail {

/// Throws unplaceable for the first ball that is such a body. `reaches` are radii.
[[gnu::cold]] inline void require_placeable(std::span<const vec3> centres,
                                            std::span<const real> reaches) {
  constexpr real limit = real(std::uint64_t{1} << 44);
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const real r = reaches[i];
    if (!finite(centres[i]))
      throw unplaceable(i, compose("the centre {} is not finite: the motion has diverged; use a "
                                   "smaller time step or check forces and velocities",
                                   text(centres[i])));
    if (!(r >= 0) || !std::isfinite(r))
      throw unplaceable(
          i,
          compose("the reach {} is not a finite length: choose smaller speeds or a smaller dt", r));
    if (r > 0 && max_norm(centres[i]) > limit * r)
      throw unplaceable(i, compose("the centre {} is so far out that a size of {} is lost in "
                                   "rounding; remove bodies that leave the scene",
                                   text(centres[i]), r));
  }
}

}  // namespace detail
}  // namespace talus
