// Frictional contact problems from files, solved through the assembled Delassus operator.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>

#include "fc3d/problem.hpp"
#include "talus/response/solve_assembled.hpp"
#ifdef TALUS_WITH_HDF5
#include "fc3d/fclib.hpp"
#endif
#ifdef TALUS_WITH_SICONOS
#include "fc3d/siconos.hpp"
#endif

namespace fc3d {

inline double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

assembled_problem read(const std::string& path) {
  const std::string bytes = contents(path);
  if (bytes.rfind("\211HDF\r\n\032\n", 0) != 0) return read_text(bytes);
#ifdef TALUS_WITH_HDF5
  return read_fclib(path);
#else
  fail<std::runtime_error>(
      "is in HDF5, and this program was built without it; install libhdf5-dev and build again");
#endif
}

struct settings {
  double tolerance = 1e-6, seconds = 20;
};

void print(const std::string& path, int contacts, const std::string& solver, double tolerance,
           int iterations, double milliseconds, const talus::detail::contact_error& e) {
  std::printf("%s\t%d\t%s\t%g\t%d\t%.4g\t%.3e\t%.3e\t%.3e\t%d\n",
              std::filesystem::path(path).filename().c_str(), contacts, solver.c_str(), tolerance,
              iterations, milliseconds, e.scaled, e.by_q, e.relative, e.scaled <= tolerance);
  std::fflush(stdout);
}

void run(const std::string& path, const assembled_problem& p, const std::string& solver,
         const settings& s) {
  // What is over in no time is measured several times; the median counts.
  std::vector<double> times;
  talus::detail::assembled_result result;
  vecx r;
  double total = 0;
  while (times.empty() || (total < 0.02 && times.size() < 9)) {
    r = vecx::Zero(p.q.size());
    const double start = cpu_seconds();
    result = talus::detail::solve_assembled(p, r, s.tolerance, 1'000'000,
                                            [&] { return cpu_seconds() - start < s.seconds; });
    times.push_back(cpu_seconds() - start);
    total += times.back();
  }
  std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
  print(path, p.contacts(), solver, s.tolerance, result.iterations, 1e3 * times[times.size() / 2],
        talus::detail::error_of(p, r));
}

}  // namespace fc3d

int main(int argc, char** argv) {
  CLI::App app{"Solve frictional contact problems from files (Siconos' text, FCLIB's HDF5)"};
  std::vector<std::string> files;
  std::string solver = "hybrid";
  fc3d::settings settings;
  app.add_option("files", files, "problems; those that are not there are skipped");
  app.add_option("--solver", solver, "hybrid");
  app.add_option("--tol", settings.tolerance, "largest err_scaled")->capture_default_str();
  app.add_option("--max-seconds", settings.seconds, "CPU time for each problem and solver")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  std::printf(
      "#file\tcontacts\tsolver\ttol\titerations\tcpu_ms\terr_scaled\terr_q\terr_rel\t"
      "converged\n");
  int failed = 0;
  for (const auto& path : files) {
    if (!std::filesystem::exists(path)) {
      std::fprintf(stderr, "fc3d: %s is not there, skipped\n", path.c_str());
      continue;
    }
    try {
      fc3d::run(path, fc3d::read(path), solver, settings);
    } catch (const std::exception& e) {
      std::fprintf(stderr, "fc3d: %s: %s\n", path.c_str(), e.what());
      ++failed;
    }
  }
  return failed > 0 ? 1 : 0;
}
