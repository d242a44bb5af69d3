// Stacks, walls and pyramids of boxes at the default settings: they stand, without drift, on one
// rank and across the boundaries of four through the middle of bodies; of any size, at any place.
// (Tall ones: tall_stacks.cpp.)
#include <doctest/doctest.h>

#include "stacks.hpp"

using namespace talus;
using namespace talus::hard;

TEST_CASE("a stack of ten boxes stands for 20 s without drift") {
  const frame_of f;
  const auto o = run<blocks>(
      whole, f.dt(), 240 * 20, [](auto& w) { stack(w, 10); }, 240);
  check_stands("stack of 10, 20 s", o, f);
}

TEST_CASE("a stack of ten boxes stands where four ranks meet") {
  const frame_of f;
  for (const real sway : {0.0, 0.01}) {
    const auto o = run<blocks>(quarters, f.dt(), 240 * 3, [&](auto& w) { stack(w, 10, f, sway); });
    check_stands("stack of 10, boundaries along it, sides " + std::to_string(sway), o, f);
  }
  const cuts layers{.cells = {1, 1, 4}, .cuts = {.z = {2.5, 5.5, 7.5}}};
  const auto o = run<blocks>(layers, f.dt(), 240 * 3, [&](auto& w) { stack(w, 10, f); });
  check_stands("stack of 10, boundaries across it", o, f);
}

TEST_CASE("a pyramid and a wall stand on one rank and on four") {
  const frame_of f;
  for (const cuts& domains : {whole, quarters}) {
    const std::string ranks = domains.size() == 1 ? ", 1 rank" : ", 4 ranks";
    const auto p = run<blocks>(domains, f.dt(), 240, [&](auto& w) { pyramid(w, 8); });
    check_stands("pyramid of 8" + ranks, p, f);
    const auto o = run<blocks>(domains, f.dt(), 120, [&](auto& w) { wall(w, 10, 10); });
    check_stands("wall of 10 by 10" + ranks, o, f);
  }
}

TEST_CASE("stacks a million times smaller and larger, and a million lengths away, stand as well") {
  for (const cuts& domains : {whole, quarters})
    for (const frame_of& f :
         {frame_of{1e-6, {0, 0, 0}}, frame_of{1e6, {0, 0, 0}}, frame_of{1, {1e6, -1e6, 1e6}}}) {
      const std::string ranks = domains.size() == 1 ? ", 1 rank" : ", 4 ranks";
      cuts here = domains;
      if (domains.size() == 4) here.cuts = {.x = {f.centre[0]}, .y = {f.centre[1]}};
      const auto o = run<blocks>(here, f.dt(), 240, [&](auto& w) { stack(w, 10, f); });
      check_stands("stack of 10, unit " + std::to_string(f.unit) + ", centre " +
                       std::to_string(f.centre[0]) + ranks,
                   o, f);
      const auto p = run<blocks>(here, f.dt(), 240, [&](auto& w) { pyramid(w, 5, f); });
      check_stands("pyramid of 5, unit " + std::to_string(f.unit) + ", centre " +
                       std::to_string(f.centre[0]) + ranks,
                   p, f);
    }
}
