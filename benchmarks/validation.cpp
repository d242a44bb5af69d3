// Validation cases of talus against formulas and publications, written as a JSON array.
#include "validation.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <talus/observe/critical_dt.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

namespace {

using elastic =
    talus::scenario<talus::bodies<talus::sphere>, talus::soft_contact<talus::hertz_mindlin>,
                    talus::integrator<talus::velocity_verlet>, talus::transport<talus::serial>>;

struct grains {
  std::string name;
  double youngs_modulus, poissons_ratio, density;
  double force, overlap, duration;  ///< N, m, s
};

/// Test 1: two spheres of radius 10 mm meet head on at 10 m/s each, without damping.
void two_spheres(validation::report& out, const grains& g) {
  constexpr double radius = 0.01, speed = 10;
  talus::serial::link link;
  talus::world<elastic> w(link);
  w.material({.density = g.density,
              .restitution = 1,
              .youngs_modulus = g.youngs_modulus,
              .poisson_ratio = g.poissons_ratio});
  const auto a = w.add(talus::body{
      .shape = talus::sphere{radius}, .position = {-radius, 0, 0}, .velocity = {speed, 0, 0}});
  const auto b = w.add(talus::body{
      .shape = talus::sphere{radius}, .position = {radius, 0, 0}, .velocity = {-speed, 0, 0}});
  const double mass = g.density * 4 / 3 * talus::pi * radius * radius * radius;
  const double dt = g.duration / 2000;
  double force = 0, deepest = 0, time = 0, before = 2 * speed, overlap = 0;
  do {
    w.step(dt);
    const double closing = (w[a].velocity() - w[b].velocity())[0];
    const double last = overlap;
    overlap = 2 * radius - (w[b].position() - w[a].position())[0];
    force = std::max(force, mass * (before - closing) / 2 / dt);
    deepest = std::max(deepest, overlap);
    before = closing;
    time += overlap > 0 ? dt : dt * last / (last - overlap);  // the end lies within the step
  } while (overlap > 0 && time < 3 * g.duration);
  const std::string source = "Chung and Ooi 2011, test 1: Hertz impact of two spheres";
  const std::string name = "chung_ooi/1/" + g.name;
  out.push_back({name, "largest force", "N", g.force, force, 0.01 * g.force, source});
  out.push_back({name, "largest overlap", "m", g.overlap, deepest, 0.01 * g.overlap, source});
  out.push_back({name, "duration", "s", g.duration, time, 0.01 * g.duration, source});
  out.push_back({name, "restitution", "1", 1, -before / (2 * speed), 0.005, source});
}

void chung_ooi(validation::report& out, const validation::effort&) {
  two_spheres(out, {"glass", 48e9, 0.20, 2800, 10697, 274.1e-6, 40.34e-6});
  two_spheres(out, {"limestone", 20e9, 0.25, 2500, 7108, 368.3e-6, 54.20e-6});
}

/// The themes; add a line for a new one.
const std::vector<validation::theme> themes{{"chung_ooi", chung_ooi}};

int run(int argc, char** argv) {
  std::string only, file;
  validation::effort effort;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--quick") {
      effort.quick = true;
    } else if (argument == "--only" || argument == "--json") {
      if (i + 1 == argc) throw std::invalid_argument(argument + " needs a value");
      (argument == "--only" ? only : file) = argv[++i];
    } else {
      throw std::invalid_argument("validation has no option '" + argument +
                                  "'; there are: --quick, --only NAME,..., --json FILE");
    }
  }
  std::vector<bool> chosen(themes.size(), only.empty());
  for (std::size_t at = 0; !only.empty() && at <= only.size();) {
    const std::size_t end = std::min(only.find(',', at), only.size());
    const std::string name = only.substr(at, end - at);
    const auto found =
        std::find_if(themes.begin(), themes.end(), [&](const auto& t) { return t.name == name; });
    if (found == themes.end()) {
      std::string all;
      for (const auto& t : themes) all += (all.empty() ? "" : ", ") + t.name;
      throw std::invalid_argument("--only: there are no cases '" + name + "'; there are: " + all);
    }
    chosen[static_cast<std::size_t>(found - themes.begin())] = true;
    at = end + 1;
  }
  validation::report results;
  for (std::size_t i = 0; i < themes.size(); ++i)
    if (chosen[i]) themes[i].run(results, effort);
  if (file.empty()) {
    std::cout << validation::json(results);
  } else {
    std::ofstream out(file);
    out << validation::json(results);
    out.close();
    if (!out) throw std::runtime_error("cannot write " + file);
  }
  int missed = 0;
  for (const auto& r : results)
    if (!r.met()) {
      ++missed;
      std::cerr << "not met: " << r.name << ", " << r.quantity << ": expected "
                << validation::number(r.expected) << ", found " << validation::number(r.found)
                << " " << r.unit << "\n";
    }
  return missed > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
