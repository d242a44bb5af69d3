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

// Wedges of two arches that are diagonal neighbours share an edge; they carry nothing.
TEST_CASE("arches that touch each other stand, and move no further than the gap between them") {
  constexpr real width = 0.3;
  for (const int count : {2, 4})
    for (const real thickness : {0.14, 0.15, 0.3}) {
      CHECK(moved(arches(1, count, thickness, width)) < 1e-9);
      CHECK(moved(arches(1, count, thickness, width - 1e-6)) < 1e-5);
    }
  for (const int count : {2, 4}) CHECK(moved(arches(1, count, 0.15, width + 1e-4)) < 2e-4);
}
