#pragma once
// The reports of check_connections, and its sampling parameters.
#include <cstdint>
#include <string>

#include "talus/core/math.hpp"

namespace talus {

/// What is wrong between two ranks.
enum class flaw : std::uint8_t {
  one_sided,  ///< One rank is connected to the other, but not the reverse.
  missing,    ///< The regions touch or overlap, but neither rank is connected to the other.
  mismatch,   ///< The two ranks define their common boundary differently.
  gap,        ///< A point that no rank owns.
  overlap     ///< A point that two ranks own.
};

/// One flaw, with its ranks, a point that shows it, and a message for the user with the planes and
/// the remedy.
struct connection_flaw {
  flaw kind;
  int rank;
  int other;
  vec3 point;
  std::string message;
};

struct connection_check {
  int samples = 200;        ///< Sites sampled for every rank, each with some tens of points.
  int first = 0;            ///< The ranks whose boundaries are sampled: from `first`...
  int last = 1 << 30;       ///< ...up to but not including `last`.
  std::uint64_t seed = 42;  ///< Seed of the random sites.
};

}  // namespace talus
