#pragma once
// The same heap on any number of ranks, for any decomposition.
#include <doctest/doctest.h>

#include <string>
#include <talus/observe/digest.hpp>
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/cells.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/hexagonal.hpp>
#include <talus/parallel/reach.hpp>
#include <talus/parallel/ring.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

namespace {

using namespace talus;

/// A decomposition of the square from -4 to 4 in x and y.
struct sharing {
  const char* name;
  int ranks;
  any_decomposition decomposition;
};

inline std::vector<sharing> sharings() {
  const auto squares = [](int x, int y) {
    return grid<dynamic, dynamic>{
        .cells = {x, y}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
  };
  const half_space slanting(0.3, 0.8, 0.2, 0.1);
  return {
      {"one domain", 1, squares(1, 1)},
      {"two halves", 2, squares(2, 1)},
      {"grid of 4", 4, squares(2, 2)},
      {"hexagons, 7", 7, hexagonal<dynamic>{.width = 8}},
      {"grid of 9", 9, squares(3, 3)},
      {"hexagons, 19", 19, hexagonal<dynamic>{.width = 8}},
      {"slanting halves", 2, cells(slanting, complement(slanting))},
      {"ring of 4", 4, ring<dynamic>{.sectors = 4, .centre = {-6, -6, 0}, .angle = pi / 2}},
  };
}

/// The digest after `steps` steps of the scene of set_up(world); tend(world, step) is called after
/// each.
template <class Scenario, class SetUp, class Tend>
std::string digest_of(const sharing& how, int steps, SetUp&& set_up, Tend&& tend) {
  std::string digest;
  threads::launch({.ranks = how.ranks}, [&](threads::link& link) {
    world<Scenario> w(link, how.decomposition, reach{4});
    w.gravity({0, 0, -9.81});
    w.material({.restitution = 0.1, .friction = 0.5});
    w.global([&](auto& s) {
      s.add(plane{.normal = {0, 0, 1}}, {});
      for (const double side : {-1.0, 1.0}) {
        s.add(plane{.normal = {side, 0, 0}, .offset = -4}, {});
        s.add(plane{.normal = {0, side, 0}, .offset = -4}, {});
      }
    });
    set_up(w);
    for (int k = 0; k < steps; ++k) w.step(1.0 / 240), tend(w, k);
    const std::string found = state_digest(w);
    if (link.rank() == 0) digest = found;
  });
  return digest;
}

/// Checks that all decompositions give one digest, and returns it.
template <class Scenario, class SetUp, class Tend>
std::string check_same(int steps, SetUp&& set_up, Tend&& tend) {
  std::string first;
  for (const sharing& how : sharings()) {
    CAPTURE(std::string(how.name));
    const std::string found = digest_of<Scenario>(how, steps, set_up, tend);
    if (first.empty()) first = found;
    CHECK(found == first);
  }
  return first;
}

}  // namespace
