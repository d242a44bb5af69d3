// A powder on a ledge: a block of grains loses its walls, and what does not fall off stays at its
// angle of repose. The angle grows with the Bond number, the pull-off force of two grains over
// their weight.
#include <talus/adhesion.hpp>
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/vtk.hpp>
using namespace talus;

using bench = scenario<bodies<sphere, plane, box>,
                       soft_contact<jkr_adhesion, coulomb_friction, rolling_resistance>,
                       decomposition<periodic<grid<dynamic, dynamic>, along::y>>,
                       transport<as_launched>, features<checkpoints, vtk_output>>;

struct powder_options : options {
  double bond = 0, size = 1;

  powder_options() { steps = 40000, dt = 2.5e-4; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--bond", bond, "number: pull-off force over weight of a grain", 0.0, 100.0);
    line.add("--size", size, "of the block", 0.5, 20.0);
  }
};

/// Angle of the surface in degrees: of the line through the highest grains of strips along x,
/// without the outermost ones.
double slope_of(const std::vector<double>& tops) {
  double n = 0, x = 0, z = 0, xx = 0, xz = 0;
  for (std::size_t k = 1; k + 1 < tops.size(); ++k) {
    const double at = static_cast<double>(k);
    n += 1, x += at, z += tops[k], xx += at * at, xz += at * tops[k];
  }
  return std::atan2(-(n * xz - x * z), n * xx - x * x) * 180 / pi;
}

int main(int argc, char** argv) {
  return run<bench, powder_options>(argc, argv, [](auto& world, const powder_options& options) {
    // Lengths in diameters of grains, times in sqrt(diameter / gravity), masses in those of grains.
    const double L = 20 * options.size, W = 5, H = 16 * options.size, fall = 0.6 * H;
    world.decompose({{.lower = {0, 0}, .upper = {2 * L, W}}});
    world.gravity({0, 0, -1});
    const double modulus = 2e4, radius = 0.5;
    const auto grain = world.material({.density = 6 / pi,
                                       .restitution = 0.3,
                                       .friction = 0.5,
                                       .youngs_modulus = modulus,
                                       .rolling_friction = 0.1});
    const auto wall = world.material({.friction = 0.5, .youngs_modulus = rigid});
    const jkr_adhesion::given sticky{options.bond / (1.5 * pi * 0.5 * radius)};
    world.interaction(grain, grain, sticky);
    world.interaction(grain, wall, jkr_adhesion::given{});
    world.interaction(wall, wall, jkr_adhesion::given{});
    world.global([&](auto& scope) {
      scope.add(plane{{1, 0, 0}, 0}, wall);
      scope.add(plane{{0, 0, 1}, -fall}, wall);
    });
    world.fill(
        simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0}} & box_region{{0, 0, -0.5}, {L, W, 0.5}},
        [&](const site& place, random_stream& random) {
          const vec3 bump(0, 0, random.uniform(-0.3, 0.));
          return body{.shape = sphere{radius},
                      .position = place.position + bump,
                      .material = grain,
                      .fixed = true};
        });
    world.fill(
        simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 1}} & box_region{{0, 0, 0.5}, {L, W, H}},
        [&](const site& place, random_stream& random) {
          return body{.shape = sphere{radius * random.uniform(0.85, 0.99)},
                      .position = place.position,
                      .material = grain,
                      .velocity = random.uniform(vec3(-0.1, -0.1, -0.1), vec3(0.1, 0.1, 0))};
        });
    take_pictures(world, options,
                  {.from = {L, -2.2 * L, 0.9 * L}, .at = {L, 0.5 * W, 0.1 * L}, .angle = 45});

    world.simulate({.steps = options.steps, .dt = options.dt});

    std::vector<double> tops(static_cast<std::size_t>(0.8 * L / 2), 0);
    double moving = 0, on_ledge = 0;
    world.for_each_local([&](const auto& b) {
      const vec3 at = b.position();
      if (b.is_fixed() || at[2] < 0) return;
      on_ledge += 1, moving = std::max(moving, b.velocity().norm());
      const auto strip = static_cast<std::size_t>(std::max(0.0, at[0]) / 2);
      if (strip < tops.size()) tops[strip] = std::max(tops[strip], at[2]);
    });
    world.link().reduce(reduction::max, std::span<double>(tops));
    world.link().reduce(reduction::max, std::span<double>(&moving, 1));
    world.link().reduce(reduction::sum, std::span<double>(&on_ledge, 1));
    return results{{"angle", slope_of(tops)}, {"grains_on_ledge", on_ledge}, {"fastest", moving}};
  });
}
