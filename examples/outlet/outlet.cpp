// A granular medium leaves a silo through a slot (pe tutorial, figures 2 to 4). The mass flow rate
// is compared with Beverloo's law. Domains: nine by seven rectangles in x and z, and the space
// below the outlet. With --spheres 108570 it is the scene of those figures.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using outlet = scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction>,
                        solver<nonlinear_gauss_seidel, reproducible>,
                        decomposition<join<grid<9, 1, 7>, slabs<1>>>, transport<as_launched>,
                        features<checkpoints>>;

struct outlet_options : options {
  int spheres = 4000;

  outlet_options() { steps = 2000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--spheres", spheres, "number of spheres", 100);
  }
};

int main(int argc, char** argv) {
  return run<outlet, outlet_options>(argc, argv, [](auto& world, const outlet_options& options) {
    const double d = 1;  // mean diameter
    const double scale = std::cbrt(options.spheres / 4000.0);
    const double W = 24 * scale, D = 5 * scale, H = 30 * scale;  // silo: width, depth, height
    const double slot = 6 * scale, floor = 2;                    // width of the outlet, thickness
    const double gravity = 9.81, time_open = 3 * std::sqrt(scale);

    world.decompose(join(grid<9, 1, 7>{.lower = {0, 0, 0}, .upper = {W, 0, H}},
                         within(half_space(0, 0, -1, floor), slabs<1>{})));
    world.gravity({0, 0, -gravity});
    const auto glass = world.material({.density = 2.5, .restitution = 0, .friction = 0.5});
    const auto smooth = world.material({.density = 2.5});
    world.material_pair(glass, smooth, {.friction = 0, .dynamic_friction = 0});

    handle<box> gate;
    world.global([&](auto& scope) {
      scope.add(plane{.normal = {1, 0, 0}, .offset = 0}, glass);
      scope.add(plane{.normal = {-1, 0, 0}, .offset = -W}, glass);
      scope.add(plane{.normal = {0, 1, 0}, .offset = 0}, smooth);
      scope.add(plane{.normal = {0, -1, 0}, .offset = -D}, smooth);
      const double side = 0.5 * (W - slot);
      scope.add(box{{side, D, floor}}, glass, {0.5 * side, 0.5 * D, -0.5 * floor});
      scope.add(box{{side, D, floor}}, glass, {W - 0.5 * side, 0.5 * D, -0.5 * floor});
      gate = scope.add(box{{slot, D, floor}}, glass, {0.5 * W, 0.5 * D, -0.5 * floor});
    });
    const auto sites = simple_cubic{.spacing = 1.12 * d, .origin = {0.57, 0.57, 0.57}} &
                       box_region{{0.56, 0.56, 0}, {W - 0.56, D - 0.56, 100 * H}};
    world.fill(sites.first(options.spheres), [&](const site& place, random_stream& random) {
      return body{.shape = sphere{0.5 * d * random.uniform(0.9, 1.1)},
                  .position = place.position,
                  .material = glass,
                  .velocity = random.uniform(vec3(-0.1, -0.1, -0.1), vec3(0.1, 0.1, 0.1))};
    });

    // Spheres are counted and removed when they have fallen well below the outlet.
    const outflow fallen = remove_in(world, half_space(0, 0, -1, floor + 4));
    take_pictures(world, options,
                  {.from = {0.5 * W, -2.4 * H, 0.9 * H},
                   .at = {0.5 * W, 0, 0.4 * H},
                   .angle = 36,
                   .ground = false});

    const auto simulate_until = [&](double time) {
      const auto last = std::min<std::uint64_t>(std::llround(time / options.dt), options.steps);
      if (last > world.steps()) world.simulate({.steps = last - world.steps(), .dt = options.dt});
    };
    double bulk = 0, before = 0, from = 0;  // measured on the way, and kept by checkpoints
    world.keep("bulk", bulk);
    world.keep("before", before);
    world.keep("from", from);
    simulate_until(time_open);
    double mass = 0;  // of the spheres in a slice above the outlet
    world.for_each_local([&](const auto& b) {
      const double z = b.position()[2];
      if (!b.is_fixed() && z > 2 * d && z < 8 * scale) mass += b.mass();
    });
    world.link().reduce(reduction::sum, std::span(&mass, 1));
    bulk = mass / (W * D * (8 * scale - 2 * d));
    world.destroy(gate);
    simulate_until(time_open + 1.5 * std::sqrt(scale));  // until the flow is steady
    before = fallen.total(world).mass, from = world.time();
    simulate_until(options.steps * options.dt);
    const auto [left, out] = fallen.total(world);
    const double flow = (out - before) / std::max(world.time() - from, options.dt);
    // Beverloo, Leniger, van de Velde 1961; constants for slots: Al-Din and Gunn 1984.
    const double law = 1.03 * bulk * std::sqrt(gravity) * D * std::pow(slot - 1.4 * d, 1.5);
    return results{{"mass_flow_rate", flow},
                   {"mass_flow_rate_beverloo", law},
                   {"bulk_density", bulk},
                   {"spheres_left", static_cast<double>(left)}};
  });
}
