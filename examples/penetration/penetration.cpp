// A steel sphere hits a bed of beads at 5 m/s (M. Dosta and others 2024, penetration). Without
// --particles the bed is a smaller one of its own: beads fall and settle before the impact. With
// the published file, --softness 1 --dt 5e-7 and --steps 200000 it is the published case. The table
// of --csv has the height and the velocity of the steel sphere.
#include <talus/mpi.hpp>

#include "../../benchmarks/dosta.hpp"
using namespace talus;

using bed = scenario<bodies<sphere, plane>, soft_contact<hertz_mindlin, coulomb_friction>,
                     integrator<velocity_verlet>, decomposition<grid<dynamic, dynamic>>,
                     transport<as_launched>>;

struct penetration_options : options {
  int spheres = 1000;
  double softness = 200, shift = 0;
  std::string particles;

  penetration_options() { steps = 5000, dt = 5e-6; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--spheres", spheres, "of the bed, without --particles", 100);
    line.add("--softness", softness, "divides Young's modulus of the beads", 1.0, 1000.0);
    line.add("--shift", shift, "of the steel sphere along x, in metres", -0.01, 0.01);
    line.add("--particles", particles, "file of the bed: radius, x, y, z");
  }
};

int main(int argc, char** argv) {
  return run<bed, penetration_options>(
      argc, argv, [](auto& world, const penetration_options& options) {
        const bool published = !options.particles.empty();
        const double size = published ? 1 : std::cbrt(options.spheres / 25000.0);
        const double half_x = 0.049 * size, half_y = 0.03 * size, floor = -0.0902431 * size;
        const double bead = 0.001, radius = 0.01 * size, speed = 5;
        world.decompose({.lower = {-half_x, -half_y}, .upper = {half_x, half_y}});
        world.gravity({0, 0, -dosta::gravity});
        const auto materials = dosta::add_materials(world, options.softness, options.softness);
        world.global([&](auto& scope) {
          scope.add(plane{.normal = {0, 0, 1}, .offset = floor}, materials.steel);
          scope.add(plane{.normal = {1, 0, 0}, .offset = -half_x}, materials.steel);
          scope.add(plane{.normal = {-1, 0, 0}, .offset = -half_x}, materials.steel);
          scope.add(plane{.normal = {0, 1, 0}, .offset = -half_y}, materials.steel);
          scope.add(plane{.normal = {0, -1, 0}, .offset = -half_y}, materials.steel);
        });
        const auto add = [&](const vec3& at, double r, material_id m, const vec3& velocity) {
          world.add_if_local(
              body{.shape = sphere{r}, .position = at, .material = m, .velocity = velocity});
        };
        take_pictures(world, options,
                      {.from = {0, -5 * half_x, 2 * half_x},
                       .at = {0, 0, 0.8 * floor},
                       .angle = 30,
                       .ground = false});
        if (published) {
          for (const auto& g : dosta::read_spheres(options.particles))
            add(g.position, g.radius, materials.m1, {0, 0, 0});
        } else {
          const auto sites =
              simple_cubic{.spacing = 2.05 * bead, .origin = {0, 0, floor + 1.02 * bead}} &
              box_region{{-half_x + bead, -half_y + bead, floor},
                         {half_x - bead, half_y - bead, floor + 100 * half_x}};
          world.fill(sites.first(options.spheres), [&](const site& place, random_stream& random) {
            return body{.shape = sphere{bead * random.uniform(0.9, 1)},
                        .position = place.position,
                        .material = materials.m1,
                        .velocity = random.uniform(vec3(-0.1, -0.1, -0.1), vec3(0.1, 0.1, 0.1))};
          });
          world.simulate({.steps = static_cast<std::uint64_t>(std::llround(0.06 / options.dt)),
                          .dt = options.dt});
        }
        // The bed ends above its highest bead.
        double top = -1;
        world.for_each_local([&](const auto& b) {
          if (!b.is_fixed()) top = std::max(top, b.position()[2] + bead);
        });
        world.link().reduce(reduction::max, std::span(&top, 1));
        const double start = published ? 0.06 : top + radius;
        add({options.shift, 0, start}, radius, materials.steel, {0, 0, -speed});

        // Height and velocity of the steel sphere.
        const auto look = [&] {
          std::array<double, 2> seen{};
          world.for_each_local([&](const auto& b) {
            if (b.shape().radius > 2 * bead) seen = {b.position()[2], b.velocity()[2]};
          });
          world.link().reduce(reduction::sum, seen);
          return seen;
        };
        double lowest = start;
        const auto every = static_cast<std::uint64_t>(std::max(1.0, std::round(2e-4 / options.dt)));
        world.after_each_step([&] {
          if (world.steps() % every != 0) return;
          const auto [z, v] = look();
          lowest = std::min(lowest, z);
          world.record("height", z, "L");
          world.record("velocity", v, "L/T");
        });
        world.simulate({.steps = options.steps, .dt = options.dt});
        const auto [z, v] = look();
        return results{{"bed_height", top - floor},
                       {"height", z},
                       {"lowest", lowest},
                       {"speed", std::abs(v)},
                       {"depth", (top - (lowest - radius)) / radius}};
      });
}
