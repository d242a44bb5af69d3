// long
// A pyramid of 100 rows, 5,050 boxes, at 60 and 240 steps per second and the default settings.
#include <doctest/doctest.h>

#include "stacks.hpp"

using namespace talus;
using namespace talus::hard;

TEST_CASE("a pyramid of 100 rows stands") {
  for (const int rate : {60, 240}) {
    const int seconds = rate == 60 ? 20 : 5;
    const auto o = run<blocks>(
        whole, 1.0 / rate, rate * seconds, [](auto& w) { pyramid(w, 100); }, rate);
    const std::string name = "pyramid of 100, " + std::to_string(rate) + " steps per second";
    CHECK(o.finite);
    check_error(name, "furthest from the start at any time", o.furthest(), 1e-4);
    check_error(name, "deepest overlap at any time, over the mean radius", o.deepest, 1e-4);
  }
}
