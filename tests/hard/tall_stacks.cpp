// long
// Stacks of 20 and 100 boxes for a minute, and a pyramid of 820 boxes, at the default settings, on
// one rank and where the boundaries of four cut through the middle of bodies.
#include <doctest/doctest.h>

#include "stacks.hpp"

using namespace talus;
using namespace talus::hard;

TEST_CASE("stacks of 20 and 100 boxes stand for 60 s without drift") {
  const frame_of f;
  for (const int n : {20, 100}) {
    const std::string name = "stack of " + std::to_string(n) + ", 60 s";
    const auto alone = run<blocks>(
        whole, f.dt(), 240 * 60, [&](auto& w) { stack(w, n); }, 240);
    check_stands(name + ", 1 rank", alone, f);
    const auto along = run<blocks>(
        quarters, f.dt(), 240 * 60, [&](auto& w) { stack(w, n); }, 240);
    check_stands(name + ", 4 ranks along it", along, f);
    const cuts layers{.cells = {1, 1, 4}, .cuts = {.z = {0.25 * n, 0.5 * n, 0.75 * n + 0.5}}};
    const auto across = run<blocks>(
        layers, f.dt(), 240 * 60, [&](auto& w) { stack(w, n); }, 240);
    check_stands(name + ", 4 ranks across it", across, f);
  }
}

TEST_CASE("a pyramid of base 40 stands") {
  const frame_of f;
  for (const cuts& domains : {whole, quarters}) {
    const std::string ranks = domains.size() == 1 ? ", 1 rank" : ", 4 ranks";
    const auto p = run<blocks>(domains, f.dt(), 240 * 5, [&](auto& w) { pyramid(w, 40); });
    check_stands("pyramid of 40" + ranks, p, f);
  }
}
