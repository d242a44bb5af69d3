// long
// Stacks of 20 and 100 boxes, walls and a pyramid of 820 boxes, at the default settings, on one
// rank and across the boundaries of four through the middle of bodies.
#include <doctest/doctest.h>

#include "stacks.hpp"

using namespace talus;
using namespace talus::hard;

TEST_CASE("stacks of 20 and 100 boxes stand for 60 s without drift") {
  const frame_of f;
  for (const int n : {20, 100}) {
    const auto o = run<blocks>(
        whole, f.dt(), 240 * 60, [&](auto& w) { stack(w, n); }, 240);
    check_stands("stack of " + std::to_string(n) + ", 60 s, 1 rank", o, f);
  }
}

TEST_CASE("stacks of 20 and 100 boxes stand where four ranks meet along them") {
  const frame_of f;
  for (const int n : {20, 100}) {
    const int seconds = n == 20 ? 60 : 5;
    const auto o = run<blocks>(
        quarters, f.dt(), 240 * seconds, [&](auto& w) { stack(w, n); }, 240);
    check_stands("stack of " + std::to_string(n) + ", boundaries along it", o, f);
  }
}

TEST_CASE("a stack of 20 boxes stands for 60 s where the boundaries of four ranks cut across it") {
  // No rank knows the whole island, so only sweeps act, and 10 are too few.
  const frame_of f;
  const cuts layers{.cells = {1, 1, 4}, .cuts = {.z = {4.5, 10, 15.5}}};
  const auto o = run<blocks>(
      layers, f.dt(), 240 * 60,
      [&](auto& w) {
        w.solver().iterations = 50;
        stack(w, 20);
      },
      240);
  check_stands("stack of 20, 50 iterations, boundaries across it", o, f);
}

TEST_CASE("a pyramid of base 40 stands") {
  const frame_of f;
  for (const cuts& domains : {whole, quarters}) {
    const std::string ranks = domains.size() == 1 ? ", 1 rank" : ", 4 ranks";
    const auto p = run<blocks>(domains, f.dt(), 240 * 5, [&](auto& w) {
      w.solver().iterations = 50;
      pyramid(w, 40);
    });
    check_stands("pyramid of 40, 50 iterations" + ranks, p, f);
  }
}

TEST_CASE("a pyramid of 10 and a wall of 10 by 10 stand for 5 s") {
  const frame_of f;
  for (const cuts& domains : {whole, quarters}) {
    const std::string ranks = domains.size() == 1 ? ", 5 s, 1 rank" : ", 5 s, 4 ranks";
    const auto p = run<blocks>(domains, f.dt(), 240 * 5, [&](auto& w) { pyramid(w, 10); });
    check_stands("pyramid of 10" + ranks, p, f);
    const auto o = run<blocks>(domains, f.dt(), 240 * 5, [&](auto& w) { wall(w, 10, 10); });
    check_stands("wall of 10 by 10" + ranks, o, f);
  }
}
