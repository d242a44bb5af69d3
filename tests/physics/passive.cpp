// timeout: 300
// Contacts never add energy, in any step, however incomplete the solution of the solver.
#include <doctest/doctest.h>

#include <algorithm>
#include <talus/observe/energy.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/accelerated_jacobi.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/substepping.hpp>
#include <talus/world/world.hpp>
#include <type_traits>
#include <vector>

using namespace talus;

namespace {

using cuts = grid<dynamic, dynamic, dynamic>;
template <class Solver, class Number = double, class... Features>
using scene = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
                       solver<Solver>, precision<Number>, features<energy_ledger, Features...>,
                       transport<threads>, decomposition<grid<dynamic, dynamic, dynamic>>>;

struct outcome {
  /// Largest of a step, over the sum of its energies: by the work of contacts, or by the change of
  /// kinetic and potential energy, whichever is less. (Bodies that gravity brings together in a
  /// step take work, and lose more energy than that; a bounce may end above its contact, without
  /// work.)
  double gain = 0;
  double initial = 0;         ///< kinetic energy
  double highest = 0;         ///< kinetic energy over the initial one, at any time
  double last = 0;            ///< kinetic energy over the initial one, at the end
  std::vector<double> speed;  ///< along x, on one rank
};

/// `set_up(world, material)`; the energy that contacts add is measured after each step.
template <class Scene, class SetUp>
outcome run(int ranks, int iterations, double restitution, double gravity, int steps,
            SetUp&& set_up) {
  outcome result;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scene> w(link, cuts{.cells = {ranks, 1, 1}, .lower = {-5, -5, -5}, .upper = {5, 5, 5}});
    w.solver().iterations = iterations;
    w.gravity({0, 0, -gravity});
    set_up(w, w.material({.density = 1, .restitution = restitution, .friction = 0.3}));
    w.synchronize();
    const double initial = measure_motion(w).kinetic_energy;
    outcome mine;
    mine.initial = initial;
    for (int k = 0; k < steps; ++k) {
      w.step(0.005);
      const energy_balance e = measure_energy(w);
      const double work = -(e.step.friction + e.step.impact);
      mine.gain = std::max(mine.gain, std::min(work, e.step.net() - e.step.correction) / e.scale);
      mine.highest = std::max(mine.highest, e.kinetic / initial);
      mine.last = e.kinetic / initial;
    }
    if (ranks == 1) w.for_each_local([&](auto& b) { mine.speed.push_back(b.velocity()[0]); });
    if (link.rank() == 0) result = mine;
  });
  return result;
}

/// `count` touching spheres in a row; the first comes with speed 1.
template <class Scene>
outcome row(int count, int ranks, int iterations, double restitution) {
  return run<Scene>(ranks, iterations, restitution, 0, 8, [&](auto& w, auto stone) {
    for (int i = 0; i < count; ++i)
      w.add_if_local(body{.shape = sphere{0.5},
                          .position = {i - 0.5 * (count - 1), 0, 0},
                          .material = stone,
                          .velocity = {i == 0 ? 1.0 : 0.0, 0, 0}});
  });
}

/// 5 x 5 x 5 touching spheres on a floor, hit by a large one.
template <class Scene>
outcome lattice(int ranks, int iterations, double restitution, double gravity) {
  return run<Scene>(ranks, iterations, restitution, gravity, 40, [&](auto& w, auto stone) {
    w.global([&](auto& scope) { scope.add(plane{.offset = -2.5}, stone); });
    for (int i = 0; i < 125; ++i)
      w.add_if_local(body{.shape = sphere{0.5},
                          .position = {i % 5 - 2.0, i / 5 % 5 - 2.0, i / 25 - 2.0},
                          .material = stone});
    w.add_if_local(body{.shape = sphere{1.5},
                        .position = {-4.05, 0.1, 0.2},
                        .material = stone,
                        .velocity = {6, 0.5, -1}});
  });
}

template <class Scene>
void check_all(int ranks, double round_off) {
  for (const int iterations : {1, 2, 10, 50})
    for (const double restitution : {0.0, 0.5, 1.0}) {
      CAPTURE(ranks);
      CAPTURE(iterations);
      CAPTURE(restitution);
      for (const int count : {3, 5, 20}) {
        const outcome r = row<Scene>(count, ranks, iterations, restitution);
        CAPTURE(count);
        CHECK(r.gain < round_off);
        CHECK(r.highest < 1 + round_off);
      }
      if (iterations > 10) continue;
      for (const double gravity : {0.0, 10.0}) {
        // The reproducible solver does not sum over ranks with gravity.
        if (gravity > 0 && std::is_same_v<typename Scene::solver, reproducible>) continue;
        const outcome r = lattice<Scene>(ranks, iterations, restitution, gravity);
        CAPTURE(gravity);
        // Each of several islands may satisfy another one of the two.
        CHECK(r.gain < (gravity > 0 ? std::max(round_off, 1e-5) : round_off));
        if (gravity == 0) CHECK(r.highest < 1 + round_off);
      }
    }
}

}  // namespace

TEST_CASE_TEMPLATE("contacts add no energy in any step, at any number of iterations", Solver,
                   nonlinear_gauss_seidel, coloured_gauss_seidel, accelerated_jacobi, substepping) {
  check_all<scene<Solver>>(1, 1e-13);
}

TEST_CASE("contacts add no energy in any step where they are solved in float") {
  check_all<scene<nonlinear_gauss_seidel, mixed_precision>>(1, 1e-6);
}

TEST_CASE("contacts add no energy in any step on three ranks, with the reproducible solver") {
  check_all<scene<reproducible>>(3, 1e-13);
}

TEST_CASE(
    "contacts add no energy with the reproducible solver where bodies may be driven, but none is") {
  check_all<scene<reproducible, double, driven>>(3, 1e-13);
}

TEST_CASE("a touching row keeps the velocities that an impact has left it with") {
  for (const int count : {5, 20}) {
    const outcome r = row<scene<nonlinear_gauss_seidel>>(count, 1, 10, 1);
    CHECK(r.last == doctest::Approx(1).epsilon(1e-9));
    CHECK(r.speed[0] == doctest::Approx((2.0 - count) / count).epsilon(1e-6));
    for (int i = 1; i < count; ++i)
      CHECK(r.speed[static_cast<std::size_t>(i)] == doctest::Approx(2.0 / count).epsilon(1e-6));
  }
}

// Without a further message, ranks cannot make the sum exact: the rest is bounded.
TEST_CASE("across ranks the default solver adds little energy where a long row is hit") {
  for (const int iterations : {2, 10, 50})
    for (const double restitution : {0.0, 0.5, 1.0}) {
      const outcome r = row<scene<nonlinear_gauss_seidel>>(20, 3, iterations, restitution);
      CAPTURE(iterations);
      CAPTURE(restitution);
      CHECK(r.gain < 0.03);
      CHECK(r.highest <= 1 + 1e-12);
    }
}
