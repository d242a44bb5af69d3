// A column of moist beads collapses: a law of one's own, the liquid bridges of liquid_bridge.hpp,
// beside the springs and the friction of the library. Beads hang from a ceiling as long as the
// bridge bears their weight. With --volume 0 the beads are dry.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>

#include "liquid_bridge.hpp"
using namespace talus;

using moist = scenario<
    bodies<sphere, plane>,
    soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance, liquid_bridge>,
    decomposition<grid<dynamic, dynamic>>, transport<as_launched>,
    features<energy_ledger, checkpoints>>;

struct moist_options : options {
  double volume = 0.02;

  moist_options() { steps = 8000, dt = 1e-5; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--volume", volume, "volume of liquid in a bridge, in cubic millimetres", 0.0, 0.1);
  }
};

int main(int argc, char** argv) {
  return run<moist, moist_options>(argc, argv, [](auto& world, const moist_options& options) {
    // Millimetres, seconds, kilograms: forces in millinewtons.
    const double tension = 0.072, density = 2.5e-6, gravity = 9810, ceiling = 12;
    world.decompose({.lower = {-14, -14}, .upper = {14, 14}});
    world.gravity({0, 0, -gravity});
    const material glass{.density = density,
                         .restitution = 0.5,
                         .friction = 0.4,
                         .stiffness = 50,
                         .rolling_friction = 0.02};
    const auto bead = world.material(glass), plate = world.material(glass);
    // What the law needs of each pair of materials. The ceiling is nearly clean of liquid.
    const liquid_bridge::parameters wet{.tension = tension, .angle = 0, .volume = options.volume};
    const double heaviest = 0.5;  // the radius of a bead that the ceiling just bears
    const double weak = heaviest * heaviest * density * gravity / 3;
    world.interaction(bead, bead, wet);
    liquid_bridge::parameters clean = wet;
    clean.tension = weak;
    world.interaction(bead, plate, clean);

    world.global([&](auto& scope) {
      scope.add(plane{}, bead);
      scope.add(plane{.normal = {0, 0, -1}, .offset = -ceiling}, plate);
    });
    world.fill(simple_cubic{.spacing = 0.95} & box_region{{-2.5, -2.5, 0.4}, {2.5, 2.5, 8}},
               [&](const site& place, random_stream& random) {
                 return body{.shape = sphere{random.uniform(0.42, 0.48)},
                             .position = place.position,
                             .material = bead};
               });
    for (int k = 0; k < 10; ++k) {
      const double radius = 0.41 + 0.02 * k;
      const auto at = vec3(-10 + 2 * k, 10, ceiling - radius + 1e-4);
      world.add_if_local(body{.shape = sphere{radius}, .position = at, .material = bead});
    }
    take_pictures(world, options, {.from = {18, -26, 14}, .at = {0, 0, 3}});
    world.simulate({.steps = options.steps, .dt = options.dt});

    // How many hang, the mean height of the column, and how well the books of energy close.
    std::array<double, 3> sums{};
    world.for_each_local([&](const auto& b) {
      const bool above = b.position()[2] > ceiling - 1;
      sums[0] += above;
      if (b.position()[1] < 8) sums[1] += b.position()[2], sums[2] += 1;
    });
    world.link().reduce(reduction::sum, std::span<double>(sums));
    const auto energy = measure_energy(world);
    return results{
        {"hanging", sums[0]}, {"mean_height", sums[1] / sums[2]}, {"energy_closure", energy.worst}};
  });
}
