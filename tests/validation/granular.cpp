// Granular media, small enough for each run of the tests; at full size in granular_flow and
// granular_static.
#include <doctest/doctest.h>

#include "granular_media.hpp"
#include "record.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE("a small granular gas cools by Haff's law, on 1 and 4 ranks") {
  for (const int ranks : {1, 4}) {
    const auto gas = cool_gas(1000, 0.05, 0.8, 1, ranks, 0.02);
    check_error("Haff's law, small", fmt::format("T (1 + t/tau)^2 / T0 - 1, {} ranks", ranks),
                gas.worst, 0.05);
  }
}

// So few grains have a bulk of some dozens, with an uncertainty of its density of 0.025: three
// piles.
TEST_CASE("small poured piles are the less dense, the more friction") {
  real before = 0.66;
  for (const real friction : {0.0, 0.2, 0.8}) {
    real fraction = 0, contacts = 0;
    for (const real height : {1.0, 1.4, 2.0}) {
      const auto p = pour(1000, friction, 4, 1, height);
      fraction += p.fraction / 3, contacts += p.contacts.mean / 3;
      CHECK(p.fraction > 0.52);
    }
    MESSAGE("mu ", friction, ": phi ", fraction, ", Z ", contacts);
    check_holds("packing, small", fmt::format("less dense with more friction, mu {}", friction),
                true, fraction < before);
    CHECK(fraction > 0.55);
    CHECK(contacts > 4);
    CHECK(contacts < 6.3);
    before = fraction;
  }
}
