#pragma once
// Steps in which contacts make a body far faster than any body was: a body jammed between a driven
// body and a wall is released.
#include <cstdint>

#include "talus/core/math.hpp"

namespace talus::detail {

/// A step in which contacts made a body much faster than any body was before. Speeds are lengths
/// over time; step 0: none so far.
struct speed_leap {
  std::uint64_t step = 0;
  real before = 0, after = 0;

  [[nodiscard]] real ratio() const { return before > 0 ? after / before : 0; }
};

}  // namespace talus::detail
