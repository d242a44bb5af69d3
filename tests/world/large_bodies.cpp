// Bodies larger than a domain: gaps in the coverage by connections are reported, nothing is lost.
#include <doctest/doctest.h>

#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>

#include "../scenes/spheres.hpp"

using namespace talus;
using row = scenes::spheres;

namespace {

/// Runs `f(world)` on five slabs of width 1 along x, from 0 to 5; the outer ones have no end.
template <class F>
void on_slabs(F&& f) {
  threads::launch({.ranks = 5}, [&](threads::link& link) {
    world<row> w(link, grid<5>{.lower = {0}, .upper = {5}});
    w.material({});
    f(w);
  });
}
void connect_to(world<row>& w, int rank, real x, real side) {
  w.connect(rank, vec3(side, 0, 0), side * x);
}

}  // namespace

TEST_CASE(
    "a body that reaches a rank without connection is refused at once, with the pair and the "
    "reach") {
  const auto add = [](world<row>& w) {
    w.add_if_local(body{.shape = sphere{1.7}, .position = {2.4, 0, 0}});
  };
  CHECK_THROWS_WITH_AS(
      on_slabs(add),
      doctest::Contains("owned by rank 2, reaches 1.7 far, into the domain of rank 0"),
      std::runtime_error);
  CHECK_THROWS_WITH_AS(on_slabs(add), doctest::Contains("ranks 2 and 0 are not connected"),
                       std::runtime_error);
  CHECK_THROWS_WITH_AS(on_slabs(add), doctest::Contains("are 1 apart"), std::runtime_error);
}

TEST_CASE("a body that covers only connected ranks is welcome") {
  on_slabs([](world<row>& w) {
    w.add_if_local(body{.shape = sphere{1.3}, .position = {2.5, 0, 0}});
    w.step(0.01);
  });
}

TEST_CASE("a body that comes to reach a rank without connection stops the run") {
  CHECK_THROWS_WITH_AS(
      on_slabs([](world<row>& w) {
        w.add_if_local(body{.shape = sphere{1.45}, .position = {2.5, 0, 0}, .velocity = {1, 0, 0}});
        for (int k = 0; k < 20; ++k) w.step(0.01);
      }),
      doctest::Contains("into the domain of rank 4"), std::runtime_error);
}

TEST_CASE("two bodies that meet in a third rank's domain need a connection of their owners") {
  const auto meet = [](bool connected) {
    on_slabs([&](world<row>& w) {
      if (connected) {
        if (w.rank() == 1) connect_to(w, 3, 3, 1), connect_to(w, 4, 4, 1);
        if (w.rank() == 3) connect_to(w, 1, 2, -1);
        if (w.rank() == 4) connect_to(w, 1, 2, -1);
      }
      w.synchronize();
      w.add_if_local(body{.shape = sphere{0.9}, .position = {1.5, 0, 0}, .velocity = {1, 0, 0}});
      w.add_if_local(body{.shape = sphere{0.9}, .position = {3.5, 0, 0}, .velocity = {-1, 0, 0}});
      for (int k = 0; k < 30; ++k) w.step(0.01);
      w.for_each_local([](auto& b) { CHECK(std::abs(b.velocity()[0]) < 0.01); });
    });
  };
  CHECK_THROWS_WITH_AS(meet(false), doctest::Contains("ranks are not connected"),
                       std::runtime_error);
  meet(true);
}
