// The lines of a table have the same bits on any ranks where the motion has.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <random>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/fields.hpp>
#include <talus/observe/flow.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/time_series.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/outflow.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

using namespace talus;

namespace {

using falling =
    scenario<bodies<sphere, box, plane>, solver<reproducible>,
             hard_contact<coulomb_friction, newton_restitution>,
             decomposition<grid<dynamic, dynamic>>, transport<threads>,
             features<checkpoints, damping, penetration_monitor, momentum_balance, energy_ledger>>;

std::vector<double> values(world<falling>& w, handle<plane> floor, const flow_meter<falling>& meter,
                           const outflow& landed, coarse_fields& mean) {
  std::vector<double> all;
  for (const measured& m : measure_run(w)) all.push_back(m.value);
  const vec3 force = contact_force(w, floor), torque = contact_torque(w, floor, {0.1, 0, 0});
  const momentum_account p = measure_momentum(w);
  for (int k = 0; k < 3; ++k)
    all.insert(all.end(), {force[k], torque[k], p.after[k], p.ground[k], p.gravity[k]});
  const coarse_fields now = measure_fields(w, mean.grid());
  mean += now;
  for (const coarse_fields* f : {&std::as_const(now), &std::as_const(mean)})
    for (std::size_t c = 0; c < f->grid().size(); ++c) {
      all.insert(all.end(), {f->bodies(c), f->mass(c), f->solid_fraction(c)});
      for (int i = 0; i < 3; ++i) {
        all.push_back(f->velocity(c)[i]);
        for (int j = 0; j < 3; ++j)
          all.insert(all.end(), {f->kinetic_stress(c)(i, j), f->contact_stress(c)(i, j)});
      }
    }
  const flow through = meter.total();
  const removed gone = landed.total(w);
  all.insert(all.end(), {static_cast<double>(gone.count), gone.mass});
  all.insert(all.end(), {through.mass_forward, through.mass_backward, p.mass, p.size});
  return all;
}

/// The values of every tenth step on rank 0. With a number of `ranks_before` it is restarted from
/// a checkpoint of so many in the middle.
std::vector<double> table(int ranks, int ranks_before = 0) {
  const std::string file = "/tmp/talus_exact_tables_" + std::to_string(getpid()) + ".h5";
  std::vector<double> all;
  const auto run = [&](int on, bool restarts, int steps) {
    threads::launch({.ranks = on}, [&](threads::link& link) {
      world<falling> w(link, grid<dynamic, dynamic>{.lower = {-4, -4}, .upper = {4, 4}});
      w.gravity({0.3, -0.2, -9.81});
      w.damping(0.9);
      const auto stuff = w.material({.density = 1.3, .restitution = 0.4, .friction = 0.3});
      handle<plane> floor;
      w.global([&](auto& scope) { floor = scope.add(plane{}, stuff); });
      const outflow landed = remove_in(w, box_region{{1, -4, 0}, {4, 4, 0.4}});
      if (restarts) {
        read_checkpoint(w, file);
      } else {
        std::mt19937_64 random(7);
        std::uniform_real_distribution<real> some(-1, 1);
        for (int k = 0; k < 200; ++k) {
          const vec3 at(3 * some(random), 3 * some(random), 1.5 + some(random));
          const vec3 v(some(random), some(random), some(random));
          if (k % 2 == 0)
            w.add_if_local(body{.shape = sphere{0.15 + 0.02 * some(random)},
                                .position = at,
                                .material = stuff,
                                .velocity = v});
          else
            w.add_if_local(body{
                .shape = box{{0.2, 0.3, 0.25}}, .position = at, .material = stuff, .velocity = v});
        }
      }
      w.synchronize();
      const flow_meter<falling> meter(w, plane{.normal = {0, 0, -1}, .offset = -0.8});
      coarse_fields mean({.lower = {-4, -4, 0}, .upper = {4, 4, 3}, .cells = {3, 2, 3}});
      for (int k = 0; k < steps; k += 10) {
        w.simulate({.steps = 10, .dt = 1. / 240});
        const auto line = values(w, floor, meter, landed, mean);
        if (link.rank() == 0) all.insert(all.end(), line.begin(), line.end());
      }
      if (ranks_before > 0 && !restarts) write_checkpoint(w, file);
    });
  };
  if (ranks_before > 0) {
    run(ranks_before, false, 100), run(ranks, true, 100);
    unlink(file.c_str());
  } else {
    run(ranks, false, 100);
  }
  return all;
}

}  // namespace

TEST_CASE("tables of a reproducible run have the same bits on any ranks") {
  const auto one = table(1);
  REQUIRE(one.size() > 100);
  MESSAGE(one[one.size() - 6], " bodies were removed");
  CHECK(one[one.size() - 6] > 10);
  for (const int ranks : {2, 3, 4}) {
    CAPTURE(ranks);
    CHECK(table(ranks) == one);
  }
}

TEST_CASE("so have those that go on after a restart on other ranks") {
  const auto one = table(1, 1);
  for (const int ranks : {3, 4}) {
    CAPTURE(ranks);
    CHECK(table(ranks, 2) == one);
  }
}

TEST_CASE("sums over terms of any sizes go on in a restart without a digit less") {
  const std::string file = "/tmp/talus_sizes_of_terms_" + std::to_string(getpid()) + ".h5";
  const auto run = [&](int on, bool restarts) {
    threads::launch({.ranks = on}, [&](threads::link& link) {
      world<falling> w(link, grid<dynamic, dynamic>{.lower = {-4, -4}, .upper = {4, 4}});
      const auto stuff = w.material({.density = 1.3});
      if (restarts)
        read_checkpoint(w, file);
      else
        for (const double speed : {3e10, 0.7, 1e-9, 3e-34, 1e-60, 1e-77, 7e-110, 1e-150})
          w.add_if_local(body{.shape = sphere{0.1},
                              .position = {1e-9 + std::log10(speed) / 50, 0.5, 0.5},
                              .material = stuff,
                              .velocity = {0, 0, speed}});
      w.synchronize();
      w.simulate({.steps = 3, .dt = 1e-12});
      const energy_balance e = measure_energy(w);
      CHECK(e.changes == 0);
      CHECK(e.closure == 0);
      if (!restarts) write_checkpoint(w, file);
    });
  };
  for (const int before : {1, 3})
    for (const int after : {1, 2, 3, 4}) {
      CAPTURE(before);
      CAPTURE(after);
      run(before, false), run(after, true);
    }
  unlink(file.c_str());
}
