// Granular media, small enough for every day; at full size in granular_flow and granular_static.
#include <doctest/doctest.h>

#include "granular_media.hpp"
#include "record.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE("a small granular gas cools by Haff's law, on 1 and 4 ranks") {
  for (const int ranks : {1, 4}) {
    const auto gas = cool_gas(1000, 0.05, 0.8, 1, ranks, true, 0.02);
    check_error("Haff's law, small", fmt::format("T (1 + t/tau)^2 / T0 - 1, {} ranks", ranks),
                gas.worst, 0.05);
  }
}

TEST_CASE("a small poured pile is the less dense, the more friction") {
  real before = 0.66;
  for (const real friction : {0.0, 0.2, 0.8}) {
    const auto p = pour(1000, friction, 4);
    MESSAGE("mu ", friction, ": phi ", p.fraction, ", Z ", p.contacts.mean);
    check_holds("packing, small", fmt::format("less dense with more friction, mu {}", friction),
                true, p.fraction < before);
    CHECK(p.fraction > 0.55);
    CHECK(p.contacts.mean > 4);
    CHECK(p.contacts.mean < 6.3);
    before = p.fraction;
  }
}
