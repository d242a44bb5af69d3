#pragma once
// How an engine is measured on BOXPILE: as in protocol.hpp, its crates judged by crate_checker.hpp.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "box_pile_scene.hpp"
#include "crate_checker.hpp"
#include "protocol.hpp"

namespace bench {

inline double mass(const crate& c) { return c.density * c.size[0] * c.size[1] * c.size[2]; }

/// Kinetic energy per crate, of motion and rotation.
inline energies kinetic_energy(const std::vector<crate>& crates) {
  std::vector<double> each;
  double sum = 0;
  for (const crate& c : crates) {
    const auto axes = axes_of(c);
    double energy = 0.5 * mass(c) * dot(c.velocity, c.velocity);
    for (std::size_t k = 0; k < 3; ++k) {
      const double p = c.size[(k + 1) % 3], q = c.size[(k + 2) % 3], spin = dot(c.spin, axes[k]);
      energy += mass(c) / 24 * (p * p + q * q) * spin * spin;
    }
    each.push_back(energy);
    sum += energy;
  }
  if (each.empty()) return {};
  std::nth_element(each.begin(), each.begin() + each.size() / 2, each.end());
  return {sum / static_cast<double>(each.size()), each[each.size() / 2]};
}

/// Mean length of all edges.
inline double mean_edge(const std::vector<crate>& crates) {
  double sum = 0;
  for (const crate& c : crates) sum += (c.size[0] + c.size[1] + c.size[2]) / 3;
  return sum / static_cast<double>(crates.size());
}

/// Settles as long as boxes fall and two seconds, then measures. Overlaps are over the mean edge.
template <class Engine>
void run_box_pile(arguments args) {
  const auto bodies = args.count("bodies", 1000);
  const auto settle = args.count("settle", 0);
  const auto measure = args.count("measure", 120);
  const auto iterations = args.count("iterations", 0);
  const auto seed = args.count("seed", 1);
  const auto file = args.text("json", "");
  if (!args.done()) return;

  const scene s = box_pile_scene(bodies, seed);
  Engine engine(s, static_cast<int>(iterations));
  const std::size_t settling = settle > 0 ? settle : box_pile_settling(s);
  for (std::size_t step = 0; step < settling; ++step) engine.step();
  stopwatch watch;
  for (std::uint64_t step = 0; step < measure; ++step) watch.time([&] { engine.step(); });

  const auto crates = engine.crates();
  const auto found = check(crates, s.walls);
  const auto energy = kinetic_energy(crates);
  const auto contacts = engine.contacts();
  const double edge = mean_edge(s.crates);
  std::size_t escaped = found.not_finite;
  double volume = 0, weighted_height = 0;
  for (const crate& c : crates) {
    bool outside = false;
    for (const wall& w : s.walls) outside = outside || dot(w.normal, c.centre) < w.offset;
    escaped += outside;
    volume += mass(c);
    weighted_height += mass(c) * c.centre[2];
  }
  record out;
  out.add("engine", Engine::name());
  out.add("scene", s.name);
  out.add("scene_digest", digest(s));
  out.add("bodies", s.crates.size());
  out.add("dt", s.dt);
  out.add("cpu_ms_per_step", watch.mean());
  out.add("cpu_ms_per_step_median", watch.median());
  out.add("cpu_ms_per_step_fastest", watch.fastest());
  out.add("contacts", contacts);
  out.add("iterations", engine.iterations());
  out.add(
      "ns_per_contact_iteration",
      1e6 * watch.median() / std::max(1.0, static_cast<double>(contacts) * engine.iterations()));
  out.add("penetration_mean", found.mean / edge);
  out.add("penetration_max", found.max / edge);
  out.add("overlapping_pairs", found.pairs);
  if constexpr (requires { engine.residual(); }) out.add("contact_residual", engine.residual());
  out.add("kinetic_energy_per_body", energy.mean);
  out.add("kinetic_energy_median", energy.median);
  out.add("escaped", escaped);
  const double side = box_pile_side(bodies);  // a level pile is twice as high as its centre of mass
  out.add("packing_fraction", volume / (side * side * 2 * weighted_height / volume));
  out.add("settle", settling);
  out.add("measure", measure);
  out.add("seed", seed);
  engine.describe(out);
  out.write(file);
}

}  // namespace bench
