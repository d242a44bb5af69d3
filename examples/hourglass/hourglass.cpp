// An hourglass: spheres run through the neck of a surface of triangles. The flow does not depend on
// the number of spheres above.
#include <talus/checkpoint.hpp>
#include <talus/mesh.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using hourglass =
    scenario<bodies<sphere, triangle_mesh, plane>, hard_contact<coulomb_friction>,
             solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic, dynamic>>,
             transport<as_launched>, features<visibility, checkpoints>>;

struct hourglass_options : options {
  int spheres = 1000;
  double neck = 6;

  hourglass_options() { steps = 3000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--spheres", spheres, "number of spheres", 100);
    line.add("--neck", neck, "width of the neck, in diameters of spheres", 3.0, 10.0);
  }
};

int main(int argc, char** argv) {
  return run<hourglass,
             hourglass_options>(argc, argv, [](auto& world, const hourglass_options& options) {
    const double size = std::cbrt(options.spheres / 2000.0), gravity = 9.81;
    const double r = 0.5 * options.neck, R = 9.5 * size, H = 12 * size, top = H + 6 * size;

    world.decompose({.lower = {-R, -R}, .upper = {R, R}});
    world.gravity({0, 0, -gravity});
    const auto glass = world.material({.density = 2.5, .friction = 0.3});
    world.global([&](auto& scope) {
      scope.add(plane{.offset = -top}, glass);
      for (const bool front : {false, true}) {  // without its front the glass shows what is in it
        const auto half =
            surface_of_revolution({{R, -top}, {R, -H}, {r, -0.5}, {r, 0.5}, {R, H}, {R, top + 20}},
                                  {.sectors = 32, .from = front ? -pi : 0, .to = front ? 0 : pi});
        const pose at = placed(half);
        const auto wall = scope.add(half, glass, at.position, at.orientation);
        world[wall].set_visible(!front);
      }
    });
    const auto sites = simple_cubic{.spacing = 1.12, .origin = {0.56, 0.56, H}} &
                       vertical_cylinder{.radius = R - 0.8};
    world.fill(sites.first(options.spheres), [&](const site& place, random_stream& random) {
      return body{.shape = sphere{0.5 * random.uniform(0.9, 1.1)},
                  .position = place.position,
                  .material = glass};
    });
    take_pictures(world, options,
                  {.from = {0, -80 * size, 20 * size},
                   .at = {0, 0, -3 * size},
                   .angle = 36,
                   .ground = false});

    // Times at which quarters of the spheres have run through, checked every tenth step.
    std::array<double, 3> quarters{};
    world.keep("quarters", quarters);
    world.after_each_step([&] {
      if (world.steps() % 10 != 0) return;
      double through = 0;
      world.for_each_local([&](const auto& b) { through += b.position()[2] < 0; });
      world.link().reduce(reduction::sum, std::span(&through, 1));
      for (std::size_t k = 0; k < 3; ++k)
        if (quarters[k] == 0 && through >= 0.25 * (k + 1.0) * options.spheres)
          quarters[k] = world.time();
    });
    world.simulate({.steps = options.steps, .dt = options.dt});

    const double quarter = 0.25 * options.spheres;
    const double second = quarter / (quarters[1] - quarters[0]);
    const double third = quarter / (quarters[2] - quarters[1]);
    return results{{"rate_of_second_quarter", second},
                   {"rate_of_third_quarter", third},
                   {"rate_ratio", third / second}};
  });
}
