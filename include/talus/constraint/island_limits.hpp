#pragma once
// How large the islands are that solvers by colours solve exactly.
#include <cstdint>

namespace talus::detail {

/// Alike on all ranks.
struct island_limits {
  std::uint32_t contacts = 5000;  ///< at most, of the largest island that is solved
  /// Where no body overloads others: sweeps work well in larger islands, as in a pile.
  std::uint32_t many = 1000;
};

}  // namespace talus::detail
