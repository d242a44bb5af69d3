// A long agglomerate over five domains (pe tutorial, figure 10). Its centre is in the third domain,
// its ends are in the first and the last, where spheres hit it from both sides and make it rotate.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using clump = union_of<sphere>;
using agglomerate =
    scenario<bodies<sphere, clump>,
             hard_contact<coulomb_friction, newton_restitution, no_correction>,
             solver<nonlinear_gauss_seidel, reproducible>, decomposition<slabs<dynamic>>,
             transport<as_launched>, features<checkpoints>>;

struct agglomerate_options : options {
  int grains = 25;  // spheres of the agglomerate
  int hits = 6;     // spheres that hit it at each end

  agglomerate_options() { steps = 1000; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--grains", grains, "spheres of the agglomerate", 2);
    line.add("--hits", hits, "spheres that hit it at each end", 0);
  }
};

int main(int argc, char** argv) {
  return run<agglomerate, agglomerate_options>(
      argc, argv, [](auto& world, const agglomerate_options& options) {
        const double L = 9.4, gap = L / (options.grains - 1), r = 0.4;  // of the row of centres
        world.decompose({.lower = -5, .upper = 5}, reach{0.5 * L + 2 * r});
        const auto stuff = world.material({.density = 1, .restitution = 0.5, .friction = 0.3});

        std::vector<clump::part> grains;
        for (int k = 0; k < options.grains; ++k)
          grains.push_back({sphere{k % 2 == 0 ? r : 0.8 * r}, {{k * gap - 0.5 * L, 0, 0}}, 0.25});
        const clump shape(grains);
        const pose at = placed(shape);
        world.add_if_local(body{.shape = shape,
                                .position = at.position,
                                .material = stuff,
                                .orientation = at.orientation});
        for (const int side : {-1, 1})
          for (int k = 0; k < options.hits; ++k)
            world.add_if_local(body{.shape = sphere{r},
                                    .position = side * vec3(4.6 - 0.05 * k, -2 - 1.1 * k, 0.1),
                                    .material = stuff,
                                    .velocity = side * vec3(0, 3, 0)});
        world.synchronize();
        const motion before = measure_motion(world);
        take_pictures(world, options,
                      {.from = {0, -12, 14}, .at = {0, 0, 0}, .angle = 50, .ground = false});
        world.simulate({.steps = options.steps, .dt = options.dt});

        const motion after = measure_motion(world);
        std::array<double, 2> sums{};  // spin of the agglomerate, ranks with a copy of it
        world.for_each_known([&](const auto& b) {
          if constexpr (requires { b.shape().parts(); }) {
            ++sums[1];
            if (!b.is_remote()) sums[0] += b.angular_velocity()[2];
          }
        });
        world.link().reduce(reduction::sum, sums);
        const double came = 2 * options.hits * 3 * sphere{r}.volume();  // momentum of the spheres
        return results{
            {"spin", sums[0]},
            {"ranks_that_know_it", sums[1]},
            {"momentum_lost", (after.momentum - before.momentum).norm() / came},
            {"angular_momentum_lost",
             (after.angular_momentum - before.angular_momentum).norm() / (0.5 * L * came)}};
      });
}
