// A row of dominoes topples. The speed of the wave is compared with the theory of J. M. J. van
// Leeuwen, The domino effect, Am. J. Phys. 78, 721 (2010).
#include <talus/checkpoint.hpp>
#include <talus/mpi.hpp>
using namespace talus;

using domino = scenario<bodies<box, plane>, hard_contact<coulomb_friction>,
                        solver<nonlinear_gauss_seidel, reproducible>, decomposition<slabs<dynamic>>,
                        transport<as_launched>, features<user_ids, checkpoints>>;

struct domino_options : options {
  int dominoes = 40;
  double gap = 0.3, friction = 0;

  domino_options() {
    steps = 2200;
    dt = 0.002;
  }
  void describe(auto& line) {
    options::describe(line);
    line.add("--dominoes", dominoes, "number of dominoes", 20);
    line.add("--gap", gap, "between two of them, over their height", 0.05, 0.7);
    line.add("--friction", friction, "between two of them", 0.0, 1.0);
  }
};

/// Speed of the wave over sqrt(g h), far down the row. The dominoes of height 1 rotate about their
/// lower edge, lean on the next one without friction, and hit the one in front without rebound. The
/// angle of the first determines all others: the corner of a domino at angle b lies on the face of
/// the next at angle a if sin(b - a) = (s + d) cos a - d. Energy is conserved between impacts, and
/// the momentum conjugate to that angle in an impact.
double speed_without_friction(double s, double d) {
  const int parts = 100, dominoes = 40;
  const double inertia = (1 + d * d) / 3, contact = std::asin(s);
  // For n dominoes, the first at `angle`: sum of squares of speeds, momentum of the others with
  // respect to the front angle, and height, for unit speed of the first.
  const auto row = [&](double angle, int n) {
    double a = angle, speed = 1, behind = 1;
    vec3 sums{0, 0, 0};
    for (int k = 0; k < n; ++k) {
      sums +=
          vec3(speed * speed, k > 0 ? speed * behind : 0, 0.5 * (std::cos(a) + d * std::sin(a)));
      const double lean = std::asin((s + d) * std::cos(a) - d);
      const double gain = 1 - (s + d) * std::sin(a) / std::cos(lean);
      behind = k > 0 ? behind * gain : 1;
      speed *= gain, a += lean;
    }
    return sums;
  };
  double rate = 1, time = 0;
  for (int n = 1; n <= dominoes; ++n) {
    const auto at = [&](double angle) {
      const vec3 now = row(angle, n), first = row(0, n);
      return std::sqrt((first[0] * rate * rate + 2 / inertia * (first[2] - now[2])) / now[0]);
    };
    time = 0;
    for (int k = 0; k < parts; ++k) time += contact / parts / at((k + 0.5) * contact / parts);
    const vec3 struck = row(0, n + 1);
    rate = at(contact) * struck[1] / struck[0];
  }
  return (s + d) / time;
}

int main(int argc, char** argv) {
  return run<domino, domino_options>(argc, argv, [](auto& world, const domino_options& options) {
    const double h = 1, d = 0.179, w = 0.5, gravity = 9.81;  // d/h as McLachlan et al. measured
    const double pitch = options.gap * h + d, length = options.dominoes * pitch;

    world.decompose({.axis = {1, 0, 0}, .lower = 0, .upper = length});
    world.gravity({0, 0, -gravity});
    const auto floor = world.material({}), bone = world.material({});
    world.material_pair(floor, bone, {.friction = 2, .dynamic_friction = 2});
    world.material_pair(bone, bone,
                        {.friction = options.friction, .dynamic_friction = options.friction});
    world.global([&](auto& scope) { scope.add(plane{}, floor); });
    const double push = 1.5;  // angular velocity of the first domino about its lower edge
    for (int k = 0; k < options.dominoes; ++k)
      world.add_if_local(body{.shape = box{{d, w, h}},
                              .position = {k * pitch, 0, 0.5 * h},
                              .material = bone,
                              .velocity = k > 0 ? vec3(0, 0, 0) : push * vec3(h / 2, 0, d / 2),
                              .angular_velocity = {0, k > 0 ? 0 : push, 0},
                              .user_id = static_cast<std::uint32_t>(k)});
    world.synchronize();

    // Numbers of steps before a domino in the middle, and one near the end, falls.
    const std::array<int, 2> marked{options.dominoes / 2, options.dominoes - 6};
    std::array<std::uint64_t, 2> stood{};
    world.keep_sum("stood_first", stood[0]);
    world.keep_sum("stood_then", stood[1]);
    const auto uprightness = [](const auto& b) { return rotated(b.orientation(), {0, 0, 1})[2]; };
    world.after_each_step([&] {
      world.for_each_local([&](const auto& b) {
        for (std::size_t k = 0; k < 2; ++k)
          stood[k] += static_cast<int>(b.user_id()) == marked[k] && uprightness(b) > 0.999;
      });
    });
    take_pictures(world, options,
                  {.from = {0.85 * length, -0.34 * length, 0.2 * length},
                   .at = {0.49 * length, 0, 0},
                   .angle = 55});
    world.simulate({.steps = options.steps, .dt = options.dt});

    std::array<double, 3> sums{double(stood[0]), double(stood[1]), 0};
    world.for_each_local([&](const auto& b) { sums[2] += uprightness(b) < 0.5; });
    world.link().reduce(reduction::sum, sums);
    const double way = (marked[1] - marked[0]) * pitch;
    const double speed = way / (options.dt * std::max(sums[1] - sums[0], 1.0));
    const double theory = speed_without_friction(options.gap, d / h);
    return results{{"fallen", sums[2]},
                   {"speed", speed / std::sqrt(gravity * h)},
                   {"speed_without_friction", theory},
                   {"speed_to_theory", speed / std::sqrt(gravity * h) / theory}};
  });
}
