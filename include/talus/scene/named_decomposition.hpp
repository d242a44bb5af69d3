#pragma once
// A decomposition by name, for programs that let their users choose.
#include <algorithm>
#include <string>

#include "talus/core/error.hpp"
#include "talus/parallel/any_decomposition.hpp"
#include "talus/parallel/bisection.hpp"
#include "talus/parallel/grid.hpp"
#include "talus/parallel/hexagonal.hpp"
#include "talus/parallel/slabs.hpp"
#include "talus/scene/command_line.hpp"

namespace talus {

/// Divides the rectangle between two corners (and all space above, below and around it) among all
/// ranks, as "grid" (cells in x and y), "slabs" (along x), "bisection" (cut across x and y) or
/// "hexagonal" (1, 7, 19, 37, ... ranks). Throws usage_error for another name. (A template, so that
/// only programs that call it compile all of them.)
template <class Result = any_decomposition>
[[nodiscard]] Result named_decomposition(const std::string& name, const vec3& lower,
                                         const vec3& upper) {
  if (name == "grid")
    return grid<dynamic, dynamic>{.lower = {.x = lower[0], .y = lower[1]},
                                  .upper = {.x = upper[0], .y = upper[1]}};
  if (name == "slabs") return slabs<dynamic>{.lower = lower[0], .upper = upper[0]};
  if (name == "bisection")
    return bisection<dynamic>{.lower = {.x = lower[0], .y = lower[1]},
                              .upper = {.x = upper[0], .y = upper[1]}};
  if (name == "hexagonal")
    return hexagonal<dynamic>{.width = std::max(upper[0] - lower[0], upper[1] - lower[1]),
                              .centre = 0.5 * (lower + upper)};
  detail::fail<usage_error>(
      "there is no decomposition '{}' for a rectangle: choose grid, slabs, bisection or hexagonal",
      name);
}

#ifdef TALUS_COMPILED
extern template any_decomposition named_decomposition<any_decomposition>(const std::string&,
                                                                         const vec3&, const vec3&);
#endif

}  // namespace talus
