#pragma once
// Steps in which contacts make a body far faster than anything was: what is jammed between a driven
// body and a wall comes free.
#include <cstdint>

#include "talus/core/math.hpp"

namespace talus::detail {

/// A step in which contacts made a body much faster than anything was before. Speeds are lengths
/// over time; a step of 0: there was none.
struct speed_leap {
  std::uint64_t step = 0;
  real before = 0, after = 0;

  [[nodiscard]] real ratio() const { return before > 0 ? after / before : 0; }
};

}  // namespace talus::detail
