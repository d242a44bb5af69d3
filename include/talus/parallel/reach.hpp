#pragma once
// The distance within which a rank is connected to ranks that its region does not touch.
#include "talus/core/math.hpp"

namespace talus {

/// For bodies larger than a domain: every rank is connected to all ranks whose regions come within
/// the distance, with any decomposition.
///   world.decompose(slabs<5>{.lower = 0, .upper = 10}, reach{4.5});
struct reach {
  real distance = 0;  ///< A length >= 0; 0: the ranks that touch. As large as the largest body.
};

}  // namespace talus
