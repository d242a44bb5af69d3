#pragma once
// The interface of the programs that the driver runs, joints.py:
//   --list [--quick]                       the runs of this engine, a line each: scene integrator
//   dt;
//                                          lines that begin with # say which scenes it leaves out
//   --scene S --integrator I --dt T        makes a run and prints its row, with the values of the
//   probes
// An engine is a class with a name, plans(), notes(), and, constructed from (scene, integrator,
// dt), advance(steps) and states().
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <iterator>
#include <string>
#include <vector>

#include "checker.hpp"
#include "scenes.hpp"

namespace bench::joints {

/// Runs of an engine: each integrator with each time step, in the scenes whose name begins so.
struct plan {
  std::string scenes;
  std::string integrator;
  std::vector<double> steps;
  std::vector<double> quick_steps;
};

inline double cpu_now() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class Engine>
int list(bool quick) {
  for (const std::string& note : Engine::notes()) std::printf("# %s\n", note.c_str());
  for (const std::string& name : scene_names())
    for (const plan& p : Engine::plans())
      if (begins(name, p.scenes))
        for (const double dt : quick ? p.quick_steps : p.steps)
          std::printf("%s %s %g\n", name.c_str(), p.integrator.c_str(), dt);
  return 0;
}

template <class Engine>
int measure(const std::string& name, const std::string& integrator, double dt) {
  constexpr int samples = 10, checks = 10;  // samples of the probes, checks of the joints in each
  const scene s = scene_of(name);
  const double before = energy(s, start_of(s));
  const long steps = std::lround(s.duration / (samples * checks) / dt);
  if (steps < 1 || std::abs(steps * dt * samples * checks - s.duration) > 1e-9 * s.duration)
    throw std::invalid_argument("--dt does not divide a hundredth of the duration");
  Engine engine(s, integrator, dt);
  double seconds = 0, drift = 0, apart = 0;
  std::string rows;
  for (int i = 0; i < samples; ++i) {
    for (int k = 0; k < checks; ++k) {
      const double from = cpu_now();
      engine.advance(steps);
      seconds += cpu_now() - from;
      const double off = std::abs(energy(s, engine.states()) - before);
      const double wide = largest_gap(s, engine.states());
      if (!(off <= drift)) drift = off;
      if (!(wide <= apart)) apart = wide;
    }
    rows += i ? ", [" : "[";
    const std::vector<double> list = values(s, engine.states());
    char text[40];
    for (std::size_t k = 0; k < list.size(); ++k) {
      std::snprintf(text, sizeof text, "%s%.16g", k ? ", " : "", list[k]);
      rows += text;
    }
    rows += "]";
  }
  const auto number = [](double x) {
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", x);
    return std::isfinite(x) ? std::string(text) : std::string("null");
  };
  if (rows.find("nan") != std::string::npos || rows.find("inf") != std::string::npos) rows.clear();
  std::printf(
      "{\"scene\": \"%s\", \"engine\": \"%s\", \"integrator\": \"%s\", \"dt\": %g, "
      "\"cpu_seconds\": %.6g, \"error_is\": \"%s\", \"joint_drift_max\": %s, "
      "\"energy_drift\": %s, \"length\": %g, \"samples\": [%s]}\n",
      name.c_str(), Engine::name, integrator.c_str(), dt, seconds, s.error_is.c_str(),
      number(apart).c_str(), s.conservative ? number(drift).c_str() : "null", s.length,
      rows.c_str());
  return 0;
}

template <class Engine>
int run(int argc, char** argv) {
  std::string name, integrator;
  double dt = 0;
  bool listing = false, quick = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--list")
      listing = true;
    else if (word == "--quick")
      quick = true;
    else if (word == "--scene" && i + 1 < argc)
      name = argv[++i];
    else if (word == "--integrator" && i + 1 < argc)
      integrator = argv[++i];
    else if (word == "--dt" && i + 1 < argc)
      dt = std::atof(argv[++i]);
    else {
      std::fprintf(stderr, "unknown argument '%s'\n", word.c_str());
      return 2;
    }
  }
  try {
    if (listing) return list<Engine>(quick);
    if (!(dt > 0)) {
      std::fprintf(stderr, "--dt needs a positive number\n");
      return 2;
    }
    return measure<Engine>(name, integrator, dt);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
}

}  // namespace bench::joints
