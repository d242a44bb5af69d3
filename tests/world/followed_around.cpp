// timeout: 300
// Periodic space with sleeping islands and continuous collision: a body that strikes across a side
// wakes the island, nothing passes through anything, and momentum is conserved.
#include <doctest/doctest.h>

#include <mutex>
#include <set>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/reach.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

template <class Solver>
using around = scenario<bodies<sphere, plane>, solver<Solver>, transport<threads>,
                        decomposition<periodic<grid<dynamic>, along::x, along::y>>,
                        features<sleeping, continuous_collision>>;
constexpr real dt = 0.005;

/// Runs `main(world)` on x by y ranks that share a box of 40 x 24.
template <class Scenario, class Main>
void on(int x, int y, Main&& main) {
  CAPTURE(x);
  CAPTURE(y);
  threads::launch({.ranks = x * y}, [&](threads::link& link) {
    world<Scenario> w(link, {{.cells = {x, y, 1}, .lower = {-20, -12}, .upper = {20, 12}}},
                      reach{6});
    w.material({.restitution = 0, .friction = 0.5});
    w.sleeping({.speed = 0.05, .time = 0.1});
    main(w);
  });
}

/// A row of spheres over the side at x = 20, sleeping, that a bullet strikes from behind.
template <class World>
void row(World& w) {
  for (int k = 0; k < 8; ++k) {
    const real x = 16.5 + k;
    w.add_if_local(body{.shape = sphere{0.5}, .position = {x < 20 ? x : x - 40, 0, 0}});
  }
}
template <class World>
void strike(World& w, real speed) {
  w.add_if_local(body{.shape = sphere{0.5}, .position = {12, 0.1, 0}, .velocity = {speed, 0, 0}});
}
const std::vector<std::pair<int, int>> shares{{1, 1}, {2, 1}, {1, 2}, {2, 2}, {4, 1}};

template <class Solver>
void check_row(real speed) {
  CAPTURE(speed);
  for (const auto& [x, y] : shares)
    on<around<Solver>>(x, y, [&](auto& w) {
      row(w);
      for (int k = 0; k < 40; ++k) w.step(dt);
      REQUIRE(measure_motion(w).asleep == 8);
      strike(w, speed);
      const vec3 first = measure_motion(w).momentum;
      for (int k = 0; k < 60; ++k) {
        w.step(dt);
        const motion m = measure_motion(w);
        CHECK((m.momentum - first).norm() < 1e-9 * first.norm());
      }
      // All are awake and move on together; the bullet is still behind them.
      CHECK(measure_motion(w).asleep == 0);
      double slowest = 1e9;
      w.for_each_local(
          [&](const auto& b) { slowest = std::min(slowest, double(b.velocity()[0])); });
      w.link().reduce(reduction::min, std::span(&slowest, 1));
      CHECK(slowest > 0);
    });
}

}  // namespace

TEST_CASE("a bullet wakes a row that lies across a side, and its momentum stays") {
  for (const real speed : {20.0, 100.0, 250.0}) check_row<reproducible>(speed);
}

TEST_CASE("likewise with the default solver, which solves islands across ranks") {
  for (const real speed : {20.0, 100.0, 250.0}) check_row<nonlinear_gauss_seidel>(speed);
}

TEST_CASE("a gas of bullets around a box, above sleepers, has the same bits on any ranks") {
  std::set<std::string> digests;
  std::mutex mutex;
  for (const auto& [x, y] : shares)
    on<around<reproducible>>(x, y, [&](auto& w) {
      w.gravity({0, 0, -10});
      w.global([&](auto& s) { s.add(plane{.normal = {0, 0, 1}, .offset = -0.5}, {}); });
      for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 6; ++j)
          w.add_if_local(
              body{.shape = sphere{0.5}, .position = {2.0 * i - 19.9, 4.0 * j - 11.9, 0}});
      for (int k = 0; k < 60; ++k) w.step(dt);
      CHECK(measure_motion(w).asleep == 120);
      random_stream random(3);
      for (int i = 0; i < 30; ++i) {
        const vec3 at = random.uniform(vec3(-19, -11, 2), vec3(19, 11, 4));
        const vec3 v = random.uniform(vec3(-150, -150, -150), vec3(150, 150, 0));
        w.add_if_local(body{.shape = sphere{0.2}, .position = at, .velocity = v});
      }
      for (int k = 0; k < 40; ++k) w.step(dt);
      double below = 0;
      w.for_each_local([&](const auto& b) { below += b.position()[2] < -0.5; });
      CHECK(below == 0);
      const std::string digest = state_digest(w);
      const std::lock_guard lock(mutex);
      digests.insert(digest);
    });
  CHECK(digests.size() == 1);
}
