// Grains lie in a shaft on a flap. A hinge carries the flap on one side; on the other it hangs by a
// rod from a latch that a weld holds. A heavy ball falls on the grains, the weld breaks, the flap
// swings down, and the grains fall through.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using trapdoor =
    scenario<bodies<sphere, box, plane>, joints<hinge, rod, weld>, hard_contact<coulomb_friction>,
             solver<nonlinear_gauss_seidel, reproducible>, decomposition<grid<dynamic, dynamic>>,
             transport<as_launched>, features<visibility, checkpoints>>;

struct trapdoor_options : options {
  int grains = 400;
  double strength = 12;

  trapdoor_options() { steps = 2400, dt = 0.0025; }
  void describe(auto& line) {
    options::describe(line);
    line.add("--grains", grains, "number of grains", 1);
    line.add_positive("--strength", strength,
                      "the force at which the weld breaks, over its share of the weight");
  }
};

int main(int argc, char** argv) {
  return run<trapdoor, trapdoor_options>(
      argc, argv, [](auto& world, const trapdoor_options& options) {
        const double W = 2, g = 9.81, high = 6;  // half the width of the shaft, gravity, its height
        world.decompose({.lower = {-W, -W}, .upper = {W, W}}, reach{4 * W});
        world.gravity({0, 0, -g});
        const auto stone = world.material({.density = 2.5, .friction = 0.4});
        const auto iron = world.material({.density = 8, .friction = 0.4});
        const auto glass = world.material({.density = 2.5});
        world.material_pair(stone, glass, {});  // the shaft bears no weight
        world.global([&](auto& scope) {
          scope.add(plane{.offset = -6}, stone);
          const box wall{{0.4, 2 * W + 0.8, high}};
          for (int k = 0; k < 4; ++k) {
            const quat q = rotation({0, 0, 1}, 0.5 * pi * k);
            const auto side = scope.add(wall, glass, rotated(q, {W + 0.2, 0, 0.5 * high}), q);
            world[side].set_visible(k != 3);  // the front
          }
        });
        const double thick = 0.2, arm = W + 0.4,
                     tip = W + 0.9;  // of the flap; its hinge, its free end
        const body plate{.shape = box{{arm + tip, 2 * W + 0.4, thick}},
                         .position = {0.5 * (tip - arm), 0, -0.5 * thick - 0.02},
                         .material = stone};
        const body clasp{.shape = box{{0.3, 0.3, 0.3}}, .position = {tip, 0, 2}, .material = stone};
        const auto flap = world.add_if_local(plate), latch = world.add_if_local(clasp);
        const vec3 edge(-arm, 0, -thick - 0.02), eye(tip, 0, -0.02);
        const auto pin = world.join(
            world_frame, flap,
            hinge{.at = edge, .axis = {0, 1, 0}, .limits = {.lower = -0.1, .upper = 0.5 * pi}});
        (void)world.join(latch, flap, rod{.from = clasp.position, .to = eye});

        const double r = 0.2, grain = 2.5 * sphere{r}.volume(), pitch = 2.2 * r;
        const double lid = 2.5 * plate.shape.volume(), bolt = 2.5 * clasp.shape.volume();
        const double load = 0.5 * lid + bolt + options.grains * grain * arm / (arm + tip);
        const auto seam =
            world.join(world_frame, latch,
                       weld{.at = clasp.position, .largest_force = options.strength * load * g});
        world.fill((simple_cubic{.spacing = pitch, .origin = {0, 0, 1.05 * r}} &
                    box_region{{-W + r, -W + r, 0}, {W - r, W - r, 1000}})
                       .first(options.grains),
                   [&](const site& place, random_stream& random) {
                     return body{.shape = sphere{r},
                                 .position = place.position +
                                             random.uniform(vec3(0, 0, 0), vec3(0.03, 0.03, 0.01)),
                                 .material = stone};
                   });
        take_pictures(world, options, {.from = {9, -24, 3}, .at = {0, 0, -1.2}, .angle = 38});

        const auto simulate_until = [&](double part) {
          const auto last = static_cast<std::uint64_t>(part * static_cast<double>(options.steps));
          if (last > world.steps())
            world.simulate({.steps = last - world.steps(), .dt = options.dt});
        };
        double borne = 0, held = 0, share = 0;
        world.keep("borne", borne), world.keep("held", held), world.keep("share", share);
        simulate_until(0.5);
        if (world.steps() == options.steps / 2) {
          const joint_reading carries = measure_joint(world, pin),
                              holds = measure_joint(world, seam);
          const double weight = (options.grains * grain + lid + bolt) * g;
          borne = -(carries.force + holds.force)[2] / weight, held = holds.exists;
          share = -holds.force[2] / (load * g);
          world.add_if_local(body{.shape = sphere{1},
                                  .position = {0, 0, high + 1},
                                  .material = iron,
                                  .velocity = {0, 0, -8}});
        }
        simulate_until(1);

        std::array<double, 1> through{};
        world.for_each_local([&](const auto& b) {
          if constexpr (requires { b.shape().radius; })
            through[0] += b.position()[2] < -0.5 && b.shape().radius == r;
        });
        world.link().reduce(reduction::sum, through);
        return results{{"weight_borne", borne},  // by hinge and weld, over the weight above
                       {"share_of_the_weld", share},
                       {"held", held},
                       {"broken", static_cast<double>(!measure_joint(world, seam).exists)},
                       {"grains_through", through[0]},
                       {"joint_gap", measure_joints(world).gap}};
      });
}
