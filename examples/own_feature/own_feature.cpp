// Heat flows through the contacts of spheres: a bed on a hot plate; with --column N spheres on each
// other, of which the last one stays cold, with a known profile; with --pair two spheres that come
// to one temperature.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
#include <talus/vtk.hpp>

#include "heat.hpp"
using namespace talus;

using warm = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
                      solver<nonlinear_gauss_seidel, reproducible>,
                      decomposition<grid<dynamic, dynamic, dynamic>>, transport<as_launched>,
                      features<heat, checkpoints, vtk_output>>;

struct warm_options : options {
  int column = 0;
  bool pair = false, adiabatic = false;

  warm_options() { steps = 1000, dt = 0.002; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--column", column, "spheres on each other; 0: a bed", 0);
    line.add("--pair", pair, "two spheres on each other, on a plate that gives no heat");
    line.add("--adiabatic", adiabatic, "a bed on a plate that gives no heat");
  }
};

int main(int argc, char** argv) {
  return run<warm, warm_options>(argc, argv, [](auto& world, const warm_options& options) {
    const double hot = 400, cold = 300, r = 0.5;
    const int n = options.pair ? 2 : options.column;
    auto& of_heat = world.template feature<heat>();
    of_heat.hard_conductance = options.pair ? 1 : 5;
    world.decompose({.lower = {-2.5, -2.5, 0}, .upper = {2.5, 2.5, n > 0 ? 2 * r * n : 4}});
    world.gravity({0, 0, -10});
    const auto steel = world.material({.density = 1, .restitution = 0.2, .friction = 0.3});

    handle<plane> floor;
    world.global([&](auto& scope) {
      floor = scope.add(plane{{0, 0, 1}, 0}, steel);
      for (const vec3& normal : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
        scope.add(plane{normal, -2.5}, steel);
    });
    const auto keep = [](auto&& body, double at) {
      body.template set<temperature>(at);
      body.template set<reservoir>(1);
    };
    if (!options.pair && !options.adiabatic) keep(world[floor], hot);

    if (n > 0) {
      for (int k = 0; k < n; ++k)
        world.add_if_local(
            body{.shape = sphere{r}, .position = {0.25, 0.25, r + 2 * r * k}, .material = steel});
      world.for_each_local([&](auto&& ball) {
        const double z = ball.position()[2];
        if (options.pair)
          ball.template set<temperature>(z < 2 * r ? hot : cold);
        else if (z > 2 * r * (n - 1))
          keep(ball, cold);
      });
    } else {
      world.fill(simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} &
                     box_region{{-2.5, -2.5, 0}, {2.5, 2.5, 4}},
                 [&](const site& place, random_stream& random) {
                   return body{.shape = sphere{random.uniform(0.35, 0.49)},
                               .position = place.position,
                               .material = steel,
                               .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0))};
                 });
      if (options.adiabatic)
        world.for_each_local(
            [&](auto&& ball) { ball.template set<temperature>(cold + 20 * ball.position()[0]); });
    }

    const double before = thermal_energy(world);
    world.simulate({.steps = options.steps, .dt = options.dt});
    const double after = thermal_energy(world), given = heat_given(world);

    // What the profile of the column, or the difference of the pair, is off by.
    double off = 0;
    if (n > 0)
      world.for_each_local([&](const auto& ball) {
        const double k = std::round((ball.position()[2] - r) / (2 * r));
        double wanted = hot + (cold - hot) * (k + 1) / n;
        if (options.pair) {
          const double rate = 2 * of_heat.hard_conductance / (ball.mass() * of_heat.capacity);
          const double half = 0.5 * (hot - cold) * std::exp(-rate * world.time());
          wanted = 0.5 * (hot + cold) + (k == 0 ? half : -half);
        }
        off = std::max(off, std::abs(ball.template get<temperature>() - wanted));
      });
    world.link().reduce(reduction::max, std::span(&off, 1));
    return results{{"heat_given", given / before},
                   {"heat_lost", std::abs(after - before - given) / before},
                   {"temperature_error", off / (hot - cold)}};
  });
}
