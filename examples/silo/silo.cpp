// A silo runs out through the orifice of its cone (M. Dosta and others 2024, silo). The mass flow
// rate is compared with Beverloo's law. With --spheres 100000 --softness 1, --dt 1.5e-6 (--m2:
// 2e-6) and --orifice 0.03 or 0.02 it is the published case, with a filling of its own.
#include <talus/checkpoint.hpp>
#include <talus/mesh.hpp>
#include <talus/mpi.hpp>
#include <talus/observe/tables.hpp>

#include "../../benchmarks/dosta.hpp"
using namespace talus;

using silo =
    scenario<bodies<sphere, triangle_mesh, plane>, soft_contact<hertz_mindlin, coulomb_friction>,
             integrator<velocity_verlet>, decomposition<grid<dynamic, dynamic>>,
             transport<as_launched>, features<visibility, checkpoints>>;

struct silo_options : options {
  int spheres = 700;
  double softness = 1000, orifice = 0.012, settling = 0.2;
  bool m2 = false;
  std::string walls, settled;

  silo_options() { steps = 8000, dt = 4e-5; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--spheres", spheres, "number of spheres", 100);
    line.add("--softness", softness, "divides Young's modulus", 1.0, 10000.0);
    line.add("--orifice", orifice, "radius of the orifice in metres", 0.008, 0.05);
    line.add("--settling", settling, "seconds before the orifice opens", 0.0, 10.0);
    line.add("--m2", m2, "spheres of the second material, not of the first one");
    line.add("--walls", walls, "file of the triangles of the silo");
    line.add("--settled", settled, "table of the spheres when the orifice opens");
  }
};

/// The inside of a cylinder on a cone of 45 degrees.
struct inside {
  double radius, orifice, lip, margin;

  [[nodiscard]] bool contains(const vec3& at) const {
    const double r = std::hypot(at[0], at[1]), z = at[2] - lip;
    return z > margin && r < std::min(radius - margin, orifice + z - 1.5 * margin);
  }
};

int main(int argc, char** argv) {
  return run<silo, silo_options>(argc, argv, [](auto& world, const silo_options& options) {
    const double size = std::cbrt(options.spheres / 100000.0), bead = 0.002;
    const double R = options.walls.empty() ? std::max(0.1 * size, 1.7 * options.orifice) : 0.1;
    const double cone = R - options.orifice, H = 6 * R;  // heights of the cone and of the cylinder
    // The lips of the published walls, of which one or the other is read.
    const double lip = options.walls.empty()     ? 0
                       : options.orifice > 0.025 ? -0.0554222
                                                 : -0.0593008;

    world.decompose({.lower = {-R, -R}, .upper = {R, R}});
    world.gravity({0, 0, -dosta::gravity});
    const auto materials = dosta::add_materials(world, options.softness);
    const auto stuff = options.m2 ? materials.m2 : materials.m1;
    const double density = options.m2 ? 2000 : 2500;
    handle<plane> gate;
    world.global([&](auto& scope) {
      const auto add = [&](const triangle_mesh& surface, bool visible) {
        const pose at = placed(surface);
        const auto wall = scope.add(surface, materials.steel, at.position, at.orientation);
        world[wall].set_visible(visible);
      };
      if (!options.walls.empty()) add(triangle_mesh(dosta::read_triangles(options.walls)), false);
      for (const bool front : {false, true})  // without its front the silo shows what is in it
        if (options.walls.empty())
          add(surface_of_revolution({{options.orifice, lip}, {R, lip + cone}, {R, lip + cone + H}},
                                    {.sectors = 32, .from = front ? -pi : 0, .to = front ? 0 : pi}),
              !front);
      gate = scope.add(plane{.normal = {0, 0, 1}, .offset = lip}, materials.steel);
      world[gate].set_visible(false);
    });
    const auto sites =
        simple_cubic{.spacing = 2.1 * bead, .origin = {bead, bead, lip + 1.1 * bead}} &
        box_region{{-R, -R, lip}, {R, R, lip + cone + 0.9 * H}} &
        inside{R, options.orifice, lip, 1.05 * bead};
    world.fill(sites.first(options.spheres), [&](const site& place, random_stream& random) {
      return body{.shape = sphere{bead},
                  .position = place.position,
                  .material = stuff,
                  .velocity = random.uniform(vec3(-0.1, -0.1, -0.1), vec3(0.1, 0.1, 0.1))};
    });
    const outflow fallen = remove_in(world, half_space(0, 0, -1, 0.02 - lip));
    take_pictures(
        world, options,
        {.from = {0, -7 * R, 4 * R}, .at = {0, 0, 1.5 * R}, .angle = 36, .ground = false});
    const double settled = std::ceil(options.settling / options.dt);
    world.simulate({.steps = static_cast<std::uint64_t>(settled), .dt = options.dt});

    // What looks at the settled bodies is done once: a restart in the second stage has its values.
    world.once("settled", [&] {
      if (!options.settled.empty()) body_table(world).write_csv(options.settled);
    });

    // Spheres above the lip, and those in a slice of the cylinder or of the cone, for their
    // density.
    const double from = world.time();
    const auto above = [&](double lower, double upper) {
      double n = 0;
      world.for_each_local([&](const auto& b) {
        const double z = b.position()[2];
        n += !b.is_fixed() && z > lower && z < upper;
      });
      world.link().reduce(reduction::sum, std::span(&n, 1));
      return n;
    };
    const double volume = 4.0 / 3 * pi * bead * bead * bead, mass = density * volume;
    const double far = lip + cone + H, low = lip + 0.2 * cone, high = lip + cone;
    const auto cubed = [&](double z) { return std::pow(options.orifice + z - lip, 3); };
    const double in_cone = world.once("in cone", [&] { return above(low, high); });
    const double bulk = mass * in_cone / (pi / 3 * (cubed(high) - cubed(low)));
    const double filled = world.once("filled", [&] { return above(lip, far); });
    std::array<double, 2> quarters{};  // times at which a fifth and two fifths have run out
    world.keep("quarters", quarters);
    const auto every = static_cast<std::uint64_t>(std::max(1.0, std::round(2e-3 / options.dt)));
    world.destroy(gate);
    world.after_each_step([&] {
      if (world.steps() % every != 0) return;
      const double left = above(lip, far), time = world.time() - from;
      for (std::size_t k = 0; k < 2; ++k)
        if (quarters[k] == 0 && left <= (0.8 - 0.2 * static_cast<double>(k)) * filled)
          quarters[k] = time;
      world.record("above_the_lip", left);
    });
    world.simulate({.steps = options.steps, .dt = options.dt});
    const bool measured = quarters[1] > quarters[0] && quarters[0] > 0;
    const double rate = measured ? 0.2 * filled * mass / (quarters[1] - quarters[0]) : 0;
    // Beverloo, Leniger, van de Velde 1961, for a flat bottom.
    const double law = 0.58 * bulk * std::sqrt(dosta::gravity) *
                       std::pow(2 * options.orifice - 1.4 * 2 * bead, 2.5);
    return results{{"filled", filled},
                   {"bulk_density", bulk},
                   {"mass_flow_rate", rate},
                   {"mass_flow_rate_over_beverloo", rate / law},
                   {"above_the_lip", above(lip, far)},
                   {"left", static_cast<double>(fallen.total(world).count)}};
  });
}
