// The heap of docs/first_hour.md for many ranks: of any size, on hexagonal domains, with an energy
// ledger and checkpoints.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using hexheap = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
                         solver<nonlinear_gauss_seidel, reproducible>,
                         decomposition<hexagonal<dynamic>>,  // 1, 7, 19, 37, 61, 91 ranks ...
                         transport<as_launched>, features<energy_ledger, checkpoints>>;

struct hexheap_options : options {
  double radius = 12;
  void describe(auto& line) {
    options::describe(line);
    line.add_positive("--radius", radius, "of the cylinder of spheres that falls");
  }
};

int main(int argc, char** argv) {
  return run<hexheap, hexheap_options>(argc, argv, [](auto& world, const hexheap_options& options) {
    world.decompose({.width = 2.5 * options.radius});
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({.density = 2.8, .restitution = 0.3, .friction = 0.5});
    world.global([&](auto& scope) { scope.add(plane{}, stone); });
    world.fill(simple_cubic{.spacing = 1} &
                   vertical_cylinder{.radius = options.radius, .lower = 1, .upper = 9},
               [&](const site& place, random_stream& random) {
                 return body{.shape = sphere{random.uniform(0.3, 0.5)},
                             .position = place.position,
                             .material = stone,
                             .velocity = random.uniform(vec3(-2, -2, 0), vec3(2, 2, 0))};
               });
    const double R = options.radius;
    take_pictures(world, options, {.from = {1.5 * R, -2.5 * R, 1.5 * R}, .at = {0, 0, 1}});
    world.simulate({.steps = options.steps, .dt = options.dt});
  });
}
