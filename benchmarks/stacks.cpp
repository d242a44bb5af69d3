// STACKS: separate stacks of three cubes fall by 5 mm and come to rest, each an island of its own.
// With one of the solvers (--solver); the whole run is measured. --together 1: only the lowest cube
// has a gap beneath it, so each stack falls as one.
#include <cmath>
#include <cstdint>
#include <string>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

#include "scenes/protocol.hpp"
#include "scenes/report.hpp"
#include "scenes/solver_choice.hpp"

namespace {

using namespace talus;

template <class Solver>
void drop(bench::arguments args) {
  using scene = scenario<bodies<box, plane>, solver<Solver>, transport<serial>>;
  constexpr real side = 0.5, fall = 0.005;
  const auto stacks = args.count("stacks", 10000), steps = args.count("steps", 60);
  const auto iterations = args.count("iterations", 10), seed = args.count("seed", 1);
  const bool together = args.count("together", 0) != 0;
  // The largest component of velocities at the start, in mm/s and in mrad/s.
  const auto speed = 1e-3 * static_cast<double>(args.count("speed", 10));
  const auto file = args.json_file();
  if (!args.done()) return;
  serial::link link;
  world<scene> w(link);
  w.solver().iterations = static_cast<int>(iterations);
  w.gravity({0, 0, -9.81});
  const auto m = w.material({.density = 1000, .restitution = 0, .friction = 0.5});
  w.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, 1}, .offset = 0}, m); });
  const auto row = static_cast<std::uint64_t>(std::ceil(std::sqrt(static_cast<double>(stacks))));
  for (std::uint64_t n = 0; n < stacks; ++n) {
    bench::dice random(seed, n);
    const auto small = [&] { return random.between(-speed, speed); };
    const auto any = [&] { return vec3(small(), small(), small()); };
    for (int k = 0; k < 3; ++k) {
      const vec3 at(2 * side * static_cast<real>(n % row), 2 * side * static_cast<real>(n / row),
                    (k + 0.5) * side + (together ? 1 : k + 1) * fall);
      w.add(body{.shape = box{{side, side, side}},
                 .position = at,
                 .material = m,
                 .velocity = any(),
                 .angular_velocity = any()});
    }
  }
  bench::stopwatch watch;
  for (std::uint64_t k = 0; k < steps; ++k) watch.time([&] { w.step(1.0 / 240); });
  const penetration last = measure_penetration(w);
  bench::record out;
  out.add("engine", "talus");
  out.add("scene", "stacks");
  out.add("bodies", 3 * stacks);
  out.add("together", together ? 1 : 0);
  out.add("steps", steps);
  out.add("iterations", iterations);
  out.add("cpu_us_per_body_and_step", 1e3 * watch.mean() / static_cast<double>(3 * stacks));
  out.add("cpu_ms_per_step_median", watch.median());
  out.add("cpu_ms_per_step_longest", watch.longest());
  out.add("longest_over_median", watch.longest() / watch.median());
  out.add("penetration_mean", last.mean);
  out.add("penetration_max", last.max);
  out.write(file);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::main_with_solver(
      argc, argv, []<class Solver>(const bench::arguments& args) { drop<Solver>(args); });
}
