// Flexible fibres, chains of bonded spheres, fall onto a floor and settle in a heap. With --swing
// one fibre, clamped at an end, swings in its first mode: its frequency is that of a beam.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/vtk.hpp>
#include <talus/world/bonds.hpp>
using namespace talus;

using heap = scenario<
    bodies<sphere, plane>,
    soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance, parallel_bond>,
    decomposition<grid<dynamic, dynamic>>, transport<as_launched>,
    features<checkpoints, vtk_output>>;

struct fibre_options : options {
  int fibres = 40, spheres = 12;
  double modulus = 1e8;
  bool swing = false;

  fibre_options() { steps = 60000, dt = 5e-6; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--fibres", fibres, "that fall", 1);
    line.add("--spheres", spheres, "of each fibre", 2);
    line.add("--modulus", modulus, "Young's modulus, Pa");
    line.add("--swing", swing, "a single fibre, clamped at an end, instead of a heap");
  }
};

/// A beam of round section, clamped at an end.
struct beam {
  double length, diameter, modulus, density;

  [[nodiscard]] double section() const { return pi / 4 * diameter * diameter; }
  static constexpr double first_root = 1.87510406871196;  // of cos x cosh x = -1
  /// Of its first mode (Timoshenko, Young, Weaver, Vibration Problems in Engineering, 5.11).
  [[nodiscard]] double frequency() const {
    const double second = pi / 64 * std::pow(diameter, 4);
    return first_root * first_root / (2 * pi) *
           std::sqrt(modulus * second / (density * section() * std::pow(length, 4)));
  }
  /// The shape of that mode, at a part of the length.
  [[nodiscard]] static double shape(double part) {
    const double k = first_root, x = k * part;
    const double ratio = (std::cos(k) + std::cosh(k)) / (std::sin(k) + std::sinh(k));
    return std::cosh(x) - std::cos(x) - ratio * (std::sinh(x) - std::sin(x));
  }
};

/// The fibre swings; its frequency follows from the times at which its end passes the middle.
results swing(auto& world, const fibre_options& options, double R, const beam& fibre,
              const parallel_bond::parameters& bond, double density) {
  const auto wood = world.material({.density = density, .stiffness = 500});
  const auto half = world.material({.density = density / 2, .stiffness = 500});
  for (const auto a : {wood, half})
    for (const auto b : {wood, half}) world.interaction(a, b, bond);
  const int last = options.spheres;
  for (int k = 0; k <= last; ++k) {
    const double part = static_cast<double>(k) / last;
    world.add_if_local(body{.shape = sphere{R},
                            .position = {2 * R * k, 0, 0},
                            .material = k == last ? half : wood,
                            .velocity = {0, 0, k == 0 ? 0 : 0.01 * beam::shape(part)},
                            .fixed = k == 0});
  }
  (void)bond_within(world, 1e-3 * R);
  double before = 0, first = 0, latest = 0;
  int passes = 0;
  world.observe(every{1}, [&](auto& w) {
    double now[1] = {0};
    w.for_each_local([&](const auto& b) {
      if (b.position()[0] > 2 * R * (last - 0.5)) now[0] = b.position()[2];
    });
    w.link().reduce(reduction::sum, std::span<double>(now));
    if (before > 0 && now[0] <= 0) {
      latest = w.time() - options.dt * now[0] / (now[0] - before);
      if (passes++ == 0) first = latest;
    }
    before = now[0];
  });
  world.simulate({.steps = options.steps, .dt = options.dt});
  const double found = passes > 1 ? (passes - 1) / (latest - first) : 0;
  return {{"frequency", found}, {"frequency_over_beam", found / fibre.frequency()}};
}

int main(int argc, char** argv) {
  return run<heap, fibre_options>(argc, argv, [](auto& world, const fibre_options& options) {
    // Metres, seconds, kilograms.
    const double R = 3.75e-3, length = 2 * R * options.spheres;
    const beam fibre{length, 0.75 * R, options.modulus, 420};
    // The spheres have the mass of the beam.
    const double density = fibre.density * fibre.section() * 2 * R / (4 * pi / 3 * R * R * R);
    const parallel_bond::parameters bond{.youngs_modulus = options.modulus,
                                         .poisson_ratio = 0.3,
                                         .radius_multiplier = 0.5 * fibre.diameter / R,
                                         .range = R,
                                         .damping_ratio = options.swing ? 0 : 0.05};
    const double side = 0.7 * length;
    world.decompose({.lower = {-side, -side}, .upper = {side, side}});
    if (options.swing) return swing(world, options, R, fibre, bond, density);

    world.gravity({0, 0, -9.81});
    const auto wood = world.material({.density = density,
                                      .restitution = 0.2,
                                      .friction = 0.4,
                                      .stiffness = 500,
                                      .rolling_friction = 0.02});
    world.interaction(wood, wood, bond);
    world.global([&](auto& scope) { scope.add(plane{}, wood); });
    // Four in a layer, layers across each other; every rank adds what it owns.
    random_stream random(options.seed, 1);
    for (int k = 0; k < options.fibres; ++k) {
      const double across = (k % 4 - 1.5) * 4 * R + random.uniform(-0.8, 0.8) * R;
      const double along = random.uniform(-0.5, 0.5) * length - 0.5 * length + R;
      for (int n = 0; n < options.spheres; ++n) {
        const double at = along + 2 * R * n, z = (2 + 2.5 * (k / 4)) * R;
        world.add_if_local(
            body{.shape = sphere{R},
                 .position = k / 4 % 2 == 0 ? vec3(at, across, z) : vec3(across, at, z),
                 .material = wood});
      }
    }
    const auto bonds = static_cast<double>(bond_within(world, 1e-6 * R));
    take_pictures(world, options,
                  {.from = {1.6 * length, -2.4 * length, 1.4 * length},
                   .at = {0, 0, 0.1 * length},
                   .angle = 32});
    // Mean height, number.
    const auto height = [&] {
      std::array<double, 2> sums{};
      world.for_each_local([&](const auto& b) { sums[0] += b.position()[2], sums[1] += 1; });
      world.link().reduce(reduction::sum, std::span<double>(sums));
      return sums[0] / sums[1];
    };
    const double before = height();
    world.simulate({.steps = options.steps, .dt = options.dt});
    const bond_count now = count_bonds(world);
    return results{{"bonds", bonds},
                   {"intact", static_cast<double>(now.intact)},
                   {"height", height() / before},
                   {"height_over_radius", height() / R}};
  });
}
