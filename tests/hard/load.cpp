// long
// timeout: 3600
// load [--steps N] [--ranks R] [--solver NAME]: 200,000 steps of a drum on nine ranks. Gravity
// rotates, so that bodies wander through all domains; some are added, some removed, and three are
// so large that they lie in several domains at once. No body may be lost, memory may not grow, and
// with the reproducible solver one rank alone ends with the same bits.
#define DOCTEST_CONFIG_IMPLEMENT  // the precompiled header refers to it
#include <doctest/doctest.h>
#include <malloc.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

struct outcome {
  std::string digest;
  std::uint64_t poured = 0, taken = 0, crossed = 0;
  double early_mib = 0,
         late_mib = 0;  ///< resident memory after a tenth of the steps, and at the end
  std::string wrong;
};

double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

template <class Solver>
struct drum {
  using scenario_type = scenario<bodies<sphere, box, plane>, solver<Solver>, transport<threads>,
                                 decomposition<grid<dynamic, dynamic>>>;
  using world_type = world<scenario_type>;
  static constexpr real half = 3, high = 2.5, dt = 0.004;
  static constexpr std::uint64_t most = 220;

  static void set_up(world_type& w, material_id stuff) {
    w.global([&](auto& scope) {
      for (int axis = 0; axis < 3; ++axis)
        for (const real side : {-1.0, 1.0}) {
          const real wall = axis == 2 ? high : half;
          scope.add(plane{.normal = -side * vec3(vec3::Unit(axis)), .offset = -wall}, stuff);
        }
    });
    for (const real x : {-1.6, 0.0, 1.6})  // each in four domains or more
      w.add_if_local(body{.shape = sphere{0.75}, .position = {x, 0.2 * x, -1}, .material = stuff});
  }
  static void turn_gravity(world_type& w) {
    const real t = w.time();
    w.gravity({8 * std::sin(0.5 * t), 8 * std::sin(0.31 * t + 1), 8 * std::cos(0.4 * t)});
  }
  /// A body above all others, relative to the present gravity.
  static void pour(world_type& w, random_stream& random, material_id stuff) {
    const vec3 up = -w.gravity().normalized();
    const vec3 at = vec3(up[0] * (half - 0.3), up[1] * (half - 0.3), up[2] * (high - 0.3)) +
                    random.uniform(vec3(-0.05, -0.05, -0.05), vec3(0.05, 0.05, 0.05));
    const real size = random.uniform(0.12, 0.22);
    if (random.uniform() < 0.3)
      w.add_if_local(body{.shape = box{vec3(1.4, 1.2, 1) * size},
                          .position = at,
                          .material = stuff,
                          .orientation = random.rotation()});
    else
      w.add_if_local(body{.shape = sphere{size}, .position = at, .material = stuff});
  }

  static outcome run(int ranks, std::uint64_t steps) {
    outcome result;
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world_type w(link, {.lower = {-half, -half}, .upper = {half, half}});
      const auto stuff = w.material({.restitution = 0.2, .friction = 0.4});
      set_up(w, stuff);
      random_stream random(7, 1);
      std::uint64_t bodies = w.audit().bodies, poured = 0, taken = 0, moved = 0;
      for (std::uint64_t k = 1; k <= steps; ++k) {
        turn_gravity(w);
        if (k % 25 == 0 && bodies < most) pour(w, random, stuff), ++bodies, ++poured;
        if (k % 500 == 0) {  // bodies in a corner, except the large ones
          const real side = k % 1000 == 0 ? 1 : -1;
          std::uint64_t gone = w.destroy_if([&](const auto& b) {
            return side * b.position()[0] > 0.6 * half && b.position()[1] < 0 && b.mass() < 1;
          });
          link.reduce(reduction::sum, std::span(&gone, 1));
          bodies -= gone, taken += gone;
        }
        for (const auto& n : talus::detail::state_of(w).neighbours) moved -= n.channel.taken.bodies;
        w.step(dt);
        for (const auto& n : talus::detail::state_of(w).neighbours) moved += n.channel.taken.bodies;
        if (k % 1000 == 0 && w.audit().bodies != bodies)
          throw std::runtime_error("bodies are not as many as were poured in and not taken out");
        if (link.rank() == 0 && k == steps / 2) result.early_mib = resident_mib();
        if (link.rank() == 0 && k % (steps / 10) == 0)
          std::fprintf(stderr, "%llu steps, %llu bodies, %.1f MiB\n",
                       static_cast<unsigned long long>(k), static_cast<unsigned long long>(bodies),
                       resident_mib());
      }
      const auto digest = state_digest(w);
      (void)w.audit();
      link.reduce(reduction::sum, std::span(&moved, 1));
      if (link.rank() != 0) return;
      result.digest = digest;
      result.late_mib = resident_mib();
      result.poured = poured, result.taken = taken, result.crossed = moved;
    });
    // Memory that a short run has not yet reserved does not count as growth.
    if (steps >= 100000 && result.late_mib > 1.05 * result.early_mib + 2)
      result.wrong = "memory grew";
    if (steps >= 10000 && ranks > 1 &&
        (result.crossed < steps / 100 || result.taken < steps / 1000))
      result.wrong = "too little happened";
    return result;
  }
};

struct named_solver {
  const char* name;
  outcome (*run)(int ranks, std::uint64_t steps);
  bool alike;  ///< the same on any number of ranks
};
const named_solver solvers[] = {
    {"reproducible", drum<reproducible>::run, true},
    {"nonlinear_gauss_seidel", drum<nonlinear_gauss_seidel>::run, false},
};

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t steps = 200000;
  int ranks = 9;
  std::string name = solvers[0].name;
  for (int k = 1; k + 1 < argc; k += 2) {
    const std::string word = argv[k];
    if (word == "--steps") steps = std::strtoull(argv[k + 1], nullptr, 10);
    if (word == "--ranks") ranks = std::atoi(argv[k + 1]);
    if (word == "--solver") name = argv[k + 1];
  }
  if (steps < 10) steps = 10;
  mallopt(M_ARENA_MAX, 1);  // excludes glibc's arenas of each thread from the measurement
  for (const named_solver& s : solvers) {
    if (name != s.name) continue;
    try {
      outcome o = s.run(ranks, steps);
      if (s.alike && ranks > 1)
        if (const std::string alone = s.run(1, steps).digest; alone != o.digest)
          o.wrong = "one rank ends with other bits: " + alone;
      std::printf(
          "%s, %d ranks, %llu steps: %llu bodies poured in, %llu taken out, %llu handed over "
          "between "
          "ranks, none lost; %.1f MiB after a tenth of the steps, %.1f MiB at the end; digest %s\n",
          s.name, ranks, static_cast<unsigned long long>(steps),
          static_cast<unsigned long long>(o.poured), static_cast<unsigned long long>(o.taken),
          static_cast<unsigned long long>(o.crossed), o.early_mib, o.late_mib, o.digest.c_str());
      if (o.wrong.empty()) return 0;
      std::fprintf(stderr, "load: %s\n", o.wrong.c_str());
    } catch (const std::exception& e) {
      std::fprintf(stderr, "load: %s\n", e.what());
    }
    return 1;
  }
  std::fprintf(stderr, "load: there is no solver %s\n", name.c_str());
  return 2;
}
