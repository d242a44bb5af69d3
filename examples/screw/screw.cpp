// A screw conveyor: a screw from an STL file rotates in a trough and conveys gravel, which falls in
// at one end and out at the other. At low filling, with no gravel passing over the shaft into the
// next turn, the gravel advances by one pitch per turn.
#include <talus/checkpoint.hpp>
#include <talus/mesh.hpp>
#include <talus/mpi.hpp>
#include <talus/observe.hpp>
using namespace talus;

using screw = scenario<bodies<sphere, box, triangle_mesh, plane>, hard_contact<coulomb_friction>,
                       solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic>>,
                       transport<as_launched>, features<driven, checkpoints>>;

struct screw_options : options {
  std::string stl;
  double speed = 2, rate = 20;

  screw_options() { steps = 6000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--stl", stl, "a screw of the same size; without it the one beside the program");
    line.add_positive("--speed", speed, "of the screw, radians per unit of time");
    line.add_positive("--rate", rate, "bodies that fall in per unit of time");
  }
};

int main(int argc, char** argv) {
  const std::string program = argv[0];
  return run<screw, screw_options>(argc, argv, [&](auto& world, const screw_options& options) {
    const double L = 24, R = 2.95;  // of the trough, in whose wall the flight runs
    const double pitch = 4;
    world.decompose({.lower = {0}, .upper = {L}});
    world.gravity({0, 0, -9.81});
    const auto gravel = world.material({.density = 2.5, .friction = 0.4});
    const auto steel = world.material({.density = 7.8, .friction = 0.2});
    world.material_pair(gravel, steel, {.friction = 0.2});

    const std::string beside = program.substr(0, program.rfind('/') + 1) + "screw.stl";
    const triangle_mesh shape = read_stl(options.stl.empty() ? beside : options.stl);
    const pose at = placed(shape);
    world.global([&](auto& scope) {
      const auto turns = scope.add(shape, steel, at.position, at.orientation);
      world.drive(turns, turning{.axis = {1, 0, 0}, .speed = options.speed});
      scope.add(plane{.normal = {1, 0, 0}, .offset = 0}, steel);
      scope.add(plane{.normal = {0, 1, 0}, .offset = -R}, steel);
      scope.add(plane{.normal = {0, -1, 0}, .offset = -R}, steel);
      const int planks = 12;
      for (int k = 0; k < planks; ++k) {  // the lower half of a tube
        const quat q = rotation({1, 0, 0}, pi * (k + 0.5) / planks - pi);
        const box plank{{L, 0.5, 2 * (R + 0.5) * std::tan(0.5 * pi / planks)}};
        scope.add(plank, steel, rotated(q, {0.5 * L, R + 0.25, 0}), q);
      }
    });
    const sieve_curve sizes(
        {{.size = 0.3, .mass = 30}, {.size = 0.4, .mass = 50}, {.size = 0.5, .mass = 20}});
    const auto in = insert_by_rate(
        world, {.bodies = options.rate}, box_region{{0.6, -1.5, 3.6}, {3.4, 1.5, 6}},
        [&](const site& place, random_stream& random) {
          std::variant<body<sphere>, body<box>> made;
          const double r = sizes(random);
          if (random.integer(2) == 0)
            made = body{.shape = sphere{r}, .position = place.position, .material = gravel};
          else
            made = body{.shape = box{{1.6 * r, 1.6 * r, 1.6 * r}},
                        .position = place.position,
                        .material = gravel,
                        .orientation = random.rotation()};
          return made;
        });
    const outflow out = remove_in(world, box_region{{L - 0.5, -R, -20}, {L + 20, R, -8}});
    take_pictures(
        world, options,
        {.from = {0.6 * L, -28, 20}, .at = {0.5 * L, 0, -0.5}, .angle = 44, .ground = false});

    // Speed along the screw in the steady part, after the first grains have passed through.
    const double through = L / pitch * 2 * pi / options.speed;
    std::array<double, 2> pace{};  // momentum, mass
    world.keep("pace", pace);
    world.observe(every{20}, [&](auto& w) {
      if (w.time() < through) return;
      const coarse_fields now =
          measure_fields(w, {.lower = {2 * pitch, -R, -R}, .upper = {L - pitch, R, R}});
      pace[0] += now.mass(0) * now.velocity(0)[0], pace[1] += now.mass(0);
    });
    world.simulate({.steps = options.steps, .dt = options.dt});
    double leaked = 0;
    world.for_each_local(
        [&](const auto& b) { leaked += b.position()[2] < -R - 0.5 && b.position()[0] < L - 0.5; });
    world.link().reduce(reduction::sum, std::span(&leaked, 1));
    const double speed = pace[0] / std::max(pace[1], 1e-300);
    return results{{"inserted", static_cast<double>(in->count)},
                   {"fell_off", static_cast<double>(out.total(world).count)},
                   {"leaked", leaked},
                   {"pitches_per_turn", speed * 2 * pi / options.speed / pitch}};
  });
}
