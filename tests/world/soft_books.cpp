// Monitors of soft contacts between spheres: they take eight contacts at once as the forces do.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <talus/feature.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/flow.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/step/sphere_forces.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

template <class... Monitors>
using soft_scene =
    scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
             decomposition<grid<dynamic>>, transport<threads>, features<Monitors...>>;
using watched = soft_scene<energy_ledger, momentum_balance, residual_monitor>;
using watched_verlet =
    scenario<bodies<sphere, plane>, soft_contact<hertz_mindlin, coulomb_friction>,
             integrator<velocity_verlet>, decomposition<grid<dynamic>>, transport<threads>,
             features<energy_ledger>>;
template <class Integrator>
using watched_endless =
    scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
             integrator<Integrator>, decomposition<periodic<grid<dynamic>, along::x>>,
             transport<threads>, features<energy_ledger>>;

/// Before the forces of a step the springs across the normal lose a part.
struct ageing {
  using talus_part_of = roles::features;
  static constexpr const char* name = "ageing";
  struct hooks {
    static void before_detect(auto& stage) {
      stage.template for_each_memory<detail::tangential_spring<bearing>>(
          [](const auto& m) { return m.sliding == 0 && m.spring.squaredNorm() > 0; },
          [](const auto& c) { c.memory.spring = real(0.99) * c.memory.spring; });
    }
  };
};
using watched_ageing = soft_scene<ageing, energy_ledger>;

template <class Scenario>
constexpr bool is_endless = detail::is_periodic<typename Scenario::decomposition>;

/// Spheres that fall on a bed of fixed spheres, every second row of which rolls. In periodic space
/// some cross a face.
template <class Scenario, class Main>
void on(int ranks, Main&& main) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    const grid<dynamic> cells{.cells = {ranks}, .lower = {0}, .upper = {12}};
    world<Scenario> w(link, typename Scenario::decomposition{cells});
    const real shift = is_endless<Scenario> ? 0.39 : 0;
    const auto stuff = w.material({.density = 1,
                                   .restitution = 0.4,
                                   .friction = 0.5,
                                   .stiffness = 2e4,
                                   .youngs_modulus = 1e5});
    w.gravity({0.5, 0, -10});
    w.global([&](auto& s) { s.add(plane{.normal = {0, 0, 1}, .offset = -2}, stuff); });
    for (int x = 0; x < 12; ++x)
      for (int y = 0; y < 4; ++y)
        for (int z = 0; z < 4; ++z)
          w.add_if_local(
              body{.shape = sphere{z == 0 ? 0.5 : 0.42 + 0.01 * ((3 * x + y + z) % 5)},
                   .position = {x + 0.5 + shift + 0.1 * (z % 2), y + 0.1 * (z % 2), 0.97 * z},
                   .material = stuff,
                   .velocity = {z == 0 ? 0 : 0.1 * (x % 3), 0, 0},
                   .fixed = z == 0});
    w.for_each_local([](auto b) {
      if (b.is_fixed() && static_cast<int>(b.position()[1]) % 2 == 1)
        b.set_angular_velocity({0, 2, 0});
    });
    main(w);
  });
}

/// All entries after steps after each of which they are read, or after some.
template <class Scenario>
std::vector<double> entries(int ranks, bool reads) {
  std::vector<double> all;
  on<Scenario>(ranks, [&](auto& w) {
    if (reads)
      for (int k = 0; k < 300; ++k) w.step(5e-4), (void)measure_energy(w);
    else
      w.observe(every{70}, [](auto& world) { (void)measure_energy(world); }),
          w.simulate({.steps = 300, .dt = 5e-4});
    const energy_balance b = measure_energy(w);
    const auto& x = b.total;
    CHECK(b.error() < 1e-13);
    CHECK(std::abs(b.kinetic + b.potential + b.elastic - b.initial - b.changes - x.net()) <
          1e-11 * b.scale);
    detail::exact_sum exchanged = detail::view_of(w).monitors.energy.exchanged;
    detail::sum_exactly(w.link(), exchanged);
    CHECK(exchanged.value() > 0);
    if (w.rank() == 0)
      all = {b.kinetic, b.elastic, b.changes, x.work,           x.friction,
             x.impact,  x.scheme,  b.scale,   exchanged.value()};
  });
  return all;
}

}  // namespace

TEST_CASE_TEMPLATE("entries have the same bits on any ranks, however often they are read", Scenario,
                   watched, watched_verlet, watched_endless<semi_implicit_euler>,
                   watched_endless<velocity_verlet>, watched_ageing) {
  const auto one = entries<Scenario>(1, true);
  CHECK(one[1] > 0);
  const bool changes = is_endless<Scenario> || std::is_same_v<Scenario, watched_ageing>;
  CHECK((std::abs(one[2]) > 1e-5) == changes);
  if (!changes) CHECK(std::abs(one[2]) < 1e-12);
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    CHECK(entries<Scenario>(ranks, false) == one);
    CHECK(entries<Scenario>(ranks, true) == one);
  }
}

TEST_CASE("functions that only monitor the world do not make the ledger measure springs") {
  on<watched>(2, [](auto& w) {
    const flow_meter meter(w, plane{});
    int open = 0;
    const auto count = [&] { open += detail::view_of(w).monitors.springs.undisturbed; };
    w.monitor_each_step("test", count);
    w.monitor_after_observers("test", count);
    w.simulate({.steps = 10, .dt = 5e-4});
    CHECK(open == 20);
    w.after_each_step([] {});
    w.simulate({.steps = 10, .dt = 5e-4});
    CHECK(open == 30);  // the function above is called between both
  });
}

TEST_CASE("the books of spheres close in every step, on rollers, on any ranks") {
  CHECK(detail::forces_in_packs<watched, sphere, sphere, detail::partner::moving>);
  std::string bits;
  on<soft_scene<>>(1, [&](auto& w) {
    for (int k = 0; k < 1500; ++k) w.step(5e-4);
    bits = state_digest(w);
  });
  for (const int ranks : {1, 3}) {
    CAPTURE(ranks);
    on<watched>(ranks, [&](auto& w) {
      double changed = 0;
      for (int k = 0; k < 1500; ++k) {
        w.step(5e-4);
        if (k % 100 != 0) continue;
        CHECK(measure_momentum(w).error() < 1e-13);
        CHECK(measure_energy(w).error() < 1e-13);
        changed = std::max(changed, std::abs(measure_energy(w).changes));
      }
      CHECK(changed == 0);
      const energy_balance b = measure_energy(w);
      CHECK(b.worst < 1e-13);
      CHECK(std::abs(b.kinetic + b.potential + b.elastic - b.initial - b.changes - b.total.net()) <
            1e-11 * b.scale);
      // With an eighth of the time step: friction 33.100, impact 99.701.
      CHECK(b.total.work == doctest::Approx(-8.75931).epsilon(1e-5));
      CHECK(b.total.friction == doctest::Approx(32.477).epsilon(1e-5));
      CHECK(b.total.impact == doctest::Approx(99.2936).epsilon(1e-5));
      CHECK(b.total.scheme == doctest::Approx(-2.09482).epsilon(1e-5));
      const std::string here = state_digest(w);
      if (ranks == 1) CHECK(here == bits);
    });
  }
}

TEST_CASE(
    "a sphere moved between the steps changes the energy of its springs, without a new search") {
  on<watched>(1, [&](auto& w) {
    for (int k = 0; k < 400; ++k) w.step(5e-4);
    const double elastic = measure_energy(w).elastic, changes = measure_energy(w).changes;
    CHECK(elastic > 0);
    CHECK(std::abs(changes) < 1e-12);
    int n = 0;
    w.for_each_local([&](auto b) {
      if (!b.is_fixed() && n++ % 5 == 0) b.translate({0, 0, -0.002});
    });
    w.step(5e-4);
    const energy_balance after = measure_energy(w);
    CHECK(std::abs(after.changes) > 1e-6);
    CHECK(after.error() < 1e-13);
  });
}
