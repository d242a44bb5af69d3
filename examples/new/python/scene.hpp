#pragma once
// The scene of @NAME@: its scenario, and how a world of it is set up. The program (main.cpp) and
// the module of Python (module.cpp) share it.
#include <talus/mpi.hpp>
using namespace talus;

using scene =
    scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<nonlinear_gauss_seidel, reproducible>,  // the second: --reproducible
             decomposition<grid<dynamic, dynamic>>,         // as many ranks as there are
             transport<as_launched>>;  // serial, --ranks N, or mpirun; Python has one rank

// An option of this scene, beside those of every program: --friction, and World(friction=...).
struct scene_options : options {
  double friction = 0.5;
  void describe(auto& cli) {
    options::describe(cli);
    cli.add("--friction", friction, "of the spheres, on each other and on the floor", 0.0, 10.0);
  }
};

inline constexpr auto set_up = [](auto& world, const auto& options) {
  world.decompose({.lower = {-5, -5}, .upper = {5, 5}});
  world.gravity({0, 0, -9.81});
  const auto stone =
      world.material({.density = 2.8, .restitution = 0.3, .friction = options.friction});
  world.global([&](auto& scope) { scope.add(plane{}, stone); });
  world.fill(simple_cubic{.spacing = 1} & box_region{{-4, -4, 1}, {4, 4, 9}},
             [&](const site& place, random_stream& random) {
               return body{.shape = sphere{random.uniform(0.3, 0.5)},
                           .position = place.position,
                           .material = stone,
                           .velocity = random.uniform(vec3(-2, -2, 0), vec3(2, 2, 0))};
             });
  take_pictures(world, options, {.from = {16, -24, 12}, .at = {0, 0, 1}});
  world.simulate({.steps = options.steps, .dt = options.dt});
};
