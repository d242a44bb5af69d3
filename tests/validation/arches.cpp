// alone
// timeout: 300
// The semicircular arch of wedges at the least thickness, of one rank, at the default settings.
// (More structures, and four ranks: structures.cpp and structures_long.cpp.)
#include <doctest/doctest.h>

#include "structures.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE("a semicircular arch of wedges stands at 1.02 and falls at 0.98 of the least thickness") {
  check_arches(1);
}

TEST_CASE("eight arches side by side stand as one does") {
  CHECK(moved(arches(1, 8, 1.02 * 0.10746, 0.5)) < 1e-6);
}

TEST_CASE("arches that touch each other stand") {
  constexpr real width = 0.3;
  for (const real gap : {0.0, 1e-4}) CHECK(moved(arches(1, 2, 0.15, width + gap)) < 2e-4);
  CHECK(moved(arches(1, 4, 0.15, width)) < 2e-4);
  CHECK(moved(arches(1, 2, 0.3, width)) < 2e-4);
}
