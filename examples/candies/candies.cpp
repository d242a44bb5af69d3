// Candies: 5,000 smooth ellipsoids of one form rain into a box that is periodic along x and y, and
// settle. The fraction of the volume that they fill depends on their aspect ratio: it is largest
// where they are about half as long again as thick (Donev and others 2004, Science 303, 990).
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using candies = scenario<bodies<ellipsoid, plane>, hard_contact<coulomb_friction>,
                         solver<nonlinear_gauss_seidel, reproducible>,
                         decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>,
                         transport<as_launched>, features<checkpoints>>;

struct candies_options : options {
  double aspect = 1.5, friction = 0;
  std::uint64_t candies = 5000;

  candies_options() { steps = 2400, dt = 1.0 / 240; }
  void describe(auto& line) {
    options::describe(line);
    line.add_positive("--aspect", aspect,
                      "longest over other axes; below 1: the axes over the shortest");
    line.add("--friction", friction, "coefficient of friction", 0.0, 10.0);
    line.add("--candies", candies, "about how many, in full layers");
  }
};

int main(int argc, char** argv) {
  return run<candies, candies_options>(argc, argv, [](auto& world, const candies_options& options) {
    // All have the volume of a ball of diameter 1, and heaps are about twice as high as wide.
    const double volume = pi / 6, across = 0.5 / std::cbrt(options.aspect);
    const ellipsoid form{{across, across, options.aspect * across}};
    const double width = std::cbrt(static_cast<double>(options.candies) * volume / 1.3);
    const double longest = 2.02 * form.bounding_radius();
    const double in_row = std::max(1.0, std::floor(width / longest)), spacing = width / in_row;
    const double layers = std::ceil(static_cast<double>(options.candies) / (in_row * in_row));

    world.decompose({{.lower = {0, 0}, .upper = {width, width}}});
    world.gravity({0, 0, -9.81});
    const auto sugar = world.material({.density = 1, .friction = options.friction});
    world.global([&](auto& scope) { scope.add(plane{}, sugar); });
    const vec3 half(0.5 * spacing, 0.5 * spacing, 0.5 * spacing);
    world.fill(simple_cubic{.spacing = spacing, .origin = half} &
                   box_region{{0, 0, 0}, {width, width, layers * spacing}},
               [&](const site& place, random_stream& random) {
                 return body{.shape = form,
                             .position = place.position,
                             .material = sugar,
                             .orientation = random.rotation()};
               });
    take_pictures(
        world, options,
        {.from = {0.5 * width, -3 * width, 2 * width}, .at = {0.5 * width, 0.5 * width, width}});
    world.simulate({.steps = options.steps, .dt = options.dt});

    // The filled part of a slab away from the floor and the top. Bodies that reach into it count
    // by the part of a ball of their volume.
    const auto sum_of = [&](auto&& part) {
      double sums[2] = {0, 0};
      world.for_each_local([&](const auto& b) { sums[0] += part(b), sums[1] += 1; });
      world.link().reduce(reduction::sum, std::span<double>(sums));
      return sums[0] / sums[1];
    };
    const double top = 2 * sum_of([](const auto& b) { return b.position()[2]; });
    const double from = std::min(4.0, 0.25 * top), to = 0.75 * top;
    const auto below = [&](const auto& b, double z) {
      const double t = std::clamp((z - b.position()[2]) / 0.5, -1.0, 1.0);
      return (2 + 3 * t - t * t * t) / 4;
    };
    const double inside = sum_of([&](const auto& b) { return below(b, to) - below(b, from); });
    const double fraction =
        inside * layers * in_row * in_row * volume / ((to - from) * width * width);
    return results{{"fraction", fraction},
                   {"height", top},
                   {"speed", sum_of([](const auto& b) { return b.velocity().norm(); })}};
  });
}
