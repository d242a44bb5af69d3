#pragma once
// How an engine is measured on a pyramid of many rows, from its start: whether it stands, and at
// what cost.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "crate_checker.hpp"
#include "protocol.hpp"
#include "small_scenes.hpp"

namespace bench {

/// `count` pyramids of boxes of density 100 beside each other, in a square.
inline scene pyramids_scene(std::size_t rows, std::size_t count, double rate) {
  const scene one = pyramid_scene(rows);
  scene s = one;
  s.name = "pyramids";
  s.dt = 1 / rate;
  s.density = 100;
  s.crates.clear();
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  for (std::size_t k = 0; k < count; ++k)
    for (crate c : one.crates) {
      c.density = s.density;
      c.centre[0] += static_cast<double>((k % side) * (rows + 2));
      c.centre[1] += static_cast<double>((k / side) * 4);
      s.crates.push_back(c);
    }
  return s;
}

/// Simulates `seconds`; the cost is the mean over all steps, those of the start included. Lengths
/// are in edges of a box.
template <class Engine>
void run_pyramid(arguments args) {
  const auto rows = args.count("rows", 100);
  const auto rate = args.count("rate", 60);
  const auto seconds = args.count("seconds", 20);
  const auto iterations = args.count("iterations", 0);
  const auto count = args.count("count", 1);
  const auto file = args.json_file();
  if (!args.done()) return;
  if (rows == 0 || rate == 0 || seconds == 0 || count == 0)
    throw std::invalid_argument("--rows, --rate, --seconds and --count need to be at least 1");

  const scene s = pyramids_scene(rows, count, static_cast<double>(rate));
  Engine engine(s, static_cast<int>(iterations));
  stopwatch watch;
  for (std::uint64_t i = 0; i < seconds * rate; ++i) watch.time([&] { engine.step(); });

  const auto crates = engine.crates();
  const auto found = check(crates, s.walls);
  const std::size_t each = s.crates.size() / count;  // its top is the last of a pyramid
  double moved = 0, top = 0;
  for (std::size_t i = 0; i < crates.size(); ++i) {
    const double way = norm(minus(crates[i].centre, s.crates[i].centre));
    const auto grow = [&](double& most) { most = way > most || !std::isfinite(way) ? way : most; };
    grow(moved);
    if (i % each + 1 == each) grow(top);
  }
  record out;
  out.add("engine", Engine::name());
  out.add("rows", rows);
  out.add("rate", rate);
  out.add("iterations", engine.iterations());
  out.add("cpu_seconds_per_simulated_second", 1e-3 * watch.mean() * static_cast<double>(rate));
  out.add("top_drift", top);
  out.add("moved_max", moved);
  out.add("penetration_mean", found.mean);
  out.add("penetration_max", found.max);
  out.add("count", count);
  out.add("bodies", s.crates.size());
  out.add("contacts", engine.contacts());
  out.add("seconds", seconds);
  out.add("cpu_ms_per_step_median", watch.median());
  out.add("cpu_ms_per_step_longest", watch.longest());
  out.add("scene_digest", digest(s));
  out.write(file);
}

}  // namespace bench
