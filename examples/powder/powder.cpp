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

  powder_options() { steps = 20000, dt = 2e-3; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--bond", bond, "number: pull-off force over weight of a grain", 0.0, 100.0);
    line.add("--size", size, "of the block", 0.5, 20.0);
  }
};

/// Angle of repose in degrees, of a slope from the edge of the ledge to the height at the wall:
/// without its top it is a triangle, and what is missing of the rectangle gives its width. Heights
/// are those of strips of this width.
double slope_of(const std::vector<double>& heights, double width) {
  double missing = 0;
  for (const double h : heights) missing += (heights[0] - h) * width;
  return std::atan2(0.5 * heights[0] * heights[0], std::max(missing, 0.0)) * 180 / pi;
}

int main(int argc, char** argv) {
  return run<bench, powder_options>(argc, argv, [](auto& world, const powder_options& options) {
    // Lengths in diameters of grains, times in sqrt(diameter / gravity), masses in those of grains.
    const double L = 20 * options.size, W = 5, H = 16 * options.size, fall = H;
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
                  {.from = {0.8 * L, -2.6 * L, 0.9 * L},
                   .at = {0.8 * L, 0.5 * W, 0},
                   .angle = 45,
                   .walls = 1});

    world.simulate({.steps = options.steps, .dt = options.dt});

    // Of each strip along the ledge the number of grains and the sum of their heights; of all the
    // number, and that of those on the ledge that move.
    constexpr std::size_t strips = 8;
    std::vector<double> sums(2 * strips + 2, 0);
    const double width = L / strips;
    world.for_each_local([&](const auto& b) {
      const vec3 at = b.position();
      if (b.is_fixed()) return;
      sums[2 * strips] += 1;
      if (at[2] < 0 || at[0] > L) return;
      const auto k = std::min(strips - 1, static_cast<std::size_t>(std::max(0.0, at[0]) / width));
      sums[k] += 1, sums[strips + k] += at[2], sums[2 * strips + 1] += b.velocity().norm() > 0.1;
    });
    world.link().reduce(reduction::sum, std::span<double>(sums));
    std::vector<double> heights;
    double stays = 0;
    for (std::size_t k = 0; k < strips; ++k) {
      stays += sums[k];
      heights.push_back(sums[k] > 0 ? 2 * sums[strips + k] / sums[k] : 0);
    }
    return results{{"angle", slope_of(heights, width)},
                   {"part_on_ledge", stays / sums[2 * strips]},
                   {"part_moving", sums[2 * strips + 1] / sums[2 * strips]}};
  });
}
