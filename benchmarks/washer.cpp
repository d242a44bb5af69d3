// WASHER, a scene of Box3D's benchmark program: 8,000 cubes in a drum of hulls that turns about a
// horizontal axis and lifts them with four paddles. With one of the solvers (--solver); the whole
// run is measured.
#include <cmath>
#include <cstdint>
#include <string>
#include <talus/observe/force_balance.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "scenes/protocol.hpp"
#include "scenes/report.hpp"
#include "scenes/solver_choice.hpp"

namespace {

using namespace talus;

constexpr real height = 21;  ///< of the axis, which is parallel to y

/// The part of a ring about the axis between two radii and two angles, in degrees.
std::vector<vec3> segment(real inner, real outer, real from, real to) {
  std::vector<vec3> corners;
  for (const real degrees : {from, to})
    for (const real radius : {inner, outer})
      for (const real y : {-10.0, 10.0}) {
        const real angle = degrees * pi / 180;
        corners.push_back({radius * std::cos(angle), y, radius * std::sin(angle)});
      }
  return corners;
}

template <class Solver>
void wash(bench::arguments args) {
  using scene =
      scenario<bodies<box, convex_polyhedron>, solver<Solver>, transport<serial>, features<driven>>;
  const auto row = args.count("row", 20), steps = args.count("steps", 1000);
  const auto iterations = args.count("iterations", 10);
  const auto file = args.json_file();
  if (!args.done()) return;
  serial::link link;
  world<scene> w(link);
  w.solver().iterations = static_cast<int>(iterations);
  w.gravity({0, 0, -10});
  const auto m = w.material({.density = 1000, .restitution = 0, .friction = 0.6});
  const auto turn = turning{.about = {0, 0, height}, .axis = {0, 1, 0}, .speed = 25 * pi / 180};
  w.global([&](auto& scope) {
    const auto add = [&](const std::vector<vec3>& corners) {
      const convex_polyhedron hull(corners);
      const pose at = hull.frame();
      w.drive(scope.add(hull, m, at.position + vec3(0, 0, height), at.orientation), turn);
    };
    for (int k = 0; k < 36; ++k) {
      add(segment(16, 18, 10 * k - 1, 10 * k + 11));
      if (k % 9 == 0) add(segment(14, 16, 10 * k, 10 * k + 10));
    }
  });
  const auto place = [&](std::uint64_t k) {
    return 0.8 * (static_cast<double>(k) - 0.5 * static_cast<double>(row - 1));
  };
  for (std::uint64_t k = 0; k < row * row * row; ++k)
    w.add(body{.shape = box{{0.4, 0.4, 0.4}},
               .position = {place(k % row), place(k / row % row), place(k / row / row) + height},
               .material = m});
  bench::stopwatch watch;
  double overlap = 0;
  int samples = 0;
  for (std::uint64_t k = 1; k <= steps; ++k) {
    watch.time([&] { w.step(1.0 / 60); });
    if (k % 24 == 0) overlap += measure_penetration(w).mean, ++samples;
  }
  std::uint64_t inside = 0;
  w.for_each_local([&](const auto& b) {
    const vec3& x = b.position();
    inside += std::hypot(x[0], x[2] - height) < 16;
  });
  const penetration last = measure_penetration(w);
  bench::record out;
  out.add("engine", "talus");
  out.add("scene", "washer");
  out.add("bodies", row * row * row);
  out.add("inside", inside);
  out.add("dt", 1.0 / 60);
  out.add("steps", steps);
  out.add("iterations", iterations);
  out.add("cpu_seconds", 1e-3 * watch.mean() * static_cast<double>(steps));
  out.add("cpu_ms_per_step", watch.mean());
  out.add("cpu_ms_per_step_median", watch.median());
  out.add("cpu_ms_per_step_p99", watch.p99());
  out.add("cpu_ms_per_step_longest", watch.longest());
  out.add("mean_overlap_of_run", samples > 0 ? overlap / samples : 0);
  out.add("penetration_mean", last.mean);
  out.add("penetration_max", last.max);
  out.add("balance_unstopped", measure_force_balance(w).unstopped);
  out.write(file);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::main_with_solver(
      argc, argv, []<class Solver>(const bench::arguments& args) { wash<Solver>(args); });
}
