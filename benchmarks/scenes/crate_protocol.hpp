#pragma once
// How an engine is measured on boxes: a pile, or a pyramid of unit boxes.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "crate_checker.hpp"
#include "crate_scenes.hpp"
#include "protocol.hpp"
#include "settled.hpp"
#include "small_scenes.hpp"

namespace bench {

/// Settles, then measures: `boxpile` as long as it falls plus 2 s, `pyramid` 5 s of which the last
/// count. Lengths are in units of the mean edge.
template <class Engine>
void run_crates(arguments args) {
  const auto name = args.text("scene", "boxpile");
  if (name != "boxpile" && name != "pyramid")
    throw std::invalid_argument("there is no scene '" + name + "'; there are boxpile and pyramid");
  const bool pile = name == "boxpile";
  const auto bodies = args.count("bodies", pile ? 1000 : 20);  // of a pyramid: in the lowest row
  const scene s = pile ? boxpile_scene(bodies) : pyramid_scene(bodies);
  // The highest boxes fall by what the lattice is looser than the pile, less than half their
  // height.
  double top = 0;
  for (const crate& c : s.crates) top = std::max(top, c.centre[2]);
  const double falls = std::sqrt(2 * top / gravity);
  const auto usual = pile ? static_cast<std::uint64_t>((falls + 2) / s.dt) : 1080;
  const auto settle = args.count("settle", usual);
  const auto measure = args.count("measure", 120);
  const auto iterations = args.count("iterations", 0);
  const auto file = args.json_file();
  if (!args.done()) return;

  const double before = resident_bytes();
  Engine engine(s, static_cast<int>(iterations));
  for (std::uint64_t i = 0; i < settle; ++i) engine.step();
  if constexpr (requires { engine.start_measuring(); }) engine.start_measuring();
  stopwatch watch;
  for (std::uint64_t i = 0; i < measure; ++i) watch.time([&] { engine.step(); });

  const auto crates = engine.crates();
  const auto found = check(crates, s.walls);
  double edge = 0, moved = 0;
  std::size_t escaped = found.not_finite;
  std::vector<double> energies;  // of motion alone
  for (std::size_t i = 0; i < crates.size(); ++i) {
    for (const double e : crates[i].size) edge += e / (3 * static_cast<double>(crates.size()));
    const double way = norm(minus(crates[i].centre, s.crates[i].centre));
    moved = way > moved || !std::isfinite(way) ? way : moved;
    energies.push_back(0.5 * crates[i].density * crates[i].size[0] * crates[i].size[1] *
                       crates[i].size[2] * dot(crates[i].velocity, crates[i].velocity));
    for (const wall& w : s.walls)
      if (dot(w.normal, crates[i].centre) < w.offset) {
        ++escaped;
        break;
      }
  }
  const vec drift = minus(crates.back().centre, s.crates.back().centre);  // the top, the last one
  record out;
  out.add("engine", Engine::name());
  out.add("scene", s.name);
  out.add("scene_digest", digest(s));
  out.add("bodies", s.crates.size());
  out.add("dt", s.dt);
  out.add("cpu_ms_per_step", watch.mean());
  out.add("cpu_ms_per_step_median", watch.median());
  out.add("cpu_ms_per_step_fastest", watch.fastest());
  out.add("contacts", engine.contacts());
  out.add("iterations", engine.iterations());
  out.add("penetration_mean", found.mean / edge);
  out.add("penetration_max", found.max / edge);
  out.add("overlapping_pairs", found.pairs);
  out.add("not_finite", found.not_finite);
  out.add("escaped", escaped);
  double sum = 0;
  for (const double e : energies) sum += e;
  std::sort(energies.begin(), energies.end());
  out.add("kinetic_energy_per_body", sum / static_cast<double>(crates.size()));
  out.add("kinetic_energy_median", energies[energies.size() / 2]);
  out.add("kinetic_energy_max", energies.back());
  if (!pile) {
    out.add("displacement_max", moved);
    out.add("top_drift", std::hypot(drift[0], drift[1]));
    out.add("top_sinking", -drift[2]);
    out.add("stands", moved < 0.5);
  }
  out.add("resident_bytes_per_body",
          (resident_bytes() - before) / static_cast<double>(s.crates.size()));
  out.add("settle", settle);
  out.add("measure", measure);
  if constexpr (requires { engine.world(); }) {
    const auto t = engine.world().stage_times();
    const double steps = static_cast<double>(settle + measure);
    out.add("detect_ms_per_step_all", 1e3 * t.detect / steps);
    out.add("respond_ms_per_step_all", 1e3 * t.respond / steps);
  }
  out.write(file);
}

}  // namespace bench
