// POUR: a heap of spheres of many sizes falls and settles; with one of the solvers (--solver). The
// whole run is measured, since settled heaps cost less.
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "scenes/protocol.hpp"
#include "scenes/report.hpp"
#include "scenes/talus_engine.hpp"
#include "talus/observe/islands.hpp"
#include "talus/observe/penetration.hpp"
#include "talus/solver/coloured_gauss_seidel.hpp"

namespace {

/// Radii from `smallest` to `largest`, uniform, or lognormal with a deviation of 1/2.
bench::scene pour_scene(std::uint64_t bodies, double smallest, double largest, bool lognormal,
                        std::uint64_t seed) {
  bench::scene s;
  s.name = "POUR";
  s.density = 2500;
  s.gravity = -9.81;
  s.dt = 1.0 / 240;
  s.between_balls = s.against_fixed = {.friction = 0.5, .restitution = 0.2};
  const double side = 2 * largest * std::cbrt(static_cast<double>(bodies) / 4);
  const double spacing = 2.02 * largest;
  s.walls = {
      {{0, 0, 1}, 0}, {{1, 0, 0}, 0}, {{-1, 0, 0}, -side}, {{0, 1, 0}, 0}, {{0, -1, 0}, -side}};
  const auto row = static_cast<std::uint64_t>(side / spacing);
  for (std::uint64_t k = 0; k < bodies; ++k) {
    bench::dice random(seed, k);
    double radius = random.between(smallest, largest);
    if (lognormal) {
      do {
        const double normal = std::sqrt(-2 * std::log(1 - random.between(0, 1))) *
                              std::cos(2 * std::numbers::pi * random.between(0, 1));
        radius = std::sqrt(smallest * largest) * std::exp(0.5 * normal);
      } while (radius < smallest || radius > largest);
    }
    const auto at = [&](std::uint64_t i) { return spacing * (static_cast<double>(i) + 0.5); };
    s.balls.push_back({.position = {at(k % row), at(k / row % row), at(k / row / row)},
                       .radius = radius,
                       .velocity = {random.between(-0.5, 0.5), random.between(-0.5, 0.5), 0}});
  }
  return s;
}

template <class Solver>
void pour(bench::arguments args) {
  const auto bodies = args.count("bodies", 3000), steps = args.count("steps", 960);
  const double smallest = std::stod(args.text("smallest", "0.1"));
  const double largest = std::stod(args.text("largest", "0.5"));
  const bool lognormal = args.count("lognormal", 0) != 0;
  const auto seed = args.count("seed", 1);
  const auto file = args.text("json", "");
  if (!args.done()) return;
  const bench::scene s = pour_scene(bodies, smallest, largest, lognormal, seed);
  const std::string identity = bench::digest(s);
  using engine_type =
      bench::talus_engine_with<talus::bodies<talus::sphere, talus::plane>, talus::solver<Solver>>;
  engine_type engine(s);
  bench::stopwatch watch;
  double overlap = 0;
  int samples = 0;
  for (std::uint64_t k = 1; k <= steps; ++k) {
    watch.time([&] { engine.step(); });
    if (k % 24 == 0) overlap += talus::measure_penetration(engine.world()).mean, ++samples;
  }
  bench::record out;
  bench::add_common(out, s, engine, watch, identity);
  out.add("cpu_ms_per_step_longest", watch.longest());
  out.add("mean_overlap_of_run", samples > 0 ? overlap / samples : 0);
  out.add("islands_solved", static_cast<double>(talus::measure_islands(engine.world()).solved));
  out.add("islands_skipped", static_cast<double>(talus::measure_islands(engine.world()).skipped));
  out.add("steps", steps);
  out.add("seed", seed);
  bench::record::write_text(out.json(), file);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args(argc, argv);
    const auto solver = args.text("solver", "nonlinear_gauss_seidel");
    if (solver == "nonlinear_gauss_seidel")
      pour<talus::nonlinear_gauss_seidel>(args);
    else if (solver == "coloured_gauss_seidel")
      pour<talus::coloured_gauss_seidel>(args);
    else
      throw std::invalid_argument("there is no solver '" + solver + "'");
  });
}
