// What every solver must do; what "solved" means is measured by the contact residual.
#include <doctest/doctest.h>

#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

constexpr real dt = 1.0 / 240;

/// A heap of spheres and boxes in a box of planes, shared out in columns.
template <class Solver>
struct heap {
  using scenario_type =
      scenario<bodies<sphere, box, plane>, solver<Solver>,
               hard_contact<coulomb_friction, newton_restitution, split_correction>,
               decomposition<grid<dynamic, dynamic>>>;
  static constexpr real side = 5;

  static grid<dynamic, dynamic> cells() { return {.lower = {0, 0}, .upper = {side, side}}; }

  static void set_up(world<scenario_type>& w) {
    const auto stuff = w.material({.restitution = 0.3, .friction = 0.4});
    w.gravity({0, 0, -9.81});
    w.seed(5);
    w.global([&](auto& scope) {
      scope.add(plane{.normal = {0, 0, 1}}, stuff);
      scope.add(plane{.normal = {1, 0, 0}}, stuff);
      scope.add(plane{.normal = {-1, 0, 0}, .offset = -side}, stuff);
      scope.add(plane{.normal = {0, 1, 0}}, stuff);
      scope.add(plane{.normal = {0, -1, 0}, .offset = -side}, stuff);
    });
    w.fill(simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} &
               box_region{{0, 0, 0}, {side, side, 4}},
           [&](const site& at, random_stream& random)
               -> std::variant<body<sphere>, body<box>> {
             const vec3 jitter = random.uniform(vec3(-0.02, -0.02, -0.02), vec3(0.02, 0.02, 0.02));
             if (random.uniform(0, 1) < 0.2)
               return body{.shape = box{{0.7, 0.6, 0.5}}, .position = at.position + jitter};
             return body{.shape = sphere{random.uniform(0.4, 0.48)},
                         .position = at.position + jitter};
           });
  }
};

}  // namespace

TEST_CASE_TEMPLATE("the residual falls with the iterations, and a tolerance is reached", Solver,
                   nonlinear_gauss_seidel) {
  using scene = heap<Solver>;
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<typename scene::scenario_type> w(link, scene::cells());
      scene::set_up(w);
      for (int k = 0; k < 60; ++k) w.step(dt);
      for (const int n : {3, 10, 30, 100, 300, 1000, 3000}) {
        w.solver().iterations = n;
        w.step(dt);
        const auto r = measure_residual(w);
        if (link.rank() == 0) MESSAGE(n, ": ", r.value, " ", r.max, " of ", r.contacts);
      }
      for (const real tolerance : {1e-2, 1e-4, 1e-6, 1e-8}) {
        w.solver().tolerance = tolerance;
        const auto before = w.convergence().iterations;
        w.step(dt);
        const auto told = w.convergence().residual;
        const auto r = measure_residual(w);
        if (link.rank() == 0)
          MESSAGE(tolerance, ": ", r.value, " told ", told, " ", w.convergence().iterations - before);
      }
    });
  }
}
