// Ledgers of soft contacts when bodies change between two steps: with integrator<velocity_verlet>
// the first half of a step uses the forces that the last step has computed for the bodies then.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

using scene = scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
                       integrator<velocity_verlet>, decomposition<grid<dynamic>>,
                       transport<threads>, features<energy_ledger, momentum_balance, checkpoints>>;

constexpr real dt = 2e-4;

template <class Main>
void on(int ranks, Main&& main) {
  CAPTURE(ranks);
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scene> w(link, {.cells = {ranks}, .lower = {-4}, .upper = {4}});
    w.material({.density = 2, .restitution = 0.3, .friction = 0.4, .stiffness = 1e4});
    w.gravity({1, 0, -10});
    w.global([](auto& scope) { scope.add(plane{}, {}); });
    main(w);
  });
}

/// Grains that slide on each other, one of which is fixed.
void fill(world<scene>& w) {
  for (int x = 0; x < 6; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 3; ++z)
        w.add_if_local(body{.shape = sphere{0.47 + 0.01 * ((x + 2 * y + z) % 5)},
                            .position = {0.98 * x - 2.4, 0.98 * y, 0.49 + 0.96 * z},
                            .velocity = {0.5 * ((x + y + z) % 3 - 1), 0.3 * (y - 1), 0},
                            .angular_velocity = {0, 2.0 * (x % 2), 1},
                            .fixed = x == 3 && y == 1 && z == 1});
}

/// Some of the bodies that can move.
bool chosen(const auto& b) { return !b.is_fixed() && value_of(b.id()) % 7 == 3; }

/// Makes steps, and checks each of them.
void run(world<scene>& w, int steps) {
  for (int k = 0; k < steps; ++k) {
    CAPTURE(k);
    w.step(dt);
    const energy_balance b = measure_energy(w);
    CHECK(b.error() < 1e-13);
    CHECK(b.worst < 1e-13);
    CHECK(std::abs(b.kinetic + b.potential + b.elastic - b.initial - b.changes - b.total.net()) <
          1e-11 * b.scale);
    CHECK(measure_momentum(w).error() < 1e-12);
  }
}

/// The change of energy by `change`, after steps in which the contacts do work.
template <class Change>
void check_change(int ranks, Change&& change) {
  on(ranks, [&](auto& w) {
    fill(w);
    run(w, 150);
    const energy_balance before = measure_energy(w);
    CHECK(before.step.friction > 1e-6 * before.scale);
    change(w);
    run(w, 20);
    CHECK(std::abs(measure_energy(w).changes - before.changes) > 1e-6);
  });
}

}  // namespace

TEST_CASE("with Verlet the ledgers close in the step after bodies were removed, fixed or moved") {
  for (const int ranks : {1, 3}) {
    check_change(ranks, [](auto& w) { w.destroy_if([](const auto& b) { return chosen(b); }); });
    check_change(ranks, [](auto& w) {
      w.for_each_local([](auto b) {
        if (chosen(b)) b.fix();
      });
    });
    check_change(ranks, [](auto& w) {
      w.for_each_local([](auto b) {
        if (b.is_fixed()) b.release();
      });
      w.for_each_local([](auto b) {
        if (chosen(b)) b.set_velocity({0, 0, 3});
      });
    });
    check_change(ranks, [](auto& w) {  // to another rank
      w.for_each_local([](auto b) {
        if (chosen(b)) b.translate({b.position()[0] > 0 ? -4.0 : 4.0, 0, 4});
      });
      w.synchronize();
    });
  }
}

TEST_CASE("with Verlet the ledgers close after a restart on another number of ranks") {
  const std::string file = "/tmp/talus_soft_books_" + std::to_string(getpid()) + ".h5";
  for (const auto& [before, after] : {std::pair(2, 4), std::pair(3, 1), std::pair(1, 3)}) {
    on(before, [&](auto& w) {
      fill(w);
      run(w, 150);
      write_checkpoint(w, file);
    });
    on(after, [&](auto& w) {
      read_checkpoint(w, file);
      run(w, 20);
      CHECK(std::abs(measure_energy(w).changes) < 1e-12);
    });
  }
  unlink(file.c_str());
}
