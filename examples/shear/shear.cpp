// An endless shear cell: gravel between two rough plates in a box that is periodic along both. The
// lower plate moves, the upper one presses with a given force. The effective friction is the ratio
// of the tangential to the normal force on the plates.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/observe/force.hpp>
using namespace talus;

using shear = scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction>,
                       solver<nonlinear_gauss_seidel, reproducible>,
                       decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>,
                       transport<as_launched>, features<driven, checkpoints>>;

struct shear_options : options {
  double speed = 1, pressure = 1;

  shear_options() { steps = 20000, dt = 0.005; }
  void describe(auto& line) {
    options::describe(line);
    line.add_positive("--speed", speed, "of the lower plate");
    line.add_positive("--pressure", pressure, "of the upper plate, force over area");
  }
};

int main(int argc, char** argv) {
  return run<shear, shear_options>(argc, argv, [](auto& world, const shear_options& options) {
    const double L = 10, W = 6, H = 8;  // of the box, and the height at which the plate begins
    world.decompose({{.lower = {0, 0}, .upper = {L, W}}});
    const auto stone = world.material({.density = 1, .friction = 0.5});
    const auto rough = world.material({.density = 1, .friction = 2});
    world.material_pair(stone, rough, {.friction = 2});

    handle<plane> lower, upper;
    world.global([&](auto& scope) {
      lower = scope.add(plane{.normal = {0, 0, 1}, .offset = 0}, rough);
      upper = scope.add(plane{.normal = {0, 0, -1}, .offset = -H}, rough);
    });
    world.drive(lower, belt{{options.speed, 0, 0}});
    world.hold_force(upper, {.force = options.pressure * L * W, .max_speed = 0.5});
    world.fill(
        simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} & box_region{{0, 0, 0}, {L, W, H}},
        [&](const site& place, random_stream& random) {
          std::variant<body<sphere>, body<box>> made;
          const double r = random.uniform(0.38, 0.5);
          if (random.integer(2) == 0)
            made = body{.shape = sphere{r}, .position = place.position, .material = stone};
          else
            made = body{.shape = box{{1.1 * r, 1.1 * r, 1.1 * r}},
                        .position = place.position,
                        .material = stone,
                        .orientation = random.rotation()};
          return made;
        });
    take_pictures(
        world, options,
        {.from = {0.5 * L, -20, 6}, .at = {0.5 * L, 0.5 * W, 2}, .angle = 36, .ground = false});

    vec3 on_lower{0, 0, 0}, on_upper{0, 0, 0};  // forces, averaged over the second half
    double looks = 0;
    for (int k = 0; k < 3; ++k) {
      world.keep("on_lower " + std::to_string(k), on_lower[k]);
      world.keep("on_upper " + std::to_string(k), on_upper[k]);
    }
    world.keep("looks", looks);
    world.observe(every{10}, [&](auto& w) {
      if (2 * w.steps() < options.steps) return;
      on_lower += contact_force(w, lower), on_upper += contact_force(w, upper), ++looks;
    });
    world.simulate({.steps = options.steps, .dt = options.dt});
    const double pressed = on_upper[2], n = std::max(looks, 1.0);
    return results{{"friction", -on_lower[0] / std::max(pressed, 1e-300)},
                   {"pressure", pressed / (n * L * W)},
                   {"plates_differ", (on_lower + on_upper).norm() / std::max(pressed, 1e-300)},
                   {"height", world[upper].shape().offset * -1}};
  });
}
