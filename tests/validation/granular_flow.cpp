// long
// Granular media in motion: Haff's law, Beverloo's law.
#include <doctest/doctest.h>

#include "granular_media.hpp"
#include "record.hpp"

using namespace talus;
using namespace talus::validation;

TEST_CASE("a granular gas cools by Haff's law, on 1 and 4 ranks") {
  for (const auto& [restitution, ranks] : {std::pair{0.9, 1}, {0.8, 1}, {0.9, 4}}) {
    const auto gas = cool_gas(27000, 0.05, restitution, 2, ranks);
    MESSAGE("e ", restitution, ": tau ", gas.tau, ", T(2 tau) ", gas.curve.back()[1]);
    check_error("Haff's law",
                fmt::format("T (1 + t/tau)^2 / T0 - 1, e {}, {} ranks", restitution, ranks),
                gas.worst, 0.03);
  }
}

// For smooth grains (friction 0.3; with 0.5 C is about a tenth less), and long enough that 1,400
// grains or more leave: the rate of a small orifice fluctuates.
TEST_CASE("the outflow through a round orifice follows Beverloo's law") {
  std::vector<std::array<real, 2>> points;
  real c = 0;
  const std::vector<real> diameters{5, 6, 7.5, 9, 11};
  for (const real diameter : diameters) {
    const auto flow = discharge(diameter, std::max(2.6 * diameter, diameter + 8), 3,
                                std::min(7 * std::pow(11 / diameter, 2.5), 30.0));
    const real law =
        flow.bulk * std::sqrt(gravity) * std::pow(diameter - 1.4, 2.5);  // times C; d = 1
    MESSAGE("D ", diameter, ": rate ", flow.rate, ", bulk ", flow.bulk, ", C ", flow.rate / law);
    c += flow.rate / law / static_cast<real>(diameters.size());
    points.push_back({std::log(diameter - 1.4), std::log(flow.rate / flow.bulk)});
  }
  check_absolute("Beverloo's law", "exponent", 2.5, line_through(points)[1], 0.05);
  check_relative("Beverloo's law", "C", 0.58, c, 0.1);
}
