// Newton's cradle: a row of equal spheres, each in its own harmonic well (a pendulum of small
// amplitude). The number of spheres drawn aside and released equals the number that swing out at
// the other end, equally far.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using cradle = scenario<bodies<sphere, plane>, hard_contact<newton_restitution>,
                        solver<nonlinear_gauss_seidel, reproducible>, decomposition<slabs<dynamic>>,
                        transport<as_launched>, features<forces, user_ids, checkpoints>>;

struct cradle_options : options {
  int spheres = 5, displaced = 1;
  double gap = 0.002;

  cradle_options() {
    steps = 20000;
    dt = 0.001;
  }
  void describe(auto& line) {
    options::describe(line);
    line.add("--spheres", spheres, "number of spheres", 2);
    line.add("--displaced", displaced, "of them drawn aside at the beginning", 1);
    line.add_positive("--gap", gap, "from one to the next at rest; more than a step's way");
  }
};

int main(int argc, char** argv) {
  return run<cradle, cradle_options>(argc, argv, [](auto& world, const cradle_options& options) {
    const double radius = 0.05, drawn = 0.15, length = 1, gravity = 9.81;  // m, of a pendulum
    const double frequency = std::sqrt(gravity / length), fastest = drawn * frequency;
    // If the spheres touch, all impacts are simultaneous and Newton's law has no unique solution:
    // energy and momentum are also conserved if all spheres move. With gaps larger than the motion
    // in a step, the spheres collide one after the other, and each pair exchanges its velocities.
    const double pitch = 2 * radius + options.gap, end = (options.spheres - 1) * pitch;
    world.decompose({.axis = {1, 0, 0}, .lower = -drawn, .upper = end + drawn});
    const auto steel = world.material({.density = 7800, .restitution = 1});
    world.global([&](auto& scope) { scope.add(plane{.offset = -1.5 * radius}, steel); });
    for (int k = 0; k < options.spheres; ++k)
      world.add_if_local(body{.shape = sphere{radius},
                              .position = {k * pitch - (k < options.displaced ? drawn : 0), 0, 0},
                              .material = steel,
                              .user_id = static_cast<std::uint32_t>(k)});
    world.synchronize();

    const auto pull_of = [=](const auto& b) -> vec3 {
      const vec3 rest{b.user_id() * pitch, 0, 0};
      return -frequency * frequency * (b.position() - rest);
    };
    const auto pull = [&] {
      world.for_each_local([&](auto& b) { b.add_force(b.mass() * pull_of(b)); });
    };
    pull();
    world.after_each_step(pull);
    take_pictures(world, options,
                  {.from = {0.5 * end, -1.1, 0.3}, .at = {0.5 * end, 0, 0}, .angle = 46});

    // The amplitude of a sphere follows from its position and velocity at any time (the velocity of
    // the scheme is that half a step before). Smallest of the last spheres, largest of the others;
    // energy.
    const auto swings = [&] {
      std::array<double, 2> least_and_most{-drawn, 0};
      double energy = 0;
      world.for_each_local([&](const auto& b) {
        const vec3 a = pull_of(b), v = b.velocity() + 0.5 * options.dt * a;
        const double swing = std::hypot(v.norm(), a.norm() / frequency) / frequency;
        const bool last = static_cast<int>(b.user_id()) >= options.spheres - options.displaced;
        auto& extreme = least_and_most[last ? 0 : 1];
        extreme = std::max(extreme, last ? -swing : swing);
        energy += b.mass() * swing * swing;
      });
      world.link().reduce(reduction::max, least_and_most);
      world.link().reduce(reduction::sum, std::span(&energy, 1));
      return std::array{-least_and_most[0] / drawn, least_and_most[1] / drawn, energy};
    };
    const auto simulate_until = [&](double time) {
      const auto last = std::min<std::uint64_t>(std::llround(time / options.dt), options.steps);
      if (last > world.steps()) world.simulate({.steps = last - world.steps(), .dt = options.dt});
    };
    std::array<double, 2> momentum{};  // before and after all impacts
    std::array<double, 3> out{};
    world.keep("momentum", momentum);
    world.keep("out", out);
    const double start = swings()[2], struck = 0.5 * pi / frequency;
    simulate_until(struck - options.gap / fastest);
    momentum[0] = measure_motion(world).momentum[0];
    simulate_until(struck + options.spheres * options.gap / fastest);
    momentum[1] = measure_motion(world).momentum[0];
    simulate_until(2 * struck);
    out = swings();
    simulate_until(options.steps * options.dt);
    return results{{"swing_of_last", out[0]},
                   {"swing_of_others", out[1]},
                   {"momentum_handed_on", momentum[1] / momentum[0]},
                   {"energy_kept", swings()[2] / start}};
  });
}
