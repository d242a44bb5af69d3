// One ball bounces on a floor: the first program of docs/first_hour.md.
#include <talus/talus.hpp>
using namespace talus;

using bounce = scenario<bodies<sphere, plane>, solver<nonlinear_gauss_seidel, reproducible>,
                        transport<serial>>;

int main(int argc, char** argv) {
  return run<bounce>(argc, argv, [](auto& world, const auto& options) {
    world.gravity({0, 0, -9.81});
    const auto rubber = world.material({.density = 1.1, .restitution = 0.8});
    world.global([&](auto& scope) { scope.add(plane{}, rubber); });
    const auto ball = world.add(sphere{0.5}, rubber, {0, 0, 1.5});
    double highest = 0;  // of the lowest point, from the first impact on
    bool touched = false;
    world.after_each_step([&] {
      const auto now = world[ball];
      touched = touched || now.velocity()[2] > 0;
      if (touched) highest = std::max(highest, now.position()[2] - 0.5);
    });
    world.simulate({.steps = options.steps, .dt = options.dt});
    return results{{"height", highest}};
  });
}
