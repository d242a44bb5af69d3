#pragma once
/// \file
/// The rotating drum of M. Dosta and others 2024: 8,000 spheres of M2 and 30,000 of M1.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <sstream>
#include <string>
#include <talus/mesh.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

#include "dosta.hpp"
#include "scenes/report.hpp"

namespace dosta {

using drum_scenario =
    talus::scenario<talus::bodies<talus::sphere, talus::triangle_mesh>,
                    talus::soft_contact<talus::hertz_mindlin, talus::coulomb_friction>,
                    talus::integrator<talus::velocity_verlet>, talus::transport<talus::serial>,
                    talus::features<talus::driven>>;

struct drum_settings {
  double softness = 500;   ///< divides Young's moduli: 1 as published, 500 in the cheap variant
  double dt = 1e-4;        ///< seconds; 8e-7 for softness 1
  double time = 5;         ///< seconds
  std::string curve = {};  ///< file for the numbers over time, or empty
  std::string positions =
      {};  ///< file for the positions at the end, in the order of the given file
};

/// Spheres in the quadrant x > 0, z > 0 and in the opposite one, and what the run cost.
struct drum_result {
  double spheres = 0;
  double m1_upper = 0, m2_upper = 0, m1_lower = 0, m2_lower = 0;
  double kinetic_energy = 0;
  double cpu_seconds = 0, steps = 0;
};

/// Runs the drum with the files of `folder`. Writes a line every 0.05 s: time, spheres of M1 and of
/// M2 in x > 0, z > 0, and in x < 0, z < 0.
inline drum_result run_drum(const std::string& folder, const drum_settings& settings) {
  talus::serial::link link;
  talus::world<drum_scenario> w(link);
  w.gravity({0, 0, -gravity});
  const materials m = add_materials(w, settings.softness);
  const talus::triangle_mesh surface(read_triangles(folder + "/drum_walls.txt"));
  const talus::pose at = talus::placed(surface);
  talus::handle<talus::triangle_mesh> shell;
  w.global([&](auto& scope) { shell = scope.add(surface, m.steel, at.position, at.orientation); });
  w.drive(shell, talus::turning{.axis = {0, 1, 0}, .speed = -2});
  for (const grain& g : read_spheres(folder + "/drum_particles.txt"))
    w.add(talus::body{.shape = talus::sphere{g.radius},
                      .position = g.position,
                      .material = g.radius > 0.0015 ? m.m2 : m.m1});
  if (!settings.positions.empty()) bench::require_place(settings.positions, bench::state_output);
  std::string curve;  // so far: the file always is a whole one
  drum_result r;
  const auto look = [&] {
    drum_result now;
    w.for_each_local([&](const auto& b) {
      if constexpr (requires { b.shape().radius; }) {
        const talus::vec3 p = b.position();
        const bool upper = p[0] > 0 && p[2] > 0, lower = p[0] < 0 && p[2] < 0;
        const bool large = b.shape().radius > 0.0015;
        now.spheres += std::hypot(p[0], p[2]) < 0.104 && std::abs(p[1]) < 0.032;
        now.m1_upper += upper && !large, now.m2_upper += upper && large;
        now.m1_lower += lower && !large, now.m2_lower += lower && large;
        now.kinetic_energy += 0.5 * b.mass() * b.velocity().squaredNorm();
      }
    });
    return now;
  };
  const auto write = [&](double time) {
    if (settings.curve.empty()) return;
    const drum_result now = look();
    std::ostringstream line;
    line << time << " " << now.m1_upper << " " << now.m2_upper << " " << now.m1_lower << " "
         << now.m2_lower << "\n";
    bench::write_file(curve += line.str(), settings.curve, bench::state_output);
  };
  const auto steps = static_cast<long>(std::llround(settings.time / settings.dt));
  const long every = std::max(1L, std::lround(0.05 / settings.dt));
  const std::clock_t start = std::clock();
  write(0);
  for (long k = 1; k <= steps; ++k) {
    w.step(settings.dt);
    if (k % every == 0) write(static_cast<double>(k) * settings.dt);
  }
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  if (!settings.positions.empty()) {
    std::vector<std::pair<talus::system_id, talus::vec3>> places;
    w.for_each_local([&](const auto& b) {
      if constexpr (requires { b.shape().radius; }) places.emplace_back(b.id(), b.position());
    });
    std::sort(places.begin(), places.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    std::ostringstream out;
    out.precision(17);
    for (const auto& [id, p] : places) out << p[0] << " " << p[1] << " " << p[2] << "\n";
    bench::write_file(out.str(), settings.positions, bench::state_output);
  }
  r = look();
  r.cpu_seconds = seconds, r.steps = static_cast<double>(steps);
  return r;
}

}  // namespace dosta
