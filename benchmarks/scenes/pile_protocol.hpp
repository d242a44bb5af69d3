#pragma once
// How an engine is measured on PILE: settled afresh or from a file, with one number of iterations
// or with several, one after the other.
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "checker.hpp"
#include "pile_scene.hpp"
#include "protocol.hpp"
#include "report.hpp"
#include "settled.hpp"

namespace bench {

/// Settles (beyond 64,000 bodies until the median body rests), then measures.
template <class Engine>
void run_pile(arguments args) {
  const auto bodies = args.count("bodies", 8000);
  const auto settle = args.count("settle", 720);
  const auto measure = args.count("measure", 120);
  const auto iterations = args.counts("iterations", "0");  // several: few first, so that errors
  const auto relax = args.count("relax", 60);              // can only shrink; steps between them
  const auto ratio = args.count("ratio", 0);               // 0: planes, else a vessel of spheres
  const auto seed = args.count("seed", 1);
  const auto tiles = args.count("tiles", 1);  // copies along each side of the box
  const auto start = args.text("from", "");
  const auto keep = args.text("keep", "");
  const auto file = args.json_file();
  if (!args.done()) return;

  if (ratio > 0 && !requires { Engine::takes_boulders; })
    throw std::invalid_argument(Engine::name() + " does not take a --ratio");
  scene s =
      ratio > 0 ? vessel_scene(bodies, static_cast<double>(ratio), seed) : pile_scene(bodies, seed);
  const std::string identity = digest(s);
  if (!start.empty()) load_state(s, start);
  if (tiles > 1) s = tiled(s, tiles);
  const double before = resident_bytes();
  Engine engine(s, iterations.front());
  const double still = 1e-3 * s.density * 4 / 3 * std::numbers::pi * std::pow(0.45, 4) * -s.gravity;
  std::uint64_t settled = 0;
  const auto settle_for = [&](std::uint64_t steps) {
    for (std::uint64_t i = 0; i < steps; ++i, ++settled) engine.step();
  };
  settle_for(settle);
  while (start.empty() && bodies > 64000 && settled < 20 * settle &&
         kinetic_energy(engine.balls(), s.density).median > still)
    settle_for(120);
  if (!keep.empty()) save_state(engine.balls(), keep);

  std::string all;
  for (std::size_t k = 0; k < iterations.size(); ++k) {
    if (k > 0) {
      if constexpr (requires { engine.iterate(1); })
        engine.iterate(iterations[k]);
      else
        throw std::invalid_argument(Engine::name() + " takes one number of --iterations in a run");
      settle_for(relax);
    }
    if constexpr (requires { engine.start_measuring(); }) engine.start_measuring();
    stopwatch watch;
    const double faults = page_faults();
    for (std::uint64_t step = 0; step < measure; ++step) {
      if (step + 1 == measure) engine.watch_loads();
      watch.time([&] { engine.step(); });
    }

    const double faults_per_step = (page_faults() - faults) / static_cast<double>(measure);

    record out;
    add_common(out, s, engine, watch, identity);
    out.add("page_faults_per_step", faults_per_step);
    double volume = 0, weighted_height = 0;
    for (const ball& b : engine.balls()) {
      volume += mass(b, 1);
      weighted_height += mass(b, 1) * b.position[2];
    }
    const double side = static_cast<double>(tiles) *
                        pile_side(bodies);  // a level pile is twice as high as its centre of mass
    out.add("packing_fraction", volume / (side * side * 2 * weighted_height / volume));
    out.add("size_ratio", ratio);
    out.add("resident_bytes_per_body",
            (resident_bytes() - before) / static_cast<double>(s.balls.size()));
    out.add("settle", settled);
    out.add("measure", measure);
    out.add("seed", seed);
    all += (k > 0 ? "," : "") + out.json();
  }
  record::write_text(iterations.size() > 1 ? "[" + all + "]\n" : all, file);
}

}  // namespace bench
