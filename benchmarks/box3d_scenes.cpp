// Two scenes of Box3D's benchmark program (--scene): joint_grid, 100 x 100 spheres that hang by
// ball joints, and large_world, a floor of 1000 x 1000 boxes on which 100 spheres drop one by one.
// Every step counts but the first.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <talus/constraint/ball_joint.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "scenes/protocol.hpp"
#include "scenes/report.hpp"

namespace {

using namespace talus;

constexpr std::uint64_t rate = 60;

/// Writes what all scenes have in common.
void write(bench::record& out, const std::string& scene, std::uint64_t bodies, std::uint64_t steps,
           const bench::stopwatch& watch, const std::string& file) {
  out.add("engine", "talus");
  out.add("scene", scene);
  out.add("bodies", bodies);
  out.add("steps", steps);
  out.add("rate", rate);
  out.add("cpu_seconds_per_simulated_second", 1e-3 * watch.mean() * static_cast<double>(rate));
  out.add("cpu_ms_per_step_median", watch.median());
  out.add("cpu_ms_per_step_longest", watch.longest());
  out.write(file);
}

/// The lower end is written as its drift, from where the exact grid stays at rest.
void hang(std::uint64_t side, std::uint64_t steps, const std::string& file) {
  using scene = scenario<bodies<sphere>, joints<ball_joint>, transport<serial>>;
  serial::link link;
  world<scene> w(link);
  w.gravity({0, 0, -10});
  const auto m = w.material({.density = 1000, .friction = 0.6});
  std::vector<handle<sphere>> all;
  const auto n = static_cast<int>(side);
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < n; ++i) {
      const vec3 at(k, 0, -i);
      const auto h =
          w.add(body{.shape = sphere{0.4}, .position = at, .material = m, .fixed = i == 0});
      if (i > 0) {
        w.join(all.back(), h, ball_joint{.at = at + vec3(0, 0, 0.5)});
        if (k > 0) w.join(all[all.size() - side], h, ball_joint{.at = at - vec3(0.5, 0, 0)});
      }
      all.push_back(h);
    }
  bench::stopwatch watch;
  w.step(1.0 / rate);
  for (std::uint64_t k = 1; k < steps; ++k) watch.time([&] { w.step(1.0 / rate); });
  double drift = 0;
  for (int k = 0; k < n; ++k)
    drift = std::max(
        drift,
        (w[all[static_cast<std::size_t>(k * n + n - 1)]].position() - vec3(k, 0, 1 - n)).norm());
  bench::record out;
  out.add("top_drift", drift);
  out.add("penetration_max", 0.0);
  write(out, "joint_grid", side * side, steps, watch, file);
}

void drop(std::uint64_t side, std::uint64_t steps, bool global, const std::string& file) {
  using scene = scenario<bodies<sphere, box>, transport<serial>>;
  constexpr real cell = 10;
  constexpr int spheres = 100, across = 10, interval = 5;
  serial::link link;
  world<scene> w(link);
  w.gravity({0, 0, -10});
  const auto m = w.material({.density = 1000, .friction = 0.6});
  const auto n = static_cast<int>(side);
  const real half = cell * n / 2;
  const auto pave = [&](auto&& add) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        add(body<box>{.shape = box{{cell, cell, 0.5}},
                      .position = {cell * (i + 0.5) - half, cell * (j + 0.5) - half, 0},
                      .material = m,
                      .fixed = !global});
  };
  if (global)
    w.global([&](auto& scope) { pave([&](const auto& b) { scope.add(b); }); });
  else
    pave([&](const auto& b) { w.add(b); });
  bench::stopwatch watch;
  w.step(1.0 / rate);
  int dropped = 0;
  for (std::uint64_t k = 1; k < steps; ++k) {
    watch.time([&] {
      if (k % interval == 0 && dropped < spheres) {
        const auto place = [&](int at) { return half * 1.6 * ((at + 0.5) / across - 0.5); };
        w.add(body{.shape = sphere{0.5},
                   .position = {place(dropped % across), place(dropped / across), 1.5},
                   .material = m});
        ++dropped;
      }
      w.step(1.0 / rate);
    });
  }
  double lowest = 0;
  w.for_each_local([&](const auto& b) {
    if (!b.is_fixed()) lowest = std::min(lowest, b.position()[2] - 0.75);
  });
  bench::record out;
  out.add("floor", global ? "global" : "fixed");
  out.add("penetration_max", 0 - lowest);
  write(out, "large_world", side * side + spheres, steps, watch, file);
}

}  // namespace

int main(int argc, char** argv) {
  return bench::guarded([&] {
    bench::arguments args{argc, argv};
    const auto scene = args.text("scene", "large_world"), floor = args.text("floor", "global");
    const bool grid = scene == "joint_grid";
    const auto side = args.count("side", grid ? 100 : 1000);
    const auto steps = args.count("steps", grid ? 100 : 500);
    const auto file = args.text("json", "");
    if (!args.done()) return;
    if ((scene != "joint_grid" && scene != "large_world") || side < 2 || steps < 2)
      throw std::invalid_argument(
          "--scene is joint_grid or large_world; --side and --steps are at least 2");
    if (floor != "global" && floor != "fixed")
      throw std::invalid_argument("--floor is global or fixed");
    grid ? hang(side, steps, file) : drop(side, steps, floor == "global", file);
  });
}
