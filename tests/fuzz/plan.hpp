#pragma once
// The parameters of a fuzzed run, drawn from its seed: numbers only, so that one compiled type of
// scenario serves thousands of runs.
#include <set>
#include <string>
#include <talus/core/error.hpp>
#include <talus/core/random.hpp>

namespace fuzz {

using talus::real;
using talus::vec3;

enum class subject {
  cloud,  ///< no gravity, nothing fixed: momentum and energy are those of the bodies alone
  heap,   ///< gravity, walls of planes, bodies that overlap nothing at first: energy does not grow
  disturbed,  ///< the same, with bodies added, removed, pushed and moved in the run, and deep
              ///< overlaps
  wild        ///< a few extreme numbers: the run works, or ends with a message
};
enum class domains { grid, hexagonal, ring, slabs, cells };

struct plan {
  std::uint64_t seed;
  subject what;
  domains how;
  int ranks;
  int steps;
  real dt;
  int bodies;
  real ratio;     ///< largest over smallest size
  real smallest;  ///< radius
  real gravity, friction, restitution, density, speed;
  int iterations, correction_iterations;
  real correction, tolerance;
  int look_every;                    ///< steps between checks of all invariants
  real reach;                        ///< of the neighbourhood
  static constexpr real side = 2.5;  ///< half the edge of the scene
  std::set<int> without;             ///< items of a mechanism that are left out
  bool shrinks = false;              ///< a mechanism that fails
};

inline plan draw(std::uint64_t seed) {
  talus::random_stream r(seed, 1);
  plan p{};
  p.seed = seed;
  const real x = r.uniform();
  p.what = x < 0.35   ? subject::cloud
           : x < 0.65 ? subject::heap
           : x < 0.93 ? subject::disturbed
                      : subject::wild;
  p.how = static_cast<domains>(r.integer(5));
  p.ranks = p.how == domains::hexagonal ? (r.integer(4) ? 7 : 1)
            : p.how == domains::ring    ? 2 + static_cast<int>(r.integer(8))
                                        : 1 + static_cast<int>(r.integer(9));
  p.steps = 20 + static_cast<int>(r.integer(100));
  p.dt = 0.002 * std::exp(r.uniform(0, 2));
  p.bodies = 2 + static_cast<int>(r.integer(r.integer(2) ? 20 : 120));
  p.ratio = std::exp(r.uniform() < 0.5 ? 0 : r.uniform(0, std::log(30.0)));
  p.smallest = 0.4 / std::pow(p.ratio, 0.6) * r.uniform(0.5, 1);
  p.gravity = p.what == subject::cloud ? 0 : 20 * r.uniform();
  p.friction = r.integer(3) ? r.uniform(0, 1) : 0;
  p.restitution = r.integer(2) ? r.uniform(0, 1) : 0;
  p.density = std::exp(r.uniform(-3, 3));
  p.speed = r.integer(4) || p.what == subject::cloud ? r.uniform(0, 6) : 0;
  p.iterations = 1 + static_cast<int>(r.integer(20));
  p.correction_iterations = static_cast<int>(r.integer(5));
  p.correction = r.uniform();
  p.tolerance = r.integer(5) ? 0 : std::pow(10.0, -r.uniform(1, 5));
  p.look_every = 1 + static_cast<int>(r.integer(8));
  p.reach = r.integer(2) ? 0 : r.uniform(0, 3);
  return p;
}

/// The same with sizes of 1 : 10 to 1 : 10,000 in a third of the runs, and half of them on one
/// rank, where contacts add no energy in any step, to round-off.
inline plan for_shapes(plan p) {
  talus::random_stream r(p.seed, 4);
  if (r.integer(3) == 0) {
    p.ratio = std::pow(10.0, r.uniform(1, 4));
    p.smallest = r.uniform(0.4, 0.8) / p.ratio;
  }
  if (r.integer(2) == 0) p.ranks = 1, p.how = domains::slabs;
  return p;
}

inline std::string text(const plan& p) {
  static const char* const subjects[] = {"cloud", "heap", "stirred", "wild"};
  static const char* const kinds[] = {"grid", "hexagonal", "ring", "slabs", "cells"};
  return std::string(subjects[int(p.what)]) + ", " + kinds[int(p.how)] + " of " +
         std::to_string(p.ranks) + ", " + std::to_string(p.bodies) +
         " bodies of 1 : " + talus::detail::text(p.ratio, 3) + ", " + std::to_string(p.steps) +
         " steps of dt = " + talus::detail::text(p.dt, 3);
}

/// The violated invariant; the run stops.
struct broken : std::logic_error {
  using std::logic_error::logic_error;
};
/// The result of a run.
struct outcome {
  std::string refused;  ///< the message it ended with, if it did
  std::string digest;   ///< of the final state, else
  std::uint64_t crossed = 0, contacts = 0;
  bool chaotic = false;  ///< so that runs of the default solver were not compared
  real energy_gain = 0;  ///< over the scale of the energy; see checks.hpp
  real momentum_error = 0;
};

outcome run_spheres(const plan& p);     ///< nonlinear Gauss-Seidel
outcome run_solids(const plan& p);      ///< spheres, boxes, capsules and unions
outcome run_jacobi(const plan& p);      ///< spheres, accelerated Jacobi, sleeping islands
outcome run_springs(const plan& p);     ///< spheres with soft contacts
outcome run_alike(const plan& p);       ///< spheres and boxes, the same bits as on one rank
outcome run_around(const plan& p);      ///< the same in a periodic box, or the default solver there
outcome run_pursued(const plan& p);     ///< spheres and boxes with continuous collision
outcome run_midway(const plan& p);      ///< the same with the midpoint
outcome run_shapes(const plan& p);      ///< every shape, or few; degenerate poses, 1 : 10,000
outcome run_mechanisms(const plan& p);  ///< joints of all kinds
outcome run_mechanisms_around(const plan& p);  ///< the same in a periodic box

}  // namespace fuzz
