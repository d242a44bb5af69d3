// The Brazil nut: a box of grains is shaken, and the large one at its bottom rises to the top
// (Rosato, Strandburg, Prinz, Swendsen 1987).
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using shaker =
    scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic, dynamic>>,
             transport<as_launched>, features<driven, checkpoints>>;

struct shaker_options : options {
  int grains = 500;
  double frequency = 2, amplitude = 0.35;
  material grain{.density = 1, .restitution = 0.3, .friction = 0.4};
  uniform_size radius{0.4, 0.5};

  shaker_options() { steps = 20000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--grains", grains, "number of small grains", 1);
    line.add("--grain", grain, "all bodies");         // --grain.friction and so on
    line.add("--radius", radius, "of small grains");  // --radius.lower, --radius.upper
    line.add_positive("--frequency", frequency, "cycles per unit of time");
    line.add("--amplitude", amplitude, "half the stroke");
  }
};

const vec3 bottom{3.5, 3.5, 1.2};  // where the large grain begins

struct beside_the_large_grain {
  static bool contains(const vec3& p) { return (p - bottom).norm() > 1.75; }
};

int main(int argc, char** argv) {
  return run<shaker, shaker_options>(argc, argv, [](auto& world, const shaker_options& options) {
    const double W = 7, rest = 3;  // width of the box, time to settle
    world.decompose({.lower = {0, 0}, .upper = {W, W}});
    world.gravity({0, 0, -9.81});
    const auto grain = world.material(options.grain);

    const auto shake = [=](double t) {
      return oscillation{.amplitude = {0, 0, options.amplitude},
                         .frequency = options.frequency}(std::max(t - rest, 0.0));
    };
    world.global([&](auto& scope) {
      const plane sides[] = {
          {{0, 0, 1}, 0}, {{1, 0, 0}, 0}, {{-1, 0, 0}, -W}, {{0, 1, 0}, 0}, {{0, -1, 0}, -W}};
      for (const plane& side : sides) world.drive(scope.add(side, grain), shake);
    });
    world.add_if_local(body{.shape = sphere{1.2}, .position = bottom, .material = grain});
    const auto sites = simple_cubic{.spacing = 1.02, .origin = {0.55, 0.55, 0.55}} &
                       box_region{{0.5, 0.5, 0.5}, {W - 0.5, W - 0.5, 99}} &
                       beside_the_large_grain{};
    world.fill(sites.first(options.grains), [&](const site& place, random_stream& random) {
      return body{
          .shape = sphere{options.radius(random)}, .position = place.position, .material = grain};
    });
    take_pictures(world, options, {.from = {0.5 * W, -14, 24}, .at = {0.5 * W, 2, 5}, .angle = 36});

    world.simulate({.steps = options.steps, .dt = options.dt});

    std::array<double, 2> sums{0, 0};  // heights above the floor: of the large grain, of the others
    const double floor = shake(world.time()).shift[2];
    world.for_each_local(
        [&](const auto& b) { sums[b.shape().radius < 1] += b.position()[2] - floor; });
    world.link().reduce(reduction::sum, sums);
    return results{{"height_gained", sums[0] - bottom[2]},
                   {"mean_height_of_grains", sums[1] / options.grains}};
  });
}
