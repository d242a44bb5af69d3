#pragma once
// Steps that driven bodies spoil: contacts make a body far faster than any body was, because it was
// jammed between a driven body and a wall and is released; or a driven body itself jumps.
#include <cstdint>
#include <string_view>

#include "talus/core/id.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// A step in which contacts made a body much faster than any body was before. Speeds are lengths
/// over time; step 0: none so far.
struct speed_leap {
  std::uint64_t step = 0;
  real before = 0, after = 0;

  [[nodiscard]] real ratio() const { return before > 0 ? after / before : 0; }
};

/// The farthest that a driven body went in one step. Step 0: none moved so far.
struct driven_jump {
  std::uint64_t step = 0;
  real time = 0, dt = 0;  ///< at its start, and its length
  system_id body = no_id;
  std::string_view shape;
  real way = 0;  ///< length; see way_of_driven()
};

}  // namespace talus::detail
