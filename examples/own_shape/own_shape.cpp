// Lenses fall into a bowl of walls, beside spheres, boxes and dumb-bells of two lenses with a
// sphere between them. The lens is a shape of one's own, which is all in lens.hpp.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/vtk.hpp>

#include "lens.hpp"
using namespace talus;

using scene = scenario<bodies<lens, sphere, box, union_of<lens, sphere>, plane>,
                       hard_contact<coulomb_friction>, solver<nonlinear_gauss_seidel, reproducible>,
                       decomposition<grid<dynamic, dynamic>>, transport<as_launched>,
                       features<checkpoints, vtk_output>>;

struct lens_options : options {
  lens_options() { steps = 1200, dt = 1.0 / 500; }
};

int main(int argc, char** argv) {
  return run<scene, lens_options>(argc, argv, [](auto& world, const lens_options& options) {
    world.decompose({.lower = {-3, -3}, .upper = {3, 3}});
    world.gravity({0, 0, -9.81});
    const auto glass = world.material({.density = 2500, .restitution = 0.1, .friction = 0.3});
    world.global([&](auto& scope) {
      scope.add(plane{}, glass);
      for (const double side : {-1.0, 1.0}) {
        scope.add(plane{.normal = {-side, 0, 0}, .offset = -2.5}, glass);
        scope.add(plane{.normal = {0, -side, 0}, .offset = -2.5}, glass);
      }
      scope.add(body{.shape = lens{.radius = 1, .thickness = 0.8},
                     .position = {0, 0, 0.3},
                     .material = glass});
    });
    const lens whole{.radius = 0.25, .thickness = 0.25};
    const union_of<lens, sphere> pair(
        {{.shape = whole, .at = {{-0.2, 0, 0}, rotation({0, 1, 0}, pi / 2)}},
         {.shape = whole, .at = {{0.2, 0, 0}, rotation({0, 1, 0}, pi / 2)}},
         {.shape = sphere{.radius = 0.15}, .at = {{0, 0, 0}, {1, 0, 0, 0}}}});
    using any = std::variant<body<lens>, body<sphere>, body<box>, body<union_of<lens, sphere>>>;
    world.fill(
        simple_cubic{.spacing = 0.62} & box_region{{-2, -2, 1}, {2, 2, 5}},
        [&](const site& place, random_stream& random) -> any {
          const quat turn = random.rotation();
          const double kind = random.uniform(0, 10);
          if (kind < 1)
            return body{
                .shape = sphere{.radius = 0.2}, .position = place.position, .material = glass};
          if (kind < 2)
            return body{.shape = box{{0.3, 0.3, 0.3}},
                        .position = place.position,
                        .material = glass,
                        .orientation = turn};
          if (kind < 3)
            return body<union_of<lens, sphere>>{
                .shape = pair, .position = place.position, .material = glass, .orientation = turn};
          const double radius = random.uniform(0.2, 0.3);
          return body{.shape = lens{.radius = radius, .thickness = radius},
                      .position = place.position,
                      .material = glass,
                      .orientation = turn};
        });
    take_pictures(world, options, {.from = {7, -9, 6}, .at = {0, 0, 0.8}});
    world.simulate({.steps = options.steps, .dt = options.dt});

    std::array<double, 3> sums{};  // lenses, those that lie flat, and the lowest centre of all
    double lowest = 0;
    world.for_each_local([&](const auto& b) {
      lowest = std::max(lowest, -b.position()[2]);
      if constexpr (requires { b.shape().thickness; }) {
        const vec3 axis = b.orientation() * vec3(0, 0, 1);
        sums[0] += 1, sums[1] += std::abs(axis[2]) > 0.8, sums[2] += b.velocity().norm();
      }
    });
    world.link().reduce(reduction::sum, std::span<double>(sums));
    world.link().reduce(reduction::max, std::span<double>(&lowest, 1));
    return results{{"lenses", sums[0]},
                   {"flat", sums[1] / sums[0]},
                   {"mean_speed", sums[2] / sums[0]},
                   {"below", lowest}};
  });
}
