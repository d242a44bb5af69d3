#pragma once
// How an engine is measured on a scene: the same steps, clock and checker for all. An engine is a
// class built from (scene, iterations), 0 iterations meaning its own default, with
//   void step();                       one time step of scene.dt
//   std::vector<ball> balls() const;   current state in the order of the scene
//   std::size_t contacts() const;      contact points it treated in the last step
//   void watch_loads();                called before the last step, for engines that must prepare
//   std::vector<loaded_pair> loaded() const;   pairs that carried an impulse in the last step
//   int iterations() const;
//   void describe(record&) const;      its settings
//   static std::string name();
// and where it can
//   void iterate(int);                 sets the iterations from now on
//   void start_measuring();            the steps that count begin
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include "checker.hpp"
#include "report.hpp"
#include "well_scene.hpp"

namespace bench {

struct energies {
  double mean = 0, median = 0;
};

inline double mass(const ball& b, double density) {
  return density * 4 / 3 * std::numbers::pi * b.radius * b.radius * b.radius;
}

/// Kinetic energy per body, of motion and rotation (solid spheres).
inline energies kinetic_energy(const std::vector<ball>& balls, double density) {
  if (balls.empty()) return {};
  std::vector<double> each;
  double sum = 0;
  for (const ball& b : balls) {
    const double speed2 =
        dot(b.velocity, b.velocity) + 0.4 * b.radius * b.radius * dot(b.spin, b.spin);
    each.push_back(0.5 * mass(b, density) * speed2);
    sum += each.back();
  }
  std::nth_element(each.begin(), each.begin() + each.size() / 2, each.end());
  return {sum / static_cast<double>(each.size()), each[each.size() / 2]};
}

/// Fields that every scene reports in the same way. `identity` is the digest of a scene that
/// starts from another state than its own.
template <class Engine>
void add_common(record& out, const scene& s, Engine& engine, const stopwatch& watch,
                const std::string& identity = {}) {
  const auto balls = engine.balls();
  const auto found = check(balls, s.walls, s.blocks, s.boulders);
  const auto energy = kinetic_energy(balls, s.density);
  const auto contacts = engine.contacts();
  const auto loaded = engine.loaded();
  out.add("engine", Engine::name());
  out.add("scene", s.name);
  out.add("scene_digest", identity.empty() ? digest(s) : identity);
  out.add("bodies", s.balls.size());
  out.add("dt", s.dt);
  out.add("cpu_ms_per_step", watch.mean());
  out.add("cpu_ms_per_step_median", watch.median());
  out.add("cpu_ms_per_step_fastest", watch.fastest());
  out.add("cpu_ms_per_step_longest", watch.longest());
  out.add("contacts", contacts);
  out.add("iterations", engine.iterations());
  out.add(
      "ns_per_contact_iteration",
      1e6 * watch.median() / std::max(1.0, static_cast<double>(contacts) * engine.iterations()));
  out.add("penetration_mean", found.penetration_mean);
  out.add("penetration_max", found.penetration_max);
  out.add("overlapping_pairs", found.overlapping_pairs);
  out.add("touching_pairs", found.touching_pairs);
  out.add("gap_mean_touching", found.gap_mean_touching);
  out.add("loaded_pairs", loaded.size());
  out.add("gap_mean_loaded", gap_mean_loaded(balls, s.walls, s.blocks, loaded, s.boulders));
  if constexpr (requires { engine.residual(); }) out.add("contact_residual", engine.residual());
  out.add("kinetic_energy_per_body", energy.mean);
  out.add("kinetic_energy_median", energy.median);
  out.add("not_finite", found.not_finite);
  out.add("escaped", found.not_finite + found.behind_walls);
  engine.describe(out);
}

/// All steps from the fall to rest; the cost is that of the last `measure` steps.
template <class Engine>
void run_well(arguments args) {
  const auto bodies = args.count("bodies", 3000);
  const auto steps = args.count("steps", 6000);
  const auto measure = std::min(args.count("measure", 500), steps);
  const auto iterations = args.count("iterations", 0);
  const auto seed = args.count("seed", 1);
  const auto file = args.json_file();
  if (!args.done()) return;

  const scene s = well_scene(bodies, seed);
  Engine engine(s, static_cast<int>(iterations));
  const double start = cpu_seconds();
  for (std::uint64_t step = 0; step < steps - measure; ++step) engine.step();
  stopwatch watch;
  for (std::uint64_t step = 0; step < measure; ++step) {
    if (step + 1 == measure) engine.watch_loads();
    watch.time([&] { engine.step(); });
  }
  const double total = cpu_seconds() - start;

  record out;
  add_common(out, s, engine, watch);
  std::size_t outside = 0;
  for (const ball& b : engine.balls())
    outside += std::hypot(b.position[0], b.position[1]) > well_radius;
  out.add("outside_well", outside);  // over the rim: some fly there honestly
  out.add("cpu_seconds_total", total);
  out.add("steps", steps);
  out.add("measure", measure);
  out.add("seed", seed);
  out.write(file);
}

/// Runs a program's body; one line on standard error and a failing exit code for any exception.
template <class Body>
int guarded(Body&& body) {
  try {
    body();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "error: " << error.what() << '\n';
    return 2;
  }
}

}  // namespace bench
