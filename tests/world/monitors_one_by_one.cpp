// No monitor changes a bit of a trajectory: each on its own.
// long
// timeout: 300
#include <doctest/doctest.h>

#include "monitored_pile.hpp"

using namespace monitored;

namespace {

template <class... Features>
using sphere_scene = scenario<bodies<sphere, plane>, transport<threads>,
                              decomposition<grid<dynamic, dynamic>>, features<Features...>>;

}  // namespace

TEST_CASE("each monitor by itself changes no trajectory by a bit, on 1 and 4 ranks") {
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    const std::string spheres = digest_of_pile<sphere_scene<>>(ranks);
    CHECK(digest_of_pile<sphere_scene<energy_ledger>>(ranks) == spheres);
    CHECK(digest_of_pile<sphere_scene<momentum_balance>>(ranks) == spheres);
    CHECK(digest_of_pile<sphere_scene<penetration_monitor>>(ranks) == spheres);
    CHECK(digest_of_pile<sphere_scene<residual_monitor>>(ranks) == spheres);
    using linear = soft_scene<rolling_springs, semi_implicit_euler, energy_ledger>;
    using bare = soft_scene<rolling_springs, semi_implicit_euler>;
    CHECK(digest_of_pile<linear>(ranks) == digest_of_pile<bare>(ranks));
    using verlet = soft_scene<hertz_springs, velocity_verlet, energy_ledger, momentum_balance>;
    using bare_verlet = soft_scene<hertz_springs, velocity_verlet>;
    CHECK(digest_of_pile<verlet>(ranks) == digest_of_pile<bare_verlet>(ranks));
  }
}
