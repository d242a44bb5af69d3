// A rubble pile: spheres of many sizes, read from a table of another program, form two rotating
// lobes and collapse in the gravity field inside a ball of their mass. The virial theorem gives the
// final contact stress (R. Clausius, On a mechanical theorem applicable to heat, Phil. Mag. 40,
// 122, 1870): the sums of force times position over contacts and over gravity, and twice the
// kinetic energy, cancel.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/observe.hpp>
using namespace talus;

using rubble =
    scenario<bodies<sphere>, hard_contact<coulomb_friction, newton_restitution, no_correction>,
             solver<nonlinear_gauss_seidel, reproducible>,
             decomposition<grid<dynamic, dynamic, dynamic>>, transport<as_launched>,
             features<forces, checkpoints>>;

struct rubble_options : options {
  std::string grains;
  double gravity = 1, settle = 30;

  rubble_options() { steps = 8000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--grains", grains, "table of the spheres; without it the one beside the program");
    line.add_positive("--gravity", gravity, "at the surface of the ball");
    line.add_positive("--settle", settle, "time from which figures are taken");
  }
};

int main(int argc, char** argv) {
  const std::string program = argv[0];
  return run<rubble, rubble_options>(argc, argv, [&](auto& world, const rubble_options& options) {
    const std::string beside = program.substr(0, program.rfind('/') + 1) + "grains.csv";
    const packing grains = read_packing(options.grains.empty() ? beside : options.grains);
    real solid = 0;  // volume of the spheres, and the radius of the ball that they will make
    for (std::size_t i = 0; i < grains.size(); ++i) solid += sphere{grains[i].radius}.volume();
    const real R = std::cbrt(solid / (0.62 * 4 / 3 * pi));

    const real S = 3 * R;  // all of it is within
    world.decompose({.lower = {-S, -S, -S}, .upper = {S, S, S}});
    const auto stone = world.material({.density = 2, .restitution = 0.2, .friction = 0.5});
    world.fill(grains, [&](const site& place) {
      return body{.shape = sphere{grains[place.index].radius},
                  .position = place.position,
                  .material = stone,
                  .velocity = grains[place.index].velocity};
    });
    const auto field = [R, g = options.gravity](const vec3& x, real) { return vec3(-g / R * x); };
    add_force_field(world, field);
    take_pictures(world, options, {.from = {0, -8 * R, 3 * R}, .angle = 36});

    const motion before = measure_motion(world);
    std::array<double, 2> sums{};  // of contacts and motion, of gravity
    world.keep("virials", sums);
    world.observe(every{10}, [&](auto& w) {
      if (w.time() < options.settle) return;
      const coarse_fields all = measure_fields(w, {.lower = {-S, -S, -S}, .upper = {S, S, S}});
      double own = 0;
      w.for_each_local(
          [&](const auto& b) { own -= b.mass() * field(b.position(), 0).dot(b.position()); });
      w.link().reduce(reduction::sum, std::span(&own, 1));
      sums[0] += 3 * (8 * S * S * S) * all.pressure(0), sums[1] += own;
    });
    world.simulate({.steps = options.steps, .dt = options.dt});

    const motion after = measure_motion(world);
    const double half = 0.5 * R;
    const field_grid core{.lower = {-half, -half, -half}, .upper = {half, half, half}};
    return results{
        {"virial", sums[0] / std::max(sums[1], 1e-300)},
        {"solid_fraction_of_core", measure_fields(world, core).solid_fraction(0)},
        {"angular_momentum_lost", (after.angular_momentum - before.angular_momentum).norm() /
                                      before.angular_momentum.norm()}};
  });
}
