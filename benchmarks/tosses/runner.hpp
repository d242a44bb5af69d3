#pragma once
// The interface of the programs that the driver runs, tosses.py:
//   --file CSV --substeps N       reads lines "friction restitution even|odd" from standard input,
//                                 and answers each with the errors, an object on a line
#include <time.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

#include "protocol.hpp"

namespace bench::tosses {

inline double cpu_now() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

inline std::string array_of(const std::vector<double>& values, double scale) {
  std::string text = "[";
  char word[40];
  for (const double x : values) {
    std::snprintf(word, sizeof word, "%s%.4g", text.size() > 1 ? ", " : "", scale * x);
    text += word;
  }
  return text + "]";
}

template <class Engine>
void answer(const std::vector<toss>& tosses, const settings& how, std::size_t substeps) {
  const errors e = judge<Engine>(tosses, how, substeps, cpu_now);
  if (!std::isfinite(e.objective())) throw std::runtime_error("the cube is nowhere");
  std::printf(
      "{\"engine\": \"%s\", \"friction\": %g, \"restitution\": %g, \"tosses\": %zu, "
      "\"objective\": %.6g, \"distance\": %.6g, \"angle\": %.6g, \"faces\": %.6g, "
      "\"cpu_seconds\": %.6g, \"steps\": %zu, \"distances\": %s, \"angles\": %s}\n",
      Engine::name, how.friction, how.restitution, tosses.size(), e.objective(), e.distance,
      e.angle * 180 / pi, e.faces, e.cpu_seconds, e.steps, array_of(e.distances, 1).c_str(),
      array_of(e.angles, 180 / pi).c_str());
  std::fflush(stdout);
}

template <class Engine>
int run(int argc, char** argv) {
  try {
    std::string file;
    std::size_t substeps = 0;
    for (int i = 1; i + 1 < argc; i += 2) {
      const std::string word = argv[i];
      if (word == "--file")
        file = argv[i + 1];
      else if (word == "--substeps")
        substeps = std::stoul(argv[i + 1]);
      else
        throw std::invalid_argument("unknown argument '" + word + "'");
    }
    if (file.empty() || substeps == 0)
      throw std::invalid_argument("--file CSV and --substeps N are needed, N from 1");
    std::ifstream in(file);
    if (!in) throw std::runtime_error("there is no file '" + file + "'");
    const std::vector<toss> all = read(in);
    const std::vector<toss> even = half_of(all, false), odd = half_of(all, true);
    for (std::string line; std::getline(std::cin, line);) {
      std::istringstream words(line);
      settings how;
      std::string which;
      if (!(words >> how.friction >> how.restitution >> which) ||
          (which != "even" && which != "odd"))
        throw std::invalid_argument("no 'friction restitution even|odd': " + line);
      answer<Engine>(which == "odd" ? odd : even, how, substeps);
    }
    return 0;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
}

}  // namespace bench::tosses
