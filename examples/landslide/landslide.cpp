// The landslide: spheres lie evenly on a tilted floor and slide into its lowest corner. The cuts
// between the domains of the ranks follow them (docs/balance.md).
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using landslide =
    scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<nonlinear_gauss_seidel, reproducible>,
             decomposition<bisection<dynamic>>,  // cuts that can move, for any number of ranks
             transport<as_launched>, features<balancing, checkpoints>>;

struct landslide_options : options {
  int spheres = 4000;
  std::string balance = "count";
  std::size_t balance_every = 100;
  double balance_above = 1.1;

  landslide_options() { steps = 1500; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--spheres", spheres, "number of spheres", 1);
    line.add("--balance", balance, "share out anew by count or by time, or never");
    line.add("--balance-every", balance_every, "steps from one look to the next", 1);
    line.add("--balance-above", balance_above, "largest share over the mean one that is left", 1);
    line.check([this] {
      if (balance != "time" && balance != "count" && balance != "never")
        throw usage_error("--balance must be time, count or never; see --help");
    });
  }
};

int main(int argc, char** argv) {
  return run<landslide, landslide_options>(argc, argv, [](auto& world, const auto& options) {
    const double spacing = 1.1;
    const double side = spacing * std::ceil(std::sqrt(options.spheres / 2.5));  // 2.5 layers

    world.decompose({.lower = {0, 0}, .upper = {side, side}});
    if (options.balance != "never")
      world.balance({.every = options.balance_every,
                     .above = options.balance_above,
                     .by = options.balance == "time" ? balance_by::time : balance_by::count});
    world.gravity({4, 3, -8});
    const auto stuff = world.material({.density = 1, .restitution = 0.2, .friction = 0.1});
    world.global([&](auto& scope) {
      scope.add(plane{}, stuff);
      for (const vec3& normal : {vec3(1, 0, 0), vec3(0, 1, 0)}) {
        scope.add(plane{.normal = normal}, stuff);
        scope.add(plane{.normal = -normal, .offset = -side}, stuff);
      }
    });
    const double first = 0.5 * spacing;
    world.fill((simple_cubic{.spacing = spacing, .origin = {first, first, first}} &
                box_region{{0, 0, 0}, {side, side, 100}})
                   .first(static_cast<std::uint64_t>(options.spheres)),
               [&](const site& place, random_stream& random) {
                 return body{.shape = sphere{random.uniform(0.4, 0.5)},
                             .position = place.position,
                             .material = stuff};
               });
    take_pictures(world, options,
                  {.from = {-0.4 * side, -0.7 * side, side}, .at = {0.6 * side, 0.6 * side, 0}});
    world.simulate({.steps = options.steps, .dt = options.dt});
  });
}
