// Ragdolls fall onto each other in a pit: bodies of capsules with ball joints, and with hinges that
// have limits. Nothing explodes: energy never grows, and no joint opens.
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using ragdolls =
    scenario<bodies<capsule, sphere, plane>, joints<ball_joint, hinge>,
             hard_contact<coulomb_friction>, solver<nonlinear_gauss_seidel, reproducible>,
             decomposition<grid<dynamic, dynamic>>, transport<as_launched>,
             features<energy_ledger, checkpoints>>;

struct ragdoll_options : options {
  int ragdolls = 32;

  ragdoll_options() { steps = 1500, dt = 0.002; }  // metres, seconds
  void describe(auto& line) {
    options::describe(line);
    line.add("--ragdolls", ragdolls, "number of ragdolls, of ten bodies each", 1);
  }
};

/// Adds a ragdoll whose chest lies at `at`, with arms and legs stretched out.
void add_ragdoll(auto& world, material_id flesh, const pose& at) {
  const auto add = [&](const auto& shape, const vec3& where, const quat& turn = {1, 0, 0, 0}) {
    return world.add_if_local(body{.shape = shape,
                                   .position = at.to_world(where),
                                   .material = flesh,
                                   .orientation = (at.orientation * turn).normalized()});
  };
  const auto chest = add(capsule{0.14, 0.36}, {0, 0, 0});
  const auto head = add(sphere{0.12}, {0, 0, 0.45});
  (void)world.join(chest, head, ball_joint{.at = at.to_world({0, 0, 0.33})});
  for (const double side : {-1, 1}) {
    // Two parts of these lengths, from a point of the chest, that bend about `axis`.
    const auto limb = [&](const vec3& from, const vec3& along, double radius, double length,
                          const vec3& axis) {
      const quat turn = rotation({0, 1, 0}, along[0] * 0.5 * pi);
      const auto part = [&](double r, double middle) {
        return add(capsule{r, length - radius}, from + middle * along, turn);
      };
      const auto upper = part(radius, 0.5 * length), lower = part(0.9 * radius, 1.5 * length);
      (void)world.join(chest, upper, ball_joint{.at = at.to_world(from)});
      (void)world.join(upper, lower,
                       hinge{.at = at.to_world(from + length * along),
                             .axis = rotated(at.orientation, axis),
                             .limits = {.lower = 0, .upper = 2.3}});
    };
    limb({side * 0.2, 0, 0.2}, {side, 0, 0}, 0.06, 0.3, {0, 0, side});
    limb({side * 0.1, 0, -0.3}, {0, 0, -1}, 0.08, 0.42, {-1, 0, 0});
  }
}

int main(int argc, char** argv) {
  return run<ragdolls,
             ragdoll_options>(argc, argv, [](auto& world, const ragdoll_options& options) {
    const int row = std::max(2, static_cast<int>(std::lround(std::sqrt(options.ragdolls) / 4)));
    const double g = 9.81, pitch = 2.5, W = 0.5 * pitch * row + 0.1;  // room of one, of the pit
    world.decompose({.lower = {-W, -W}, .upper = {W, W}});
    world.gravity({0, 0, -g});
    const auto flesh = world.material({.density = 1000, .friction = 0.5});
    world.global([&](auto& scope) {
      scope.add(plane{}, flesh);
      for (const double side : {-1, 1}) {
        scope.add(plane{.normal = {-side, 0, 0}, .offset = -W}, flesh);
        scope.add(plane{.normal = {0, -side, 0}, .offset = -W}, flesh);
      }
    });
    random_stream random(options.seed, 0);
    const auto place = [&](int k) {
      return vec3(pitch * (k % row - 0.5 * (row - 1)), pitch * (k / row % row - 0.5 * (row - 1)),
                  1.3 + pitch * (k / row / row));
    };
    for (int k = 0; k < options.ragdolls; ++k)
      add_ragdoll(world, flesh, {place(k), random.rotation()});
    take_pictures(world, options,
                  {.from = {0.5 * W, -4 * W, 2.5 * W}, .at = {0, 0, 0.6}, .angle = 40});

    const double top = place(options.ragdolls - 1)[2] + 1.2;
    std::array<double, 4> most{};  // speed, gap, energy over that at the start, its gain in a step
    world.keep("most", most);
    double first = 0;
    world.before_simulating([&] { first = measure_energy(world).initial; });
    world.observe(every{5}, [&](auto& w) {
      const energy_balance e = measure_energy(w);
      most[0] = std::max(most[0], measure_motion(w).max_speed);
      most[1] = std::max(most[1], measure_joints(w).gap);
      most[2] = std::max(most[2], (e.kinetic + e.potential) / first);
      most[3] = std::max(most[3], e.worst);
    });
    world.simulate({.steps = options.steps, .dt = options.dt});
    const joint_errors joints = measure_joints(world);
    return results{{"joints", static_cast<double>(joints.joints)},
                   {"speed", most[0] / std::sqrt(2 * g * top)},  // over that of a fall from the top
                   {"gap", most[1]},
                   {"energy", most[2]},
                   {"ledger", most[3]}};
  });
}
