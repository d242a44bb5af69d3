// The hexagonal well: spheres and boxes fall into a round wall of 3,000 fixed bricks, on hexagonal
// domains (pe tutorial, figure 1). With --bodies 500000 --ranks 91 it is the scene of that figure.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <variant>
using namespace talus;

using hexwell =
    scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<nonlinear_gauss_seidel, reproducible>,
             decomposition<hexagonal<dynamic>>,  // 1, 7, 19, 37, 61, 91 ranks ...
             transport<as_launched>, features<damping, checkpoints>>;

struct hexwell_options : options {
  int bodies = 3000;

  hexwell_options() { steps = 4000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--bodies", bodies, "number of spheres and boxes", 1);
  }
};

int main(int argc, char** argv) {
  return run<hexwell, hexwell_options>(argc, argv, [](auto& world, const hexwell_options& options) {
    // The bodies fill three quarters of the well: the volume of a heap is about five times the sum
    // of the cubes of the mean radius.
    const int B = 200, H = 15;                          // bricks per level, levels
    const double R = std::cbrt(12.0 * options.bodies);  // radius of the well
    const double brick_x = 2 * R * std::sin(pi / B);
    const vec3 brick{brick_x, 0.8 * brick_x, 0.4 * brick_x};

    world.decompose({.width = 2.1 * R});
    world.gravity({0, 0, -9.81});
    world.damping(0.9);
    const auto granite = world.material(materials::granite);
    const auto stuff = world.material({.density = 1, .restitution = 0.1, .friction = 0.3});

    world.global([&](auto& scope) { scope.add(plane{}, granite); });
    world.fill(ring_of{.count = B, .levels = H, .radius = R + 0.5 * brick[1], .height = brick[2]},
               [&](const site& place) {
                 return body{.shape = box{brick},
                             .position = place.position,
                             .material = granite,
                             .orientation = place.orientation,
                             .fixed = true};
               });

    const auto sites = simple_cubic{.spacing = 2.4, .origin = {1.2, 1.2, 0.5 * H * brick[2]}} &
                       vertical_cylinder{.radius = 0.9 * R};
    using any_body = std::variant<body<sphere>, body<box>>;
    world.fill(sites.first(options.bodies), [&](const site& place, random_stream& random) {
      const auto falling = [&](const auto& shape) -> any_body {
        return body{.shape = shape,
                    .position = place.position,
                    .material = stuff,
                    .velocity = random.uniform(vec3(-1, -1, -0.2), vec3(1, 1, 0.2)),
                    .angular_velocity = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1))};
      };
      if (place.index % 2 == 0) return falling(sphere{random.uniform(0.6, 1.1)});
      return falling(box{random.uniform(vec3(0.8, 0.8, 0.8), vec3(1.3, 1.3, 1.3))});
    });
    take_pictures(world, options,
                  {.from = {0, -2.3 * R, 2.7 * R},
                   .at = {0, -0.05 * R, 0},
                   .colour = picture::colouring::rank,
                   .walls = 1});
    world.simulate({.steps = options.steps, .dt = options.dt});
  });
}
