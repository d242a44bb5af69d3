// Impacts with integrator<moreau_midpoint>: energies, rebounds, rows of spheres, piles, ranks.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <type_traits>
#include <utility>

#include "../../benchmarks/scenes/simbench_protocol.hpp"
#include "../../benchmarks/scenes/talus_engine.hpp"

using namespace talus;

namespace {

template <class Solver, class Transport = transport<serial>, class... More>
using midpoint = scenario<bodies<sphere, box, plane>, solver<Solver>, integrator<moreau_midpoint>,
                          Transport, hard_contact<coulomb_friction, newton_restitution>, More...>;

/// RMS error of energy of `elastic_666`, 34,465 J, over 10 s.
template <class Solver>
double error_of_block(double dt) {
  const bench::scene s = bench::elastic_scene(dt);
  bench::talus_engine_with<bodies<sphere, box, plane>, integrator<moreau_midpoint>, solver<Solver>>
      engine(s);
  bench::stopwatch watch;
  return bench::energy_error(engine, s, static_cast<std::size_t>(10 / dt), watch);
}

template <class Solver>
real lost_by_gas(int side) {
  serial::link link;
  world<midpoint<Solver>> w(link);
  w.material({.restitution = 1, .friction = 0});
  random_stream random(1);
  w.global([&](auto& scope) {
    for (int k = 0; k < 3; ++k) {
      const vec3 n = vec3::Unit(k);
      scope.add(plane{n, -1}, {}), scope.add(plane{-n, -(1.2 * side + 1)}, {});
    }
  });
  for (int i = 0; i < side * side * side; ++i)
    w.add(body{.shape = sphere{0.5},
               .position = 1.2 * vec3(i % side, i / side % side, i / side / side),
               .velocity = random.uniform(vec3(-3, -3, -3), vec3(3, 3, 3))});
  const real before = measure_motion(w).kinetic_energy;
  for (int k = 0; k < 240; ++k) w.step(1.0 / 240);
  return std::abs(measure_motion(w).kinetic_energy / before - 1);
}

}  // namespace

TEST_CASE("the elastic block of SimBenchmark keeps its energy of 34,465 J") {
  CHECK(error_of_block<nonlinear_gauss_seidel>(1e-3) < 0.3);
  CHECK(error_of_block<nonlinear_gauss_seidel>(1e-2) < 30);
  // Ten sweeps by colours leave a part of the first impacts, in which the columns meet at once.
  CHECK(error_of_block<reproducible>(1e-3) < 3);
  CHECK(error_of_block<reproducible>(1e-2) < 30);
}

TEST_CASE("elastic spheres in a box keep their energy to round-off") {
  CHECK(lost_by_gas<nonlinear_gauss_seidel>(10) < 1e-10);
  CHECK(lost_by_gas<reproducible>(10) < 1e-10);
}

TEST_CASE("rows of elastic spheres with and without gaps keep energy and momentum to round-off") {
  random_stream random(7);
  for (int row = 0; row < 100; ++row) {
    CAPTURE(row);
    serial::link link;
    world<midpoint<nonlinear_gauss_seidel>> w(link);
    w.material({.restitution = 1, .friction = 0});
    real x = 0;
    for (int i = 0, n = 2 + static_cast<int>(random.uniform(0.0, 12.0)); i < n; ++i) {
      const real r = random.uniform(0.2, 0.5);
      w.add(body{.shape = sphere{r},
                 .position = {x + r, 0, 0},
                 .velocity = {random.uniform(-3.0, 3.0), 0, 0}});
      x += 2 * r + std::max(0.0, random.uniform(-0.01, 0.02));
    }
    const auto before = measure_motion(w);
    for (int k = 0; k < 400; ++k) w.step(1.0 / 240);
    const auto after = measure_motion(w);
    CHECK(after.kinetic_energy == doctest::Approx(before.kinetic_energy).epsilon(1e-10));
    CHECK((after.momentum - before.momentum).norm() <
          1e-12 * std::sqrt(before.mass * before.kinetic_energy));
  }
}

TEST_CASE("a sphere rebounds to e squared times its height, up to 60 dt squared") {
  for (const real e : {0.2, 0.5, 0.7, 0.9, 1.0})
    for (const real dt : {1.0 / 240, 1.0 / 1000}) {
      CAPTURE(e);
      CAPTURE(dt);
      serial::link link;
      world<midpoint<nonlinear_gauss_seidel>> w(link);
      w.material({.restitution = e});
      w.gravity({0, 0, -9.81});
      w.global([](auto& scope) { scope.add(plane{}, {}); });
      const auto h = w.add(body{.shape = sphere{0.05}, .position = {0, 0, 1.05}});
      real top = 0;
      bool rises = false;
      for (real t = 0; t < 0.46 + 0.44 * e; t += dt) {
        w.step(dt);
        rises = rises || w[h].velocity()[2] > 0;
        if (rises) top = std::max(top, w[h].position()[2] - 0.05);
      }
      CHECK(top == doctest::Approx(e * e).epsilon(60 * dt * dt));
    }
}

TEST_CASE("piles with restitution come to rest with the overlaps of piles without") {
  const auto settle = [](bool boxes, real e) {
    serial::link link;
    world<midpoint<nonlinear_gauss_seidel>> w(link);
    w.material({.restitution = e, .friction = 0.4});
    w.gravity({0, 0, -9.81});
    w.global([](auto& scope) {
      scope.add(plane{}, {}), scope.add(plane{{1, 0, 0}, 0}, {}),
          scope.add(plane{{0, 1, 0}, 0}, {});
      scope.add(plane{{-1, 0, 0}, -4}, {}), scope.add(plane{{0, -1, 0}, -4}, {});
    });
    random_stream random(3);
    for (int i = 0; i < 54; ++i) {
      const vec3 at = vec3(0.7, 0.7, 0.6) + 1.15 * vec3(i % 3, i / 3 % 3, i / 9) +
                      random.uniform(vec3(-0.1, -0.1, 0), vec3(0.1, 0.1, 0));
      if (boxes)
        w.add(body{.shape = box{{0.8, 0.7, 0.6}}, .position = at});
      else
        w.add(body{.shape = sphere{random.uniform(0.43, 0.47)}, .position = at});
    }
    for (int k = 0; k < 2000; ++k) w.step(1.0 / 240);
    return measure_penetration(w).mean;
  };
  for (const bool boxes : {false, true})
    for (const real e : {0.0, 0.3, 0.8}) {
      CAPTURE(boxes);
      CAPTURE(e);
      CHECK(settle(boxes, e) < 1e-5);
    }
}

TEST_CASE("elastic spheres over ranks keep their energy, with the same bits by colours") {
  const auto fall = [](auto solver_type, int ranks) {
    using team = midpoint<typename decltype(solver_type)::type, transport<threads>,
                          decomposition<grid<dynamic, dynamic>>>;
    std::string digest;
    real change = 0;
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<team> w(link);
      w.decompose({.lower = {0, 0}, .upper = {4, 4}});
      w.material({.restitution = 1, .friction = 0});
      w.gravity({0, 0, -9.81});
      w.global([](auto& scope) {
        scope.add(plane{}, {}), scope.add(plane{{1, 0, 0}, 0}, {}),
            scope.add(plane{{0, 1, 0}, 0}, {});
        scope.add(plane{{-1, 0, 0}, -4}, {}), scope.add(plane{{0, -1, 0}, -4}, {});
      });
      random_stream random(11);
      for (int i = 0; i < 180; ++i) {
        const vec3 at = vec3(0.5, 0.5, 0.7) + 0.6 * vec3(i % 6, i / 6 % 6, i / 36);
        const vec3 v = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
        w.add_if_local(body{.shape = sphere{0.25}, .position = at, .velocity = v});
      }
      w.synchronize();
      const auto energy = [&] {
        const auto m = measure_motion(w);
        return m.kinetic_energy + m.potential_energy;
      };
      const real before = energy();
      for (int k = 0; k < 720; ++k) w.step(1.0 / 240);
      const real after = energy();
      const auto bits = state_digest(w);
      if (w.rank() == 0) digest = bits, change = after / before - 1;
    });
    return std::pair(digest, change);
  };
  const auto alone = fall(std::type_identity<reproducible>{}, 1);
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    const auto same = fall(std::type_identity<reproducible>{}, ranks);
    CHECK(same.first == alone.first);
    CHECK(std::abs(same.second) < 1e-3);
    CHECK(std::abs(fall(std::type_identity<nonlinear_gauss_seidel>{}, ranks).second) < 4e-3);
  }
}
