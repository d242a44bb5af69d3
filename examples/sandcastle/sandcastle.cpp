// A castle of sand on a beach: dry it collapses, wet it stands. The liquid belongs to the grains,
// as films and as bridges between them, and none of it is lost. With --column 1 it is a plain
// column, whose spreading is compared with its height.
#include <talus/checkpoint.hpp>
#include <talus/liquid.hpp>
#include <talus/mpi.hpp>
#include <talus/vtk.hpp>
using namespace talus;

using beach = scenario<bodies<sphere, plane>,
                       soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance,
                                    from_films<willett_bridge>>,
                       decomposition<grid<dynamic, dynamic>>, transport<as_launched>,
                       features<surface_liquid, checkpoints, vtk_output>>;

struct beach_options : options {
  double liquid = 4, size = 1;
  bool column = false;

  beach_options() { steps = 12000, dt = 1e-5; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--liquid", liquid, "per cent of the volume of the grains; 0: dry", 0.0, 20.0);
    line.add("--size", size, "of the castle", 0.4, 10.0);
    line.add("--column", column, "a plain column instead of a castle");
  }
};

/// Four towers with walls between them, or a column, of some size. Lengths of size 1 are in
/// millimetres.
struct castle {
  double size = 1;
  bool column = false;

  [[nodiscard]] double half_width() const { return size * (column ? 2.5 : 7); }
  [[nodiscard]] bool contains(const vec3& at) const {
    const double x = std::abs(at[0]) / size, y = std::abs(at[1]) / size, z = at[2] / size;
    if (column) return std::hypot(x, y) < 2.5;
    const auto wall = [z](double across, double along) {
      const bool merlon = std::abs(std::remainder(along, 2)) < 0.5;
      return std::abs(across - 5) < 1 && along < 5 && z < (merlon ? 5.5 : 4.5);
    };
    return std::hypot(x - 5, y - 5) < 2 || wall(x, y) || wall(y, x);
  }
};

int main(int argc, char** argv) {
  return run<beach, beach_options>(argc, argv, [](auto& world, const beach_options& options) {
    // Millimetres, seconds, kilograms: forces in millinewtons, pressures in kilopascals.
    const castle sand{options.size, options.column};
    const double reach = 3 * sand.half_width(), largest = 0.25;
    world.decompose({.lower = {-reach, -reach}, .upper = {reach, reach}});
    world.gravity({0, 0, -9810});
    const auto quartz = world.material({.density = 2.65e-6,
                                        .restitution = 0.5,
                                        .friction = 0.5,
                                        .stiffness = 20,
                                        .rolling_friction = 0.05});
    const willett_bridge::parameters water{.tension = 0.072,
                                           .angle = 0.1,
                                           .volume = 0.03 * largest * largest * largest,
                                           .viscosity = 1e-6};
    world.interaction(quartz, quartz, water);
    world.global([&](auto& scope) { scope.add(plane{}, quartz); });
    world.fill(
        face_centred_cubic{.spacing = 2 * std::sqrt(2.0) * largest, .origin = {0, 0, largest}} &
            box_region{{-sand.half_width(), -sand.half_width(), 0},
                       {sand.half_width(), sand.half_width(), 9 * sand.size}} &
            sand,
        [&](const site& place, random_stream& random) {
          return body{.shape = sphere{largest * random.uniform(0.9, 1)},
                      .position = place.position,
                      .material = quartz};
        });
    world.for_each_local([&](auto&& grain) {
      grain.template set<liquid>(options.liquid / 100 * grain.shape().volume());
    });
    take_pictures(world, options,
                  {.from = {-22 * options.size, -34 * options.size, 22 * options.size},
                   .at = {0, 0, 2 * options.size},
                   .angle = 36});

    // Mean height and mean square of the distance from the axis, number of grains.
    const auto measure = [&] {
      std::array<double, 3> sums{};
      world.for_each_local([&](const auto& grain) {
        const vec3 at = grain.position();
        sums[0] += at[2], sums[1] += at[0] * at[0] + at[1] * at[1], sums[2] += 1;
      });
      world.link().reduce(reduction::sum, std::span<double>(sums));
      return std::array{sums[0] / sums[2], std::sqrt(sums[1] / sums[2]), sums[2]};
    };
    const auto before = measure();
    const double poured = total_liquid(world).total();
    world.simulate({.steps = options.steps, .dt = options.dt});
    const auto after = measure();
    const liquid_content water_now = total_liquid(world);
    return results{{"height", after[0] / before[0]},
                   {"spread", after[1] / before[1]},
                   {"bridges_per_grain", static_cast<double>(water_now.count) / after[2]},
                   {"liquid_in_bridges", poured > 0 ? water_now.bridges / poured : 0},
                   {"liquid_lost", poured > 0 ? std::abs(water_now.total() / poured - 1) : 0}};
  });
}
