// alone
// timeout: 300
// The semicircular arch of wedges at the least thickness, of one rank, at the default settings.
// (More structures, and four ranks: structures.cpp and structures_long.cpp.)
#include <doctest/doctest.h>

#include "structures.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE("a semicircular arch of wedges stands at 1.02 and falls at 0.98 of the least thickness") {
  const int ranks = 1;
  for (const auto& [n, least] : {std::pair{18, 0.105964}, std::pair{20, 0.10746}})
    for (const real part : {0.98, 1.02})
      check_stands("arch" + on(ranks), fmt::format("{} wedges at {:.2f}", n, part), part > 1,
                   watch(ranks, part > 1 ? 3 : 6, [&](auto& w) { arch(w, n, part * least, 0.7); }),
                   1);
}

/// `count` arches of 20 wedges, this far from each other.
static tracks arches(int count, real thickness, real distance) {
  return watch(1, 3, [&](auto& w) {
    const auto m = w.material({.friction = 0.7});
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{}, m); });
    for (int k = 0; k < count; ++k) add_arch(w, m, 20, thickness, distance * k);
  });
}

TEST_CASE("eight arches side by side stand as one does") {
  CHECK(moved(arches(8, 1.02 * 0.10746, 0.5)) < 1e-6);
}

TEST_CASE("arches that touch each other stand") {
  constexpr real width = 0.3;
  for (const real gap : {0.0, 1e-4}) CHECK(moved(arches(2, 0.15, width + gap)) < 2e-4);
  CHECK(moved(arches(4, 0.15, width)) < 2e-4);
  CHECK(moved(arches(2, 0.3, width)) < 2e-4);
}
