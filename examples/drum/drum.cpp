// A rotating drum: spheres, capsules and boxes enter while it stands, then it rotates. The angle of
// their heap against the horizontal is the dynamic angle of repose.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/vtk.hpp>
#include <variant>
using namespace talus;

using drum =
    scenario<bodies<sphere, capsule, box, plane>, hard_contact<coulomb_friction>,
             solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic, dynamic>>,
             transport<as_launched>, features<driven, checkpoints, vtk_output>>;

struct drum_options : options {
  int bodies = 600;
  double speed = 0.3;  // radians per unit of time

  drum_options() { steps = 5000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--bodies", bodies, "number of bodies", 1);
    line.add("--speed", speed, "of the drum, radians per unit of time");
  }
};

int main(int argc, char** argv) {
  return run<drum, drum_options>(argc, argv, [](auto& world, const drum_options& options) {
    const double R = 8, L = 6, g = 9.81;  // radius, length, gravity
    world.decompose({.lower = {-R, 0}, .upper = {R, L}});
    world.gravity({0, 0, -g});
    const auto gravel = world.material({.density = 2.5, .friction = 0.5});
    const auto glass = world.material({.density = 2.5});
    world.material_pair(gravel, glass, {});

    const double start = 1.2 * R / std::sqrt(g) + options.bodies / 400.0;
    const auto turn = [=](double t) {
      return turning{.axis = {0, 1, 0}, .speed = options.speed}(std::max(t - start, 0.0));
    };
    world.global([&](auto& scope) {
      scope.add(plane{.normal = {0, 1, 0}, .offset = 0}, glass);
      scope.add(plane{.normal = {0, -1, 0}, .offset = -L}, glass);
      const int planks = 24;
      for (int k = 0; k < planks; ++k) {
        const quat q = rotation({0, 1, 0}, 2 * pi * k / planks);
        const box plank{{1, L, 2.1 * (R + 1) * std::tan(pi / planks)}};
        world.drive(scope.add(plank, gravel, rotated(q, {R + 0.5, 0.5 * L, 0}), q), turn);
      }
    });
    const lognormal_size sizes{.median = 0.35, .sigma = 0.2, .lower = 0.25, .upper = 0.5};
    const auto in = insert_by_rate(
        world, {.bodies = 400, .most = static_cast<std::uint64_t>(options.bodies)},
        box_region{{-4, 0.6, -2}, {4, L - 0.6, 4}}, [&](const site& place, random_stream& random) {
          const double r = sizes(random);
          const auto made = [&](const auto& shape) {
            return std::variant<body<sphere>, body<capsule>, body<box>>(
                body{.shape = shape,
                     .position = place.position,
                     .material = gravel,
                     .orientation = random.rotation()});
          };
          const auto which = random.integer(3);
          if (which == 0) return made(sphere{r});
          if (which == 1) return made(capsule{0.7 * r, 1.2 * r});
          return made(box{{1.5 * r, 1.5 * r, 1.5 * r}});
        });
    take_pictures(world, options,
                  {.from = {0, -26, 3}, .at = {0, 0, 0}, .angle = 42, .ground = false});

    // Angle of the centre of mass about the axis, averaged over the second half of the rotation.
    double angles = 0, looks = 0;
    world.keep("angles", angles);
    world.keep("looks", looks);
    world.after_each_step([&] {
      if (world.time() < 0.5 * (start + options.steps * options.dt) || world.steps() % 10 != 0)
        return;
      std::array<double, 2> moment{0, 0};
      world.for_each_local([&](const auto& b) {
        moment[0] += b.mass() * b.position()[0], moment[1] += b.mass() * b.position()[2];
      });
      world.link().reduce(reduction::sum, moment);
      angles += std::atan2(-moment[0], -moment[1]) * 180 / pi, ++looks;
    });
    world.simulate({.steps = options.steps, .dt = options.dt});
    return results{{"inserted", static_cast<double>(in->count)},
                   {"angle_of_repose", angles / std::max(looks, 1.0)}};
  });
}
