// A triaxial test. Three walls compact grains against the other three under one pressure; then the
// upper one moves down at a constant speed, and two hold their pressure. --csv FILE has the
// stress-strain curve, and docs/curve.py draws it.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/observe.hpp>
#include <talus/observe/force.hpp>
using namespace talus;

using triaxial =
    scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
             integrator<velocity_verlet>, decomposition<grid<dynamic, dynamic>>,
             transport<as_launched>, features<driven, checkpoints>>;

struct triaxial_options : options {
  double grains = 512, friction = 0.5, start_friction = 0, rate = 2.5e-3;
  std::string packing;

  triaxial_options() { steps = 25000, dt = 1.6e-3; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--grains", grains, "number of spheres, about", 50.0, 1e7);
    line.add("--friction", friction, "of the grains in the test", 0.0, 10.0);
    line.add("--start-friction", start_friction, "before; more makes a looser start", 0.0, 10.0);
    line.add_positive("--rate", rate, "of axial strain, which is also the inertial number");
    line.add("--packing", packing, "file for the compacted grains");
  }
};

int main(int argc, char** argv) {
  return run<triaxial, triaxial_options>(argc, argv, [](auto& world, const auto& options) {
    // The mean diameter, the density and the pressure are 1.
    const double spacing = 1.25, L = spacing * std::round(std::cbrt(options.grains));
    const vec3 ones(1, 1, 1);
    world.decompose({.lower = {0, 0}, .upper = {0.8 * L, 0.8 * L}});  // as it is compacted
    const auto stone = world.material({.density = 1, .stiffness = 400});
    const auto smooth = world.material({.stiffness = rigid});
    world.material_pair(stone, smooth, {.restitution = 0.1});
    world.material_pair(stone, stone, {.restitution = 0.1, .friction = options.start_friction});
    std::array<handle<plane>, 3> walls;
    world.global([&](auto& scope) {
      for (int k = 0; k < 3; ++k) {
        vec3 normal(0, 0, 0);
        normal[k] = 1;
        scope.add(plane{.normal = normal}, smooth);
        walls[k] = scope.add(plane{.normal = -normal, .offset = -L}, smooth);
      }
    });
    world.fill(simple_cubic{.spacing = spacing, .origin = 0.5 * spacing * ones} &
                   box_region{{0, 0, 0}, L * ones},
               [&](const site& place, random_stream& random) {
                 return body{.shape = sphere{random.uniform(0.4, 0.6)},
                             .position = place.position,
                             .material = stone,
                             .velocity = random.uniform(-0.1 * ones, 0.1 * ones)};
               });
    const auto size = [&](int axis) { return -world[walls[axis]].shape().offset; };
    const auto volume = [&] { return size(0) * size(1) * size(2); };
    const auto stress = [&](int axis) {
      return contact_force(world, walls[axis])[axis] * size(axis) / volume();
    };
    const auto lateral = [&] { return 0.5 * (stress(0) + stress(1)); };

    // A dense start, in equilibrium; then the friction of the test.
    for (const auto wall : walls) world.hold_force(wall, {.pressure = 1, .max_speed = 0.5});
    const auto at_rest = [&] { return lateral() > 0.98 && measure_residual(world).value < 1e-2; };
    world.simulate({.steps = 100000, .dt = options.dt, .stop_when = at_rest, .check_every = 200});
    const double H = world.once("height", [&] { return size(2); });
    const double V = world.once("volume", volume);
    if (!options.packing.empty())
      world.once("packing", [&] { write_packing(world, options.packing); });
    world.material_pair(stone, stone, {.restitution = 0.1, .friction = options.friction});

    world.drive(walls[2], gliding{{0, 0, -options.rate * H}});
    struct {
      double peak = 0, error = 0;     // largest friction angle, and error of the lateral stress
      double axial = 0, lateral = 0;  // means of the stresses, which fade over 3 % of strain
    } seen;
    world.keep("seen", seen);
    const auto angle = [](double s1, double s3) {
      return 180 / pi * std::asin((s1 - s3) / (s1 + s3));
    };
    world.observe("stress-strain curve", every{50}, [&](auto& w) {
      const double s1 = stress(2), s3 = lateral();
      w.record("axial_strain", 1 - size(2) / H), w.record("axial_stress", s1);
      w.record("lateral_stress", s3), w.record("volumetric_strain", 1 - volume() / V);
      w.record("friction_angle", angle(s1, s3));
      w.record("coordination", measure_coordination(w).mean);
      const double fading = seen.axial == 0 ? 0 : std::exp(-50 * options.dt * options.rate / 0.03);
      seen = {std::max(seen.peak, angle(s1, s3)), std::max(seen.error, std::abs(s3 - 1)),
              s1 + fading * (seen.axial - s1), s3 + fading * (seen.lateral - s3)};
    });
    world.simulate({.steps = options.steps, .dt = options.dt});
    const double solid = measure_motion(world).mass;
    return results{{"axial_strain", 1 - size(2) / H},
                   {"volumetric_strain", 1 - volume() / V},
                   {"solid_fraction_at_start", solid / V},
                   {"peak_friction_angle", seen.peak},
                   {"friction_angle", angle(seen.axial, seen.lateral)},
                   {"lateral_stress", seen.lateral},
                   {"lateral_error", seen.error},
                   {"inertial_number", options.rate * H / size(2)},
                   {"unbalanced_force", measure_residual(world).value},
                   {"coordination", measure_coordination(world).mean}};
  });
}
