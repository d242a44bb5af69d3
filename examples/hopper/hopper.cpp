// A hopper of spheres and cubes empties onto the ground: output for ParaView and Python, and
// observers (docs/output.md).
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/observe.hpp>
#include <talus/vtk.hpp>
using namespace talus;

using hopper =
    scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction>,
             solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic, 1, dynamic>>,
             transport<as_launched>, features<checkpoints, vtk_output>>;  // --output NAME

struct hopper_options : options {
  int bodies = 1200;

  hopper_options() { steps = 1200; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--bodies", bodies, "number of spheres and cubes", 1);
  }
};

int main(int argc, char** argv) {
  return run<hopper, hopper_options>(argc, argv, [](auto& world, const hopper_options& options) {
    const double W = 8, slot = 1.6, depth = 4, low = 8, high = 15;  // half widths, depth, heights
    world.decompose({.lower = {-W, 0, 0}, .upper = {W, depth, 20}});
    world.gravity({0, 0, -9.81});
    const auto stone = world.material({.density = 2.5, .friction = 0.4});
    world.global([&](auto& scope) {
      scope.add(plane{}, stone);
      for (const double side : {-1, 1}) {
        scope.add(plane{.normal = {-side, 0, 0}, .offset = -W}, stone);
        scope.add(plane{.normal = {0, -side, 0}, .offset = side > 0 ? -depth : 0}, stone);
        const vec3 down(side * slot, 0.5 * depth, low), up(side * W, 0.5 * depth, high);
        const vec3 along = up - down;
        const double length = along.norm(), thickness = 0.4;
        const vec3 below = side * vec3(along[2], 0, -along[0]) / length;
        scope.add(box{{length, depth, thickness}}, stone,
                  0.5 * (down + up) + 0.5 * thickness * below,
                  rotation({0, 1, 0}, -std::atan2(along[2], along[0])));
      }
    });
    const auto sites = simple_cubic{.spacing = 0.9, .origin = {0.45, 0.45, 0}} &
                       box_region{{-W + 0.4, 0.4, high + 0.5}, {W - 0.4, depth - 0.4, high + 1000}};
    world.fill(sites.first(options.bodies), [&](const site& place, random_stream& random) {
      std::variant<body<sphere>, body<box>> made;
      if (random.uniform(0., 1.) < 0.7)
        made = body{.shape = sphere{random.uniform(0.25, 0.4)},
                    .position = place.position,
                    .material = stone};
      else
        made = body{.shape = box{{0.5, 0.5, random.uniform(0.3, 0.6)}},
                    .position = place.position,
                    .material = stone,
                    .orientation = random.rotation()};
      return made;
    });

    flow_meter outflow(world, plane{.normal = {0, 0, -1}, .offset = -low});
    coarse_fields mean({.lower = {-W, 0, low}, .upper = {W, depth, high}, .cells = {8, 1, 7}});
    world.observe("mean fields", every{20}, [&](auto& w) {
      if (w.time() > 2) mean += measure_fields(w, mean.grid());
    });
    world.simulate({.steps = options.steps, .dt = options.dt});

    const flow out = outflow.total();
    std::array<double, 2> masses{};  // of all bodies, and of those below the outlet
    world.for_each_local([&](const auto& b) {
      masses[0] += b.mass();
      if (b.position()[2] <= low) masses[1] += b.mass();
    });
    world.link().reduce(reduction::sum, masses);
    const coarse_fields all = measure_fields(
        world, {.lower = {-W, 0, 0}, .upper = {W, depth, 100}, .cells = {16, 4, 100}});
    double mass = 0;
    for (std::size_t cell = 0; cell < all.grid().size(); ++cell) mass += all.mass(cell);
    const std::size_t middle = mean.grid().index(4, 0, 1);
    return results{{"mass_out", out.mass()},
                   {"bodies_out", static_cast<double>(out.bodies())},
                   {"mass_out_error", std::abs(out.mass() - masses[1]) / masses[0]},
                   {"mass_in_cells_error", std::abs(mass - masses[0]) / masses[0]},
                   {"coordination", measure_coordination(world).mean},
                   {"density_above_the_slot", mean.density(middle)},
                   {"speed_above_the_slot", mean.velocity(middle).norm()},
                   {"pressure_above_the_slot", mean.pressure(middle)}};
  });
}
