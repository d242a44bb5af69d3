#pragma once
// How an engine is measured on POUR: the whole run, since settled heaps cost less.
#include <cstdint>
#include <string>

#include "checker.hpp"
#include "pour_scene.hpp"
#include "protocol.hpp"

namespace bench {

/// `add(engine, record)` adds what only one engine says of itself.
template <class Engine, class Add>
void run_pour(arguments args, Add&& add) {
  const auto bodies = args.count("bodies", 3000), steps = args.count("steps", 960);
  const double smallest = std::stod(args.text("smallest", "0.1"));
  const double largest = std::stod(args.text("largest", "0.5"));
  const bool lognormal = args.count("lognormal", 0) != 0;
  const auto iterations = args.count("iterations", 0);
  const auto seed = args.count("seed", 1);
  const auto file = args.json_file();
  if (!args.done()) return;
  const scene s = pour_scene(bodies, smallest, largest, lognormal, seed);
  const std::string identity = digest(s);
  Engine engine(s, static_cast<int>(iterations));
  stopwatch watch;
  double overlap = 0;
  int samples = 0;
  for (std::uint64_t k = 1; k <= steps; ++k) {
    if (k == steps) engine.watch_loads();
    watch.time([&] { engine.step(); });
    if (k % 24 == 0)
      overlap += check(engine.balls(), s.walls, s.blocks).penetration_mean, ++samples;
  }
  record out;
  add_common(out, s, engine, watch, identity);
  out.add("cpu_ms_per_step_p99", watch.p99());
  out.add("cpu_ms_per_step_longest", watch.longest());
  out.add("cpu_seconds", 1e-3 * watch.mean() * static_cast<double>(steps));
  out.add("mean_overlap_of_run", samples > 0 ? overlap / samples : 0);
  out.add("steps", steps);
  out.add("seed", seed);
  add(engine, out);
  out.write(file);
}
template <class Engine>
void run_pour(arguments args) {
  run_pour<Engine>(args, [](Engine&, record&) {});
}

}  // namespace bench
