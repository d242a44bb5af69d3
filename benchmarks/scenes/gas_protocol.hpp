#pragma once
// How an engine is measured on GAS.
#include <cmath>
#include <cstdint>

#include "checker.hpp"
#include "gas_scene.hpp"
#include "protocol.hpp"

namespace bench {

/// Besides cost and overlaps: how much of the energy is left, of which nothing should be lost.
template <class Engine>
void run_gas(arguments args) {
  const auto bodies = args.count("bodies", 8000);
  const auto settle = args.count("settle", 120);
  const auto measure = args.count("measure", 120);
  const auto iterations = args.count("iterations", 0);
  const auto seed = args.count("seed", 1);
  const auto file = args.json_file();
  if (!args.done()) return;

  const scene s = gas_scene(bodies, seed);
  Engine engine(s, static_cast<int>(iterations));
  for (std::uint64_t step = 0; step < settle; ++step) engine.step();
  if constexpr (requires { engine.start_measuring(); }) engine.start_measuring();
  stopwatch watch;
  for (std::uint64_t step = 0; step < measure; ++step) {
    if (step + 1 == measure) engine.watch_loads();
    watch.time([&] { engine.step(); });
  }

  record out;
  add_common(out, s, engine, watch);
  const double energy = kinetic_energy(engine.balls(), s.density).mean;
  out.add("energy_error", energy / kinetic_energy(s.balls, s.density).mean - 1);
  out.add("settle", settle);
  out.add("measure", measure);
  out.add("seed", seed);
  out.write(file);
}

}  // namespace bench
