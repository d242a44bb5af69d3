// Moving cuts, with all other features of a scenario: monitors, sleeping islands, soft contacts,
// shapes that share data, continuous collision.
// long
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <talus/observe/balance.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/bisection.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/reach.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <variant>
#include <vector>

using namespace talus;

namespace {

constexpr bisection<dynamic>::bound low{-4, -4}, high{4, 4};
const vec3 tilted{5, 4, -7};

template <class World>
void walls(World& w) {
  w.global([&](auto& s) {
    s.add(plane{.normal = {0, 0, 1}}, {});
    for (const double side : {-1.0, 1.0}) {
      s.add(plane{.normal = {side, 0, 0}, .offset = -4}, {});
      s.add(plane{.normal = {0, side, 0}, .offset = -4}, {});
    }
  });
}
template <class World>
void spheres(World& w, std::size_t count) {
  const auto sites =
      simple_cubic{.spacing = 0.8, .origin = {-3.6, -3.6, 0.5}} & vertical_cylinder{.radius = 3.4};
  w.fill(sites.first(count), [](const site& place, random_stream& random) {
    return body{.shape = sphere{random.uniform(0.2, 0.39)},
                .position = place.position,
                .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0))};
  });
}

/// Runs program(world) on ranks that share the square.
template <class Scenario, class Program>
void on(int ranks, Program&& program) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {.lower = low, .upper = high});
    program(w);
  });
}

/// Other cuts each time.
bisection<dynamic> other_cuts(int ranks, int k) {
  serial::link alone;
  random_stream random(5, static_cast<std::uint64_t>(k));
  std::vector<vec3> places;
  for (int i = 0; i < 40; ++i) places.push_back(random.uniform(vec3(-4, -4, 0), vec3(4, 4, 3)));
  const bisection<dynamic> box{.lower = low, .upper = high};
  return box.shared_out(alone, std::span<const vec3>(places), 1, ranks);
}

}  // namespace

TEST_CASE("books of energy and momentum close while bodies change their ranks") {
  using scene =
      scenario<bodies<sphere, plane>, decomposition<bisection<dynamic>>, transport<threads>,
               features<balancing, forces, energy_ledger, momentum_balance>>;
  on<scene>(5, [](auto& w) {
    w.gravity(tilted);
    w.material({.restitution = 0.2, .friction = 0.4});
    walls(w);
    spheres(w, 300);
    w.balance({.every = 4, .above = 1.02, .by = balance_by::count});
    double worst = 0, momentum = 0;
    for (int k = 0; k < 300; ++k) {
      w.step(1.0 / 240);
      const energy_balance e = measure_energy(w);
      worst = std::max(worst, e.error());
      momentum = std::max(momentum, measure_momentum(w).error());
      CHECK(std::abs(e.changes) < 1e-9 * e.scale);
      CHECK(e.kinetic + e.potential == doctest::Approx(e.initial + e.total.net()).epsilon(1e-11));
    }
    CHECK(worst < 1e-12);
    CHECK(momentum < 1e-11);
    CHECK(measure_balance(w).moved > 20);
  });
}

TEST_CASE(
    "what sleeps goes on sleeping on its new rank, and wakes with what its contacts remember") {
  using scene = scenario<bodies<sphere, plane>, decomposition<bisection<dynamic>>,
                         transport<threads>, features<balancing, sleeping, damping>>;
  std::array<double, 2> speed{}, overlap{};
  for (const bool moving : {false, true})
    on<scene>(4, [&](auto& w) {
      w.gravity({0, 0, -9});
      w.damping(0.1);
      w.sleeping({.speed = 0.3, .time = 0.1});
      w.material({.restitution = 0, .friction = 0.5});
      walls(w);
      spheres(w, 50);  // one layer: a heap goes on rolling for long
      motion before;
      for (int k = 0; k < 2000; ++k) {
        w.step(1.0 / 240);
        if (k % 50 == 0) before = measure_motion(w);
        if (before.asleep == before.movable) break;
      }
      REQUIRE(before.asleep == before.movable);
      const std::string digest = state_digest(w);
      std::size_t here = w.local_bodies(), changed = 0;
      for (int k = 0; k < 20; ++k) {
        if (moving) w.decompose(other_cuts(4, k), reach{1});
        if (moving && k % 3 == 2) w.balance({.every = 1, .above = 1.01, .by = balance_by::count});
        w.step(1.0 / 240);
        changed += w.local_bodies() != here;
        here = w.local_bodies();
      }
      CHECK(measure_motion(w).asleep == before.asleep);
      CHECK(state_digest(w) == digest);
      if (moving && w.rank() == 0) CHECK(changed > 1);
      w.wake();
      w.step(1.0 / 240);
      const motion after = measure_motion(w);
      const penetration deep = measure_penetration(w);
      if (w.rank() == 0) speed[moving] = after.max_speed, overlap[moving] = deep.mean;
    });
  MESSAGE("fastest after waking " << speed[0] << " and " << speed[1]);
  CHECK(speed[1] < 1.5 * speed[0] + 0.01);
  CHECK(overlap[1] < 1.5 * overlap[0] + 1e-6);
}

TEST_CASE("springs of soft contacts go with the bodies") {
  using scene = scenario<bodies<sphere, plane>,
                         soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>,
                         integrator<velocity_verlet>, decomposition<bisection<dynamic>>,
                         transport<threads>, features<balancing, energy_ledger, momentum_balance>>;
  std::vector<double> kinetic;
  const auto course = [&](int ranks, bool moving) {
    on<scene>(ranks, [&](auto& w) {
      w.gravity(tilted);
      w.material({.density = 1,
                  .restitution = 0.2,
                  .friction = 0.5,
                  .youngs_modulus = 1e5,
                  .rolling_friction = 0.05});
      walls(w);
      spheres(w, 150);
      if (moving) w.balance({.every = 5, .above = 1.02, .by = balance_by::count});
      for (int k = 0; k < 400; ++k) {
        w.step(5e-4);
        const energy_balance e = measure_energy(w);
        CHECK(e.error() < 1e-11);
        CHECK(std::abs(e.changes) < 1e-9 * e.scale);
        CHECK(measure_momentum(w).error() < 1e-10);
      }
      const motion m = measure_motion(w);
      if (moving) CHECK(measure_balance(w).moved > 20);
      if (w.rank() == 0) kinetic.push_back(m.kinetic_energy);
    });
  };
  course(1, false), course(4, false), course(4, true), course(7, true);
  for (const double k : kinetic) CHECK(k == doctest::Approx(kinetic[0]).epsilon(1e-9));
}

TEST_CASE("shapes that turn, and unions that share their form: the bits of one rank") {
  using dumbbell = union_of<sphere, capsule>;
  using scene =
      scenario<bodies<sphere, box, dumbbell, plane>, solver<reproducible>,
               decomposition<bisection<dynamic>>, transport<threads>, features<balancing>>;
  std::string one;
  for (const int ranks : {1, 4, 7})
    for (const std::uint64_t every : {3, 50}) {
      std::string digest;
      on<scene>(ranks, [&](auto& w) {
        w.gravity(tilted);
        w.material({.restitution = 0.2, .friction = 0.4});
        walls(w);
        const dumbbell two{{{.shape = sphere{0.3}, .at = {{0.2, 0, 0}}},
                            {.shape = capsule{0.2, 0.3}, .at = {{-0.2, 0, 0}}}}};
        w.fill((simple_cubic{.spacing = 1.1, .origin = {-3.3, -3.3, 0.7}} &
                vertical_cylinder{.radius = 3.6})
                   .first(150),
               [&](const site& place, random_stream& random) {
                 std::variant<body<sphere>, body<box>, body<dumbbell>> made;
                 const auto put = [&](const auto& shape) {
                   made = body{.shape = shape,
                               .position = place.position,
                               .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0)),
                               .orientation = random.rotation()};
                 };
                 switch (place.index % 3) {
                   case 0:
                     put(sphere{random.uniform(0.2, 0.4)});
                     break;
                   case 1:
                     put(box{random.uniform(vec3(0.4, 0.4, 0.3), vec3(0.7, 0.6, 0.6))});
                     break;
                   default:
                     put(two);
                 }
                 return made;
               });
        w.balance({.every = every, .above = 1.01, .by = balance_by::count});
        for (int k = 0; k < 250; ++k) w.step(1.0 / 240);
        const std::string found = state_digest(w);
        if (w.rank() == 0) digest = found;
      });
      if (one.empty()) one = digest;
      CHECK(digest == one);
    }
}

TEST_CASE("bodies that are followed on their way go to their new ranks too") {
  using scene = scenario<bodies<sphere, plane>, decomposition<bisection<dynamic>>,
                         transport<threads>, features<balancing, continuous_collision>>;
  std::array<double, 2> overlap{};
  for (const bool moving : {false, true})
    on<scene>(5, [&](auto& w) {
      w.gravity(tilted);
      w.material({.restitution = 0.3, .friction = 0.3});
      walls(w);
      spheres(w, 300);
      if (moving) w.balance({.every = 4, .above = 1.05, .by = balance_by::count});
      for (int k = 0; k < 200; ++k) w.step(1.0 / 240);
      CHECK(w.audit().bodies == 300);
      const double mean = measure_penetration(w).mean;
      const load_balance shares = measure_balance(w);
      if (w.rank() == 0) overlap[moving] = mean;
      const bool moved = shares.moved > 20, even = shares.after.bodies < real(1.2);
      CHECK(moved == moving);
      CHECK(even == moving);
    });
  MESSAGE("mean overlaps " << overlap[0] << " and " << overlap[1]);
  CHECK(overlap[1] < 1.3 * overlap[0]);
}

TEST_CASE("a decomposition chosen at run time moves its cuts if it is a bisection") {
  using scene = scenario<bodies<sphere, plane>, decomposition<any_decomposition>,
                         transport<threads>, features<balancing>>;
  const auto on_four = [](auto program) {
    threads::launch({.ranks = 4}, [&](threads::link& link) {
      world<scene> w(link, bisection<dynamic>{.lower = low, .upper = high});
      w.gravity(tilted);
      w.material({.restitution = 0.2, .friction = 0.2});
      walls(w);
      spheres(w, 100);
      program(w);
    });
  };
  on_four([](auto& w) {
    w.balance({.every = 5, .above = 1.05, .by = balance_by::count});
    for (int k = 0; k < 60; ++k) w.step(1.0 / 240);
    CHECK(measure_balance(w).moved >= 1);
    CHECK(w.divided().template as<bisection<dynamic>>()->cuts.size() == 3);
  });
  const char* refused = "choose bisection<dynamic>";
  CHECK_THROWS_WITH_AS(on_four([](auto& w) {
                         w.decompose(grid<2, 2>{});
                         w.step(1.0 / 240);
                         w.balance({});
                       }),
                       doctest::Contains(refused), std::invalid_argument);
  CHECK_THROWS_WITH_AS(on_four([](auto& w) {
                         w.balance({});
                         w.decompose(grid<2, 2>{});
                       }),
                       doctest::Contains(refused), std::invalid_argument);
}
