// Driven bodies with all solvers and both kinds of contacts: nothing passes a wall, and the energy
// ledger closes.
// long
// timeout: 900
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/solver/accelerated_jacobi.hpp>
#include <talus/solver/substepping.hpp>

#include "driven_mixer.hpp"

using namespace driven_mixer;

namespace {

template <class Scenario>
void mix(double most_overlap, real dt = 0.005, double round_off = 1e-11) {
  for (const int ranks : {1, 4})
    on<Scenario>(ranks, [&](auto& w) {
      const parts p = set_up_mixer(w);
      real side = -4;
      double overlap = 0;
      for (int k = 0; k * dt < 0.8; ++k) {
        side += dt * 0.3 * std::sin(dt * (k + 0.5));
        w.step(dt);
        if (k % 20 == 0) overlap = std::max(overlap, measure_penetration(w).max);
      }
      CHECK(std::abs(w[p.side].shape().offset - side) < 1e-12);
      CHECK(overlap < most_overlap);
      CHECK(measure_energy(w).worst < round_off);
      CHECK(measure_energy(w).total.work > 0.1);
      CHECK(measure_momentum(w).error() < round_off);
      w.for_each_local([&](const auto& b) { CHECK(b.position()[2] > -0.2); });
      (void)w.audit();
    });
}

}  // namespace

TEST_CASE("all solvers stir and shake, and the books close") {
  mix<mixer<watched>>(0.3);
  mix<mixer<watched, solver<substepping>>>(0.3);
  mix<mixer<watched, solver<accelerated_jacobi>>>(0.4);
  mix<mixer<watched, precision<mixed_precision>>>(0.3, 0.005, 1e-6);
}

TEST_CASE("so do soft contacts") {
  mix<mixer<watched, soft_contact<linear_spring_dashpot, coulomb_friction>>>(0.3, 0.001);
  mix<mixer<watched, soft_contact<hertz_mindlin, coulomb_friction>, integrator<velocity_verlet>>>(
      0.5, 0.001);
}

TEST_CASE("a soft ball takes on the speed of a belt, and bounces off a wall that comes") {
  using scene = mixer<soft_contact<linear_spring_dashpot, coulomb_friction>, watched>;
  on<scene>(1, [&](auto& w) {
    const auto stuff =
        w.material({.density = 2, .restitution = 0.5, .friction = 0.5, .stiffness = 1e5});
    handle<plane> wall;
    w.global([&](auto& s) { wall = s.add(plane{.normal = {1, 0, 0}, .offset = -3}, stuff); });
    w.drive(wall, gliding{{2, 0, 0}});
    const auto h = w.add(sphere{0.5}, stuff, {0, 0, 0});
    for (int k = 0; k < 4000; ++k) w.step(0.0005);
    CHECK(w[h].velocity()[0] == doctest::Approx(3).epsilon(0.02));
  });
}
