// long
// Structures within a hundredth of falling where four ranks meet in them, and arches of little
// friction.
#include <doctest/doctest.h>

#include "structures.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE(
    "blocks overhang by L/2 (1 + 1/2 + ... + 1/n): across four ranks they stand at 0.99 and fall "
    "at 1.01 of it") {
  check_overhang(4);
}

TEST_CASE(
    "a semicircular arch of wedges across four ranks stands at 1.02 and falls at 0.98 of the least "
    "thickness") {
  check_arches(4);
}

TEST_CASE("arches that touch each other stand across two and four ranks") {
  for (const int ranks : {2, 4}) {
    CAPTURE(ranks);
    CHECK(moved(arches(ranks, 2, 0.15, 0.3)) < 2e-4);
  }
}

TEST_CASE("an arch of little friction must be thicker, and without enough of it none stands") {
  for (const auto& [mu, least] : {std::pair{0.36, 0.14138}, std::pair{0.34, 0.16272}})
    for (const real part : {0.98, 1.02})
      check_stands("arch, friction", fmt::format("mu {}, 20 wedges at {:.2f}", mu, part), part > 1,
                   watch(1, part > 1 ? 3 : 6, [&](auto& w) { arch(w, 20, part * least, mu); }), 1);
  check_stands("arch, friction", "mu 0.3, thickness 0.3", false,
               watch(1, 6, [&](auto& w) { arch(w, 20, 0.3, 0.3); }), 1);
}

TEST_CASE("the wave through dominoes is as fast and steady across four ranks as on one") {
  const auto speeds = speeds_of_wave(4, 1, dt);
  check_steady("dominoes, 4 ranks", speeds);
  check_relative("dominoes", "speed on 4 ranks to that on 1", 1,
                 mean_of(speeds) / mean_of(speeds_of_wave(1, 1, dt)), 0.02);
}
