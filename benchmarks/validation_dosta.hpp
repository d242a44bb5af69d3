#pragma once
/// \file
/// Cases of M. Dosta and others 2024 that take seconds: single contacts with steel, and the bulk
/// processes in parts, where their files are present. The whole processes: docs/validation.md.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <talus/parallel/serial.hpp>
#include <talus/shape/plane.hpp>
#include <talus/world/world.hpp>

#include "dosta.hpp"
#include "dosta_drum.hpp"
#include "validation.hpp"

namespace validation {

namespace dosta_cases {

using contact =
    talus::scenario<talus::bodies<talus::sphere, talus::plane>,
                    talus::soft_contact<talus::hertz_mindlin, talus::coulomb_friction>,
                    talus::integrator<talus::velocity_verlet>, talus::transport<talus::serial>>;

/// A sphere that meets a steel plane, or a sphere of M1 (radius 1 mm) at rest. Without gravity.
struct impact {
  char material = '1';  ///< of the sphere: M1, M2 ('2'), or steel ('s') of radius 10 mm
  bool with_plane = true;
  talus::vec3 velocity{0, 0, -1};
  double dt = 2e-8;
};
/// Velocities after it; the second one of the sphere that was at rest.
struct rebound {
  talus::vec3 velocity{0, 0, 0}, angular_velocity{0, 0, 0}, second{0, 0, 0};
};
inline rebound after(const impact& how) {
  talus::serial::link link;
  talus::world<contact> w(link);
  const auto m = ::dosta::add_materials(w);
  const double radius = how.material == '1' ? 0.001 : how.material == '2' ? 0.002 : 0.01;
  const double gap = -0.25 * how.dt * how.velocity[2];
  const auto b = w.add(talus::body{.shape = talus::sphere{radius},
                                   .position = {0, 0, radius + gap},
                                   .material = how.material == '1'   ? m.m1
                                               : how.material == '2' ? m.m2
                                                                     : m.steel,
                                   .velocity = how.velocity});
  talus::handle<talus::sphere> other;
  if (how.with_plane)
    w.global([&](auto& scope) { scope.add(talus::plane{}, m.steel); });
  else
    other = w.add(
        talus::body{.shape = talus::sphere{0.001}, .position = {0, 0, -0.001}, .material = m.m1});
  for (double t = 0; t < 2.5e-4; t += how.dt) w.step(how.dt);  // contacts last 4e-5 s
  rebound r{w[b].velocity(), w[b].angular_velocity()};
  if (!how.with_plane) r.second = w[other].velocity();
  return r;
}

/// The folder of the files, or an empty name: TALUS_DOSTA, ../shared/dosta unless given.
inline std::string folder() {
  const char* named = std::getenv("TALUS_DOSTA");
  const std::string name = named != nullptr ? named : "../shared/dosta";
  return std::filesystem::exists(name + "/drum_particles.txt") ? name : std::string();
}

}  // namespace dosta_cases

/// `quick` leaves the drum out.
inline void dosta(report& out, const effort& how) {
  using namespace dosta_cases;
  const std::string paper = "Dosta and others 2024";
  const auto speed = [](char material, double dt, double at = 1) {
    return after({.material = material, .velocity = {0, 0, -at}, .dt = dt}).velocity[2];
  };
  out.push_back({"dosta/contact/M1-steel", "speed of rebound at dt = 5e-7", "m/s", 0.401075,
                 speed('1', 5e-7), 0.005, paper + "; MercuryDPM"});
  out.push_back({"dosta/contact/M1-steel", "restitution at dt = 2e-8", "1", 0.4, speed('1', 2e-8),
                 0.0005, paper + ", table of materials"});
  out.push_back({"dosta/contact/M2-steel", "restitution at dt = 2e-8", "1", 0.4, speed('2', 2e-8),
                 0.0005, paper + ", table of materials"});
  // LIGGGHTS 3.8 and LAMMPS 2022 agree in these to 1e-6 (benchmarks/dosta/contact.py).
  const std::string codes = "LIGGGHTS 3.8, LAMMPS 2022";
  out.push_back({"dosta/contact/steel-steel", "speed of rebound after 5 m/s", "m/s", 2.999957,
                 speed('s', 2e-8, 5), 0.003, codes});
  out.push_back({"dosta/contact/steel-steel", "speed of rebound after 2 m/s", "m/s", 1.199980,
                 speed('s', 2e-8, 2), 0.001, codes});
  out.push_back({"dosta/contact/steel-steel", "speed of rebound after 5 m/s at dt = 5e-7", "m/s",
                 2.996316, speed('s', 5e-7, 5), 0.01, codes});
  out.push_back({"dosta/contact/M1-M1", "speed of the second sphere", "m/s", 0.749989,
                 -after({.with_plane = false}).second[2], 0.001, codes});
  out.push_back({"dosta/contact/steel-M1", "speed of the second sphere", "m/s", 6.996909,
                 -after({.material = 's', .with_plane = false, .velocity = {0, 0, -5}}).second[2],
                 0.007, codes});
  // Their dashpots across the contact differ; the tolerance is the difference of the two codes.
  out.push_back({"dosta/contact/M1-M1/oblique", "tangential velocity", "m/s", 0.432270,
                 after({.with_plane = false, .velocity = {0.5, 0, -1}}).velocity[0], 0.0076,
                 "LIGGGHTS 3.8; 0.4247 in LAMMPS 2022"});
  out.push_back({"dosta/contact/M1-steel/sticking", "tangential velocity", "m/s", 0.142997,
                 after({.velocity = {0.2, 0, -1}}).velocity[0], 0.00073,
                 "LIGGGHTS 3.8; 0.1437 in LAMMPS 2022"});
  // Sliding from its beginning to its end: impulses of rigid bodies, mu (1 + e) v.
  const rebound slides = after({.velocity = {1, 0, -1}});
  out.push_back({"dosta/contact/M1-steel/oblique", "tangential velocity", "m/s", 1 - 0.2 * 1.4,
                 slides.velocity[0], 0.0005, "impulse of sliding"});
  out.push_back({"dosta/contact/M1-steel/oblique", "angular velocity", "1/s",
                 2.5 * 0.2 * 1.4 / 0.001, slides.angular_velocity[1], 0.5, "impulse of sliding"});
  if (how.quick) return;
  const std::string files = folder();
  if (files.empty()) {
    std::fprintf(stderr,
                 "dosta: the drum is left out, since ../shared/dosta has no files; TALUS_DOSTA "
                 "names another folder\n");
    return;
  }
  // The cheap variant while the bed is lifted. LIGGGHTS 3.8 ran on the same files
  // (docs/validation.md).
  const ::dosta::drum_result r =
      ::dosta::run_drum(files, {.softness = 500, .dt = 1e-4, .time = 0.3});
  out.push_back({"dosta/drum/soft", "spheres within the drum after 0.3 s", "1", 38000, r.spheres, 0,
                 paper + "; conservation"});
  const auto beside = [&](const std::string& which, double other, double found) {
    out.push_back({"dosta/drum/soft", which + " after 0.3 s", "1", other, found, 0.05 * other,
                   paper + "; LIGGGHTS 3.8 on the same files"});
  };
  beside("M1 in x > 0, z > 0", 5443, r.m1_upper);
  beside("M1 in x < 0, z < 0", 12615, r.m1_lower);
  beside("M2 in x < 0, z < 0", 1700, r.m2_lower);
}

}  // namespace validation
