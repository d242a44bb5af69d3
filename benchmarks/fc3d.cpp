// Frictional contact problems from files, solved through the assembled Delassus operator.
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "fc3d/problem.hpp"
#include "fc3d/timing.hpp"
#include "talus/scene/command_line.hpp"
#include "talus/solver/direct/solve_assembled.hpp"
#ifdef TALUS_WITH_HDF5
#include "fc3d/fclib.hpp"
#endif
#ifdef TALUS_WITH_SICONOS
#include "fc3d/siconos.hpp"
#endif

namespace fc3d {

struct problem {
  assembled_problem p;
  std::string text;  ///< in Siconos' format, if it was read from that
};

problem read(const std::string& path) {
  std::string bytes = contents(path);
  if (bytes.rfind("\211HDF\r\n\032\n", 0) != 0) return {read_text(bytes), bytes};
#ifdef TALUS_WITH_HDF5
  return {read_fclib(path), {}};
#else
  fail<std::runtime_error>(
      "is in HDF5, and this program was built without it; install libhdf5-dev and build again");
#endif
}

struct settings {
  double tolerance = 1e-6, seconds = 20;
};

void print(const std::string& path, int contacts, const std::string& solver, double tolerance,
           int iterations, double milliseconds, const talus::detail::contact_error& e,
           bool converged) {
  std::printf("%s\t%d\t%s\t%g\t%d\t%.4g\t%.3e\t%.3e\t%.3e\t%d\n",
              std::filesystem::path(path).filename().c_str(), contacts, solver.c_str(), tolerance,
              iterations, milliseconds, e.scaled, e.by_q, e.relative, converged);
  std::fflush(stdout);
}

using method = talus::detail::assembled_method;
const std::map<std::string, method> methods{{"hybrid", method::hybrid},
                                            {"nsgs", method::gauss_seidel},
                                            {"newton", method::newton},
                                            {"interior", method::interior_point}};

void run(const std::string& path, const assembled_problem& p, const std::string& solver,
         const settings& s) {
  const method method = methods.at(solver);
  talus::detail::assembled_result result;
  contact_vector r;
  const double seconds = median_seconds([&](auto&& timed) {
    r.set_zero(p.contacts());
    const double start = cpu_seconds();
    const auto in_time = [&] { return cpu_seconds() - start < s.seconds; };
    timed([&] {
      result = talus::detail::solve_assembled(p, r, s.tolerance, 1'000'000'000, in_time, method);
    });
  });
  const auto e = talus::detail::error_of(p, r);
  print(path, p.contacts(), solver, s.tolerance, result.iterations, 1e3 * seconds, e,
        result.converged && e.scaled <= s.tolerance);
}

#ifdef TALUS_WITH_SICONOS
void run_rivals(const std::string& path, const problem& file, const settings& s) {
  const std::string text = file.text.empty() ? as_text(file.p) : file.text;
  for (const rival& way : rivals()) {
    const rival_result found = run_rival(way, file.p, text, s.tolerance, s.seconds);
    const auto e = talus::detail::error_of(file.p, found.r);
    print(path, file.p.contacts(), way.name, s.tolerance, found.iterations, 1e3 * found.seconds, e,
          e.scaled <= s.tolerance);
  }
}
#endif

}  // namespace fc3d

int main(int argc, char** argv) {
  talus::command_line app(
      "Solves frictional contact problems from files (Siconos' text format, FCLIB's HDF5 format).\n"
      "Prints a line for each problem and solver; converged: err_scaled <= tol, by the full W.");
  std::vector<std::string> files;
  fc3d::settings settings;
  bool siconos = false;
  std::string wanted = "hybrid";
  app.add_rest("FILES", files, "problems; those that are not there are skipped");
  app.add("--solver", wanted, "hybrid, nsgs, newton or interior, several by commas, or all");
  app.add_positive("--tol", settings.tolerance, "largest err_scaled");
  app.add_positive("--max-seconds", settings.seconds, "CPU time for each problem and solver");
  app.add("--siconos", siconos, "Siconos' solvers on the same problems, a line each");
  try {
    app.parse(argc, argv);
  } catch (const talus::help_requested& help) {
    std::fputs(help.what(), stdout);
    return 0;
  } catch (const talus::usage_error& error) {
    std::fprintf(stderr, "fc3d: %s\n", error.what());
    return 2;
  }
  std::vector<std::string> solvers;
  std::istringstream words(wanted);
  for (std::string name; std::getline(words, name, ',');) {
    if (fc3d::methods.contains(name)) {
      solvers.push_back(name);
    } else if (name == "all") {
      for (const auto& each : fc3d::methods) solvers.push_back(each.first);
    } else {
      std::fprintf(stderr,
                   "fc3d: there is no solver '%s'; there are hybrid, nsgs, newton, interior, all\n",
                   name.c_str());
      return 2;
    }
  }

#ifndef TALUS_WITH_SICONOS
  if (siconos)
    std::fputs("fc3d: built without Siconos; install libsiconos-numerics-dev and configure again\n",
               stderr);
#endif
  if (files.empty()) std::fputs("fc3d: no files, nothing to do\n", stderr);
  std::puts(
      "#file\tcontacts\tsolver\ttol\titerations\tcpu_ms\terr_scaled\terr_q\terr_rel\tconverged");
  int failed = 0;
  for (const auto& path : files) {
    if (!std::filesystem::exists(path)) {
      std::fprintf(stderr, "fc3d: %s is not there, skipped\n", path.c_str());
      continue;
    }
    try {
      const fc3d::problem file = fc3d::read(path);
      for (const auto& solver : solvers) fc3d::run(path, file.p, solver, settings);
#ifdef TALUS_WITH_SICONOS
      if (siconos) fc3d::run_rivals(path, file, settings);
#endif
    } catch (const std::exception& e) {
      std::fprintf(stderr, "fc3d: %s: %s\n", path.c_str(), e.what());
      ++failed;
    }
  }
  return failed > 0 ? 1 : 0;
}
