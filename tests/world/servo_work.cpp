// The energy ledger books under `work` what a servo does: its force times its way.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/energy.hpp>
#include <talus/observe/force.hpp>

#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

template <class... Policies>
using scene = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, split_correction>,
                       transport<threads>, decomposition<grid<dynamic>>, Policies...>;

/// Spheres in a cell with a lid that presses, from the middle of the run on three times as hard:
/// the booked work of the lid is the sum of its force times its way, and all entries add up.
template <class Scenario>
void press(int ranks) {
  threads::launch({.ranks = ranks}, [](threads::link& link) {
    world<Scenario> w(link, {.lower = {-2}, .upper = {2}});
    w.gravity({0, 0, -10});
    const auto m = w.material({.density = 2, .friction = 0.3});
    handle<plane> lid;
    w.global([&](auto& s) {
      s.add(plane{}, m);
      lid = s.add(plane{.normal = {0, 0, -1}, .offset = -4}, m);
      for (const double q : {-1., 1.}) {
        s.add(plane{.normal = {q, 0, 0}, .offset = -2}, m);
        s.add(plane{.normal = {0, q, 0}, .offset = -2}, m);
      }
    });
    w.fill(simple_cubic{.spacing = 1} & box_region{{-2, -2, 0.2}, {2, 2, 3}},
           [&](const site& place, random_stream& random) {
             return body{.shape = sphere{random.uniform(0.3, 0.48)},
                         .position = place.position,
                         .material = m};
           });
    double sum = 0, worst = 0;
    for (int n = 0; n < 2000; ++n) {
      if (n % 1000 == 0) w.hold_force(lid, {.force = n == 0 ? 300. : 900., .max_speed = 1});
      const real from = w[lid].position()[2];
      w.step(2e-3);
      sum += -contact_force(w, lid)[2] * (w[lid].position()[2] - from);
      worst = std::max(worst, std::abs(measure_energy(w).error()));
    }
    const auto e = measure_energy(w);
    CHECK(sum > 1);
    CHECK(e.total.work == doctest::Approx(sum).epsilon(1e-9));
    CHECK(worst < 1e-12);
    CHECK(e.kinetic + e.potential == doctest::Approx(e.initial + e.total.net()).epsilon(1e-11));
  });
}

}  // namespace

TEST_CASE("the work of a servo on hard contacts is its force times its way") {
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    press<scene<features<driven, energy_ledger>>>(ranks);
    press<scene<features<energy_ledger, driven>, integrator<moreau_midpoint>>>(ranks);
  }
}
