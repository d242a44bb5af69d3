// A heavy sphere falls into a bed of spheres. Its depth is compared with the law of J. S. Uehara,
// M. A. Ambroso, R. P. Ojha, D. J. Durian, Low-speed impact craters in loose granular media, Phys.
// Rev. Lett. 90, 194301 (2003).
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using impact =
    scenario<bodies<sphere, plane>, hard_contact<coulomb_friction>,
             solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic, dynamic>>,
             transport<as_launched>, features<checkpoints>>;

struct impact_options : options {
  int spheres = 6000;
  double fall = 20, density = 2, settle = 3;

  impact_options() { steps = 1000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--spheres", spheres, "of the bed", 100);
    line.add("--fall", fall, "way of the sphere to the bed, in diameters of grains", 1.0, 1000.0);
    line.add_positive("--settle", settle, "time until it falls");
    line.add("--density", density, "of the sphere, over that of the grains", 0.1, 20.0);
  }
};

int main(int argc, char** argv) {
  return run<impact, impact_options>(argc, argv, [](auto& world, const impact_options& options) {
    const double W = 22, D = 5, gravity = 9.81;  // bed, sphere, in diameters of grains

    world.decompose({.lower = {-W / 2, -W / 2}, .upper = {W / 2, W / 2}});
    world.gravity({0, 0, -gravity});
    const auto glass = world.material({.density = 1, .friction = 0.5});
    const auto heavy = world.material({.density = options.density, .friction = 0.5});
    world.global([&](auto& scope) {
      scope.add(plane{}, glass);
      for (const int side : {-1, 1}) {
        scope.add(plane{.normal = {-1.0 * side, 0, 0}, .offset = -W / 2}, glass);
        scope.add(plane{.normal = {0, -1.0 * side, 0}, .offset = -W / 2}, glass);
      }
    });
    const double space = 1.12, first = 0.57 - W / 2;
    const auto sites = simple_cubic{.spacing = space, .origin = {first, first, 0.57}} &
                       box_region{{first, first, 0}, {-first, -first, 1000}};
    world.fill(sites.first(options.spheres), [&](const site& place, random_stream& random) {
      return body{.shape = sphere{0.5 * random.uniform(0.9, 1.1)},
                  .position = place.position,
                  .material = glass,
                  .velocity = random.uniform(vec3(-0.5, -0.5, -0.5), vec3(0.5, 0.5, 0.5))};
    });

    const auto simulate_until = [&](double time) {
      const auto last = std::min<std::uint64_t>(std::llround(time / options.dt), options.steps);
      if (last > world.steps()) world.simulate({.steps = last - world.steps(), .dt = options.dt});
    };
    // Mass of the grains, and the height of their surface: twice that of their centre of mass.
    const auto survey = [&] {
      std::array<double, 2> sums{};
      world.for_each_local(
          [&](const auto& b) { sums[0] += b.mass(), sums[1] += b.mass() * b.position()[2]; });
      world.link().reduce(reduction::sum, sums);
      return std::array{sums[0], 2 * sums[1] / sums[0]};
    };
    simulate_until(options.settle);
    const std::array<double, 2> bed = world.once("bed", survey);
    // Starts at a rounded height, because sums over ranks differ in their last bit.
    world.add_if_local(body{.shape = sphere{D / 2},
                            .position = {0, 0, std::ceil(bed[1]) + 0.5 + D / 2},
                            .material = heavy,
                            .velocity = {0, 0, -std::sqrt(2 * gravity * (options.fall - 1))}});
    world.synchronize();
    take_pictures(world, options,
                  {.from = {0, -36, 33}, .at = {0, 0, 9}, .angle = 42, .ground = false});
    simulate_until(options.steps * options.dt);

    const double top = bed[1];
    double depth = -top;  // of its lowest point
    world.for_each_local([&](const auto& b) {
      if (b.shape().radius > 1) depth = top - (b.position()[2] - D / 2);
    });
    world.link().reduce(reduction::max, std::span(&depth, 1));
    // The law needs the total height of fall, the bulk density of the bed, and its angle of
    // repose.
    const double bulk = bed[0] / (W * W * top), repose = 0.4;
    const double law =
        0.14 / repose * std::sqrt(options.density / bulk) * std::pow(D, 2.0 / 3) *
        std::cbrt(options.fall - 1 + std::ceil(top) + 0.5 - top + std::max(depth, 0.0));
    return results{{"depth", depth},
                   {"depth_uehara", law},
                   {"depth_to_law", depth / law},
                   {"depth_of_bed", top},
                   {"bulk_density", bulk}};
  });
}
