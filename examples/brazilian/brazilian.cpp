// A Brazilian test: a disc of bonded spheres is compressed across its diameter until it splits. The
// greatest load P gives the tensile strength 2 P / (pi D L). With --uniaxial a cylinder of the same
// rock is compressed along its axis: strength P / (pi R^2). --breaks FILE has the crack.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/observe/bond_breaks.hpp>
#include <talus/vtk.hpp>
using namespace talus;

using press = scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, parallel_bond>,
                       decomposition<grid<dynamic, dynamic>>, transport<as_launched>,
                       features<driven, checkpoints, vtk_output>>;

struct press_options : options {
  double radius = 25, length = 10.5, strength = 10;
  std::string breaks;
  bool uniaxial = false;

  press_options() { steps = 16000, dt = 1e-7; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--radius", radius, "of the disc, mm", 8.0, 500.0);
    line.add("--length", length, "of the disc, mm", 3.5, 500.0);
    line.add("--strength", strength, "of the bonds in tension, MPa");
    line.add("--uniaxial", uniaxial, "compression along the axis instead of across the diameter");
    line.add("--breaks", breaks, "file of comma-separated values for the bonds that break");
  }
};

/// A disc about the y axis with two flat ends, seen from the axis under 20 degrees each; or a
/// cylinder about the z axis. The load acts along z.
struct specimen {
  double radius = 0, length = 0;
  bool uniaxial = false;

  [[nodiscard]] double half_height() const { return uniaxial ? 0.5 * length : radius; }
  [[nodiscard]] bool contains(const vec3& at) const {
    if (uniaxial) return std::hypot(at[0], at[1]) < radius && std::abs(at[2]) < 0.5 * length;
    return std::hypot(at[0], at[2]) < radius && std::abs(at[2]) < std::cos(pi / 18) * radius &&
           std::abs(at[1]) <= 0.5 * length;
  }
};

int main(int argc, char** argv) {
  return run<press, press_options>(argc, argv, [](auto& world, const press_options& options) {
    // Millimetres, seconds, tonnes: forces in newtons, pressures in megapascals.
    const double R = options.radius, L = options.length, d = 3.5, modulus = 24e3;
    world.decompose({.lower = {-R, -R}, .upper = {R, R}});
    const auto rock =
        world.material({.density = 2.5e-9, .restitution = 0.3, .stiffness = modulus * d});
    const auto steel = world.material({.stiffness = rigid});
    world.interaction(rock, rock,
                      parallel_bond::parameters{.youngs_modulus = modulus,
                                                .poisson_ratio = 0.2,
                                                .range = 0.5 * d,
                                                .tensile_strength = options.strength,
                                                .shear_strength = 3 * options.strength,
                                                .weibull_modulus = 3,
                                                .damping_ratio = 0.1});
    world.interaction(rock, steel, parallel_bond::parameters{});
    // The places of a face-centred cubic lattice, shaken inside; the ends are ground flat. Every
    // rank draws the same numbers, and adds what it owns.
    const double half = 1.15 * d / std::sqrt(2.0);  // of the lattice constant
    const specimen whole{R, L, options.uniaxial};
    const double H = whole.half_height();
    const int most = static_cast<int>(std::max(R, H) / half) + 1,
              deep = options.uniaxial ? most : static_cast<int>(0.5 * L / half) + 1;
    const double ground = options.uniaxial ? (std::floor(H / half) - 0.5) * half : 0.85 * H;
    random_stream random(options.seed, 1);
    for (int x = -most; x <= most; ++x)
      for (int y = -deep; y <= deep; ++y)
        for (int z = -most; z <= most; ++z) {
          const vec3 site = half * vec3(x, y + 0.5, z);
          if ((x + y + z) % 2 != 0 || !whole.contains(site)) continue;
          const bool inside = std::abs(site[2]) < ground;
          const double size = inside ? random.uniform(0.8, 0.92) : 1;
          const vec3 shift = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
          world.add_if_local(body{.shape = sphere{0.5 * d * size},
                                  .position = site + (inside ? 0.08 * d : 0) * shift,
                                  .material = rock});
        }
    const std::uint64_t bonds = bond_within(world, 0.4 * d);
    // Plates that begin where the outermost spheres are.
    std::array<double, 2> ends{-1e9, -1e9};
    world.for_each_local([&](const auto& b) {
      ends[0] = std::max(ends[0], b.position()[2] + b.shape().radius);
      ends[1] = std::max(ends[1], -b.position()[2] + b.shape().radius);
    });
    world.link().reduce(reduction::max, std::span<double>(ends));
    handle<plane> upper, lower;
    world.global([&](auto& scope) {
      upper = scope.add(plane{{0, 0, -1}, -ends[0]}, steel);
      lower = scope.add(plane{{0, 0, 1}, -ends[1]}, steel);
    });
    const double speed = 0.8 * H;  // of each plate, mm/s
    world.drive(upper, gliding{{0, 0, -speed}});
    world.drive(lower, gliding{{0, 0, speed}});
    if (!options.breaks.empty()) record_breaks(world, options.breaks, every{20});
    take_pictures(world, options, {.from = {0, -5 * R, 0.6 * R}, .at = {0, 0, 0}, .angle = 30});

    double greatest = 0, uneven = 0;  // alike on all ranks
    world.keep("greatest load", greatest);
    world.keep("uneven", uneven);
    world.observe(every{20}, [&](auto& w) {
      const double up = contact_force(w, upper)[2], down = contact_force(w, lower)[2];
      if (std::abs(up) > greatest) greatest = std::abs(up), uneven = std::abs(up + down);
    });
    world.simulate({.steps = options.steps, .dt = options.dt});

    const bond_count left = count_bonds(world);
    const double strength =
        options.uniaxial ? greatest / (pi * R * R) : 2 * greatest / (pi * 2 * R * L);
    return results{{"load", greatest},
                   {options.uniaxial ? "compressive_strength" : "tensile_strength", strength},
                   {"strength_over_bonds", strength / options.strength},
                   {"bonds", static_cast<double>(bonds)},
                   {"broken", static_cast<double>(bonds - left.intact)},
                   {"broken_in_tension", static_cast<double>(left.tension)},
                   {"uneven", uneven / std::max(greatest, 1e-300)}};
  });
}
