// The well: spheres fall into a round wall of fixed bricks (pe tutorial, section 5).
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using well =
    scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<nonlinear_gauss_seidel, reproducible>,
             decomposition<any_decomposition>,  // of four ranks a grid makes two by two
             transport<as_launched>, features<damping, checkpoints>>;

struct well_options : options {
  int spheres = 3000;
  double kept = 0.9;
  std::string shares = "grid";

  well_options() {
    steps = 6000;
    dt = 0.005;
  }
  void describe(auto& line) {
    options::describe(line);
    line.add("--spheres", spheres, "number of spheres", 0);
    line.add("--decomposition", shares, "grid, slabs, bisection or hexagonal");
    line.add("--damping", kept, "part of the velocity that is kept per unit of time");
  }
};

int main(int argc, char** argv) {
  return run<well, well_options>(argc, argv, [](auto& world, const well_options& options) {
    const double R = 30;      // radius of the well
    const int B = 40, H = 5;  // bricks per level, levels
    const double brick_x = std::sqrt(2 * R * R * (1 - std::cos(2 * pi / B)));
    const vec3 brick{brick_x, 0.5 * brick_x, 0.4 * brick_x};

    world.decompose(named_decomposition(options.shares, {-R, -R, 0}, {R, R, 0}));
    world.gravity({0, 0, -2});
    world.damping(options.kept);
    const auto granite = world.material(materials::granite);
    const auto stuff = world.material({.density = 1, .restitution = 0.2, .friction = 0.25});

    world.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, 1}, .offset = 0}, granite); });
    world.fill(ring_of{.count = B, .levels = H, .radius = R + 0.5 * brick[1], .height = brick[2]},
               [&](const site& place) {
                 return body{.shape = box{brick},
                             .position = place.position,
                             .material = granite,
                             .orientation = place.orientation,
                             .fixed = true};
               });

    const double spacing = 2.4, first = -11 * spacing;  // 23 by 23 sites a layer
    const auto sites =
        simple_cubic{.spacing = spacing, .origin = {first, first, 3 * brick[2] * H}} &
        vertical_cylinder{.radius = 0.9 * R};
    world.fill(sites.first(options.spheres), [&](const site& place, random_stream& random) {
      return body{.shape = sphere{random.uniform(0.6, 1.2)},
                  .position = place.position,
                  .material = stuff,
                  .velocity = random.uniform(vec3(-1, -1, -0.2), vec3(1, 1, 0.2)),
                  .angular_velocity = random.uniform(vec3(-0.1, -0.1, -0.1), vec3(0.1, 0.1, 0.1))};
    });
    take_pictures(world, options,
                  {.from = {0, -75, 95},
                   .at = {0, 0, -4},
                   .angle = 44,
                   .colour = picture::colouring::rank,
                   .walls = 1});
    world.simulate({.steps = options.steps, .dt = options.dt});
  });
}
