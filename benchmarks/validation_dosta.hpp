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

/// Speed of a sphere that has met a steel plane at right angles at 1 m/s, in steps of dt.
inline double rebound(bool m2, double dt) {
  talus::serial::link link;
  talus::world<contact> w(link);
  const auto materials = ::dosta::add_materials(w);
  w.global([&](auto& scope) { scope.add(talus::plane{}, materials.steel); });
  const double radius = m2 ? 0.002 : 0.001;
  const auto b = w.add(talus::body{.shape = talus::sphere{radius},
                                   .position = {0, 0, radius + 0.25 * dt},
                                   .material = m2 ? materials.m2 : materials.m1,
                                   .velocity = {0, 0, -1}});
  do w.step(dt);
  while (w[b].position()[2] < radius || w[b].velocity()[2] < 0);
  return w[b].velocity()[2];
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
  out.push_back({"dosta/contact/M1-steel", "speed of rebound at dt = 5e-7", "m/s", 0.401075,
                 rebound(false, 5e-7), 0.005, paper + "; MercuryDPM"});
  out.push_back({"dosta/contact/M1-steel", "restitution at dt = 5e-8", "1", 0.4,
                 rebound(false, 5e-8), 0.005, paper + ", table of materials"});
  out.push_back({"dosta/contact/M2-steel", "restitution at dt = 5e-8", "1", 0.4,
                 rebound(true, 5e-8), 0.005, paper + ", table of materials"});
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
