#pragma once
// How the scenes of pinned digests are run.
#include <cstdint>
#include <cstdio>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

#include "scenes.hpp"

using namespace talus;

constexpr real g = 9.81;
using squares = grid<dynamic, dynamic>;

/// Five planes around the square from -half to half.
inline void add_tub(auto& scope, real half, material_id stuff) {
  scope.add(plane{.normal = {0, 0, 1}}, stuff);
  for (const real side : {-1.0, 1.0}) {
    scope.add(plane{.normal = {side, 0, 0}, .offset = -half}, stuff);
    scope.add(plane{.normal = {0, side, 0}, .offset = -half}, stuff);
  }
}

/// A world in a square from -half to half.
template <class Scenario>
world<Scenario> square_world(threads::link& link, real half) {
  const int cells = link.size() == 1 ? 1 : 2;
  return world<Scenario>(link,
                         {.cells = {cells, cells}, .lower = {-half, -half}, .upper = {half, half}});
}

/// The digest at the end of a run: `make` makes the world of a link, `set_up` fills it, and
/// `after_step` follows each step.
template <class Make, class SetUp, class AfterStep>
std::string digest_of(const course& how, Make make, SetUp set_up, AfterStep after_step) {
  std::string digest;
  threads::launch({.ranks = how.ranks}, [&](threads::link& link) {
    auto w = make(link);
    w.seed(7);
    set_up(w);
    while (w.steps() < static_cast<std::uint64_t>(how.steps)) {
      w.step(how.dt);
      after_step(w);
      if (interval > 0 && w.steps() % static_cast<std::uint64_t>(interval) == 0) {
        const std::string now = state_digest(w);
        if (link.rank() == 0)
          std::printf("  step %llu %s\n", static_cast<unsigned long long>(w.steps()), now.c_str());
      }
    }
    const std::string last = state_digest(w);
    if (link.rank() == 0) digest = last;
  });
  return digest;
}

template <class Make, class SetUp>
std::string digest_of(const course& how, Make make, SetUp set_up) {
  return digest_of(how, make, set_up, [](auto&) {});
}
