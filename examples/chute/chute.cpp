// An endless chute: spheres flow down a bumpy slope in a box that is periodic along the slope and
// across it. At 25 degrees friction balances gravity in a steady flow; at 18 degrees the spheres
// stop.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using chute = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
                       solver<nonlinear_gauss_seidel, reproducible>,
                       decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>,
                       transport<as_launched>, features<checkpoints>>;

struct chute_options : options {
  int layers = 10;
  double angle = 25;  // degrees

  chute_options() { steps = 30000, dt = 0.01; }  // diameters, and the time to fall by half of one
  void describe(auto& line) {
    options::describe(line);
    line.add("--layers", layers, "of spheres above the bumps", 1);
    line.add("--angle", angle, "of the slope, degrees");
  }
};

int main(int argc, char** argv) {
  return run<chute, chute_options>(argc, argv, [](auto& world, const chute_options& options) {
    const double L = 12, W = 6;  // along the slope and across it
    world.decompose({{.lower = {0, 0}, .upper = {L, W}}});
    const double slope = options.angle * pi / 180;
    world.gravity({std::sin(slope), 0, -std::cos(slope)});
    const auto glass = world.material({.density = 6 / pi, .restitution = 0.5, .friction = 0.5});
    world.global([&](auto& scope) { scope.add(plane{}, glass); });

    const box_region floor{{0, 0, 0}, {L, W, 1}};
    world.fill(simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} & floor,
               [&](const site& place, random_stream& random) {
                 const vec3 bump(0, 0, random.uniform(-0.7, 0.));
                 return body{.shape = sphere{0.5},
                             .position = place.position + bump,
                             .material = glass,
                             .fixed = true};
               });
    const box_region above{{0, 0, 1.1}, {L, W, 1.1 + 1.01 * options.layers}};
    world.fill(simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 1.6}} & above,
               [&](const site& place, random_stream& random) {
                 return body{.shape = sphere{random.uniform(0.42, 0.5)},
                             .position = place.position,
                             .material = glass,
                             .velocity = random.uniform(vec3(0, -0.1, -0.1), vec3(0.5, 0.1, 0.1))};
               });
    take_pictures(
        world, options,
        {.from = {0.5 * L, -24, 9}, .at = {0.5 * L, 0.5 * W, 5}, .angle = 38, .walls = 1});

    // Velocities by height, averaged over the last third.
    constexpr std::size_t rows = 24;
    std::array<double, 2 * rows> sums{};  // numbers, velocities
    for (std::size_t k = 0; k < sums.size(); ++k)
      world.keep_sum("profile " + std::to_string(k), sums[k]);
    world.observe(every{20}, [&](auto& w) {
      if (3 * w.steps() < 2 * options.steps) return;
      w.for_each_local([&](const auto& b) {
        const auto row = static_cast<std::size_t>(std::max(b.position()[2] - 1, 0.0));
        if (b.is_fixed() || row >= rows) return;
        sums[row] += 1, sums[rows + row] += b.velocity()[0];
      });
    });
    world.simulate({.steps = options.steps, .dt = options.dt});

    world.link().reduce(reduction::sum, std::span<double>(sums));
    double number = 0, flow = 0;
    for (std::size_t k = 0; k < rows; ++k) number += sums[k], flow += sums[rows + k];
    // The surface is the row with a tenth of the spheres above it.
    double above_it = 0, surface = 0;
    for (std::size_t k = rows; k-- > 0 && above_it < 0.1 * number;)
      above_it += sums[k], surface += sums[rows + k];
    const double mean = flow / std::max(number, 1.0);
    return results{{"mean_velocity", mean},
                   {"surface_over_mean", surface / std::max(above_it, 1.0) / mean}};
  });
}
