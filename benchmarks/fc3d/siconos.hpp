#pragma once
// Siconos (Acary, Pérignon) on the same problems. Its solvers may change the problem, print, crash
// or never return, so each runs in a process of its own, on a copy, with a limit of CPU time.
#include <FrictionContactProblem.h>
#include <Friction_cst.h>
#include <NonSmoothDrivers.h>
#include <NumericsVerbose.h>
#include <SolverOptions.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <string>
#include <vector>

#include "problem.hpp"
#include "timing.hpp"

extern "C" void openblas_set_num_threads(int) __attribute__((weak));

namespace fc3d {

struct rival {
  const char* name;
  int id;
  int iterations;  ///< the most; its defaults give up early
  std::function<void(SolverOptions&)> set = {};
};

inline std::vector<rival> rivals() {
  const auto none = [](SolverOptions&) {};
  return {
      {"siconos-nsgs", SICONOS_FRICTION_3D_NSGS, 10'000'000,
       [](SolverOptions& o) {
         o.iparam[SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION] =
             SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_FULL;
       }},
      {"siconos-prox", SICONOS_FRICTION_3D_PROX, 10'000, none},
      {"siconos-nsn-ac", SICONOS_FRICTION_3D_NSN_AC, 10'000, none},
      {"siconos-nsn-fb", SICONOS_FRICTION_3D_NSN_FB, 10'000, none},
      {"siconos-admm", SICONOS_FRICTION_3D_ADMM, 1'000'000,
       [](SolverOptions& o) {
         o.iparam[SICONOS_FRICTION_3D_ADMM_IPARAM_RHO_STRATEGY] =
             SICONOS_FRICTION_3D_ADMM_RHO_STRATEGY_RESIDUAL_BALANCING;
       }},
      {"siconos-vi-eg", SICONOS_FRICTION_3D_VI_EG, 10'000'000, none},
  };
}

/// The problem in Siconos' text format, W in blocks.
inline std::string as_text(const assembled_problem& p) {
  const int n = p.contacts();
  const auto blocks = static_cast<int>(p.block.size());
  std::string s = fmt::format("3\n{}\n1\n{}\n{}\n{}\n{}\n{}\n", n, 3 * n, 3 * n, blocks, n, n);
  for (int twice = 0; twice < 2; ++twice) {
    for (int i = 1; i <= n; ++i) s += fmt::format("{} ", 3 * i);
    s += '\n';
  }
  s += fmt::format("{}\n{}\n", n + 1, blocks);
  for (const auto k : p.start) s += fmt::format("{} ", k);
  s += '\n';
  for (const auto k : p.column) s += fmt::format("{} ", k);
  for (int k = 0; k < blocks; ++k) {
    s += fmt::format("\n{}", k);
    for (const real x : std::span(p.block[static_cast<std::size_t>(k)].data(), 9))
      s += fmt::format(" {:.17g}", x);
  }
  for (const real x : p.q) s += fmt::format("\n{:.17g}", x);
  for (const real x : p.mu) s += fmt::format("\n{:.17g}", x);
  return s + "\n";
}

struct rival_result {
  contact_vector r;
  int iterations = 0;
  double seconds = 0;
};

/// Waits for a child; ends it once it has used so much CPU time. Whether it ended well by itself.
/// (A timer inside the child would make its clock coarse.)
inline bool ends_within(pid_t child, double seconds) {
  clockid_t clock{};
  const bool known = clock_getcpuclockid(child, &clock) == 0;
  for (double waited = 0;;) {
    int status = 0;
    if (waitpid(child, &status, WNOHANG) != 0) return WIFEXITED(status);
    const double used = known ? seconds_of(clock) : waited;
    if (used > seconds || waited > 20 * seconds + 10) break;
    const double pause = waited < 0.1 ? 1e-3 : 0.02;
    usleep(static_cast<useconds_t>(1e6 * pause));
    waited += pause;
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  return false;
}

/// Solves the problem of `text`. Siconos stops at err_rel, so it is given ever smaller tolerances
/// until err_scaled is reached; the time is that of the last try alone.
inline rival_result run_rival(const rival& way, const assembled_problem& p, const std::string& text,
                              double tolerance, double seconds) {
  struct report {
    double error = HUGE_VAL, seconds = 0;
    int iterations = 0;
  };
  const std::size_t size = sizeof(report) + static_cast<std::size_t>(p.q.size()) * sizeof(double);
  void* shared = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) fail<std::runtime_error>("no memory to share with Siconos");
  auto* best = new (shared) report;
  double* best_r = reinterpret_cast<double*>(best + 1);

  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, 1);
    dup2(nowhere, 2);
    if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
    numerics_set_verbose(0);
    std::string copy = text;
    for (double own = tolerance; own > 1e-15; own *= 0.1) {
      contact_vector r;
      int iterations = 0, info = 0;
      const double spent = median_seconds([&](auto&& timed) {
        FILE* file = fmemopen(copy.data(), copy.size(), "r");
        FrictionContactProblem* problem = frictionContact_newFromFile(file);
        std::fclose(file);
        SolverOptions* options = solver_options_create(way.id);
        options->iparam[SICONOS_IPARAM_MAX_ITER] = way.iterations;
        options->dparam[SICONOS_DPARAM_TOL] = own;
        way.set(*options);
        r.set_zero(p.contacts());
        contact_vector u = r;
        timed([&] { info = fc3d_driver(problem, r.data(), u.data(), options); });
        iterations = options->iparam[SICONOS_IPARAM_ITER_DONE];
        solver_options_delete(options);
        frictionContactProblem_free(problem);
      });
      const double error = talus::detail::error_of(p, r).scaled;
      if (error < best->error) {
        std::copy(r.begin(), r.end(), best_r);
        best->error = error;
        best->iterations = iterations;
        best->seconds = spent;
      }
      if (error <= tolerance || info != 0) break;
    }
    _exit(0);
  }
  const bool ended = child > 0 && ends_within(child, seconds);
  const rival_result result{contact_vector(best_r, p.contacts()), best->iterations,
                            ended || best->error <= tolerance ? best->seconds : seconds};
  munmap(shared, size);
  return result;
}

}  // namespace fc3d
