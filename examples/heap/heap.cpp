// A block of spheres falls onto a floor and spreads into a heap.
#include <talus/mpi.hpp>
using namespace talus;

using scene = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
                       solver<nonlinear_gauss_seidel, reproducible>,  // the second: --reproducible
                       decomposition<grid<dynamic, dynamic>>,         // as many ranks as there are
                       transport<as_launched>>;  // serial, --ranks N, or mpirun

int main(int argc, char** argv) {
  return run<scene>(argc, argv, [](auto& world, const auto& options) {
    world.decompose({.lower = {-5, -5}, .upper = {5, 5}});
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({.density = 2.8, .restitution = 0.3, .friction = 0.5});
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
  });
}
