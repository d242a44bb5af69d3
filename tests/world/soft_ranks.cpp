// Soft contacts over ranks: the same bits for every number of ranks, momentum to round-off, springs
// that migrate with the bodies; and the storage, messages and reports of a soft world.
#include <doctest/doctest.h>

#include <map>
#include <mutex>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/memory.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/observe/summary.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>
#include <type_traits>
#include <vector>

using namespace talus;

namespace {

using linear = soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>;
using hertz = soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>;
using cells = grid<dynamic, dynamic>;

template <class Law, class Integrator>
using soft_scene =
    scenario<bodies<sphere, box, plane>, Law, integrator<Integrator>, decomposition<cells>>;

const material stuff{.density = 1,
                     .restitution = 0.2,
                     .friction = 0.5,
                     .dynamic_friction = 0.4,
                     .stiffness = 1e4,
                     .youngs_modulus = 1e5,
                     .rolling_friction = 0.05};

/// Bodies that slide, roll and lie on a floor, in a few layers and of all sizes, drifting
/// diagonally over the boundaries of the ranks.
template <class World>
void set_up_heap(World& w) {
  w.material(stuff);
  w.gravity({0, 0, -10});
  w.seed(3);
  w.global([](auto& s) { s.add(plane{}, {}); });
  random_stream random(3, 1);
  const auto place = [&](real z, int k) {
    return vec3{-2.9 + 0.9 * (k % 7), -2.8 + 0.9 * (k / 7), z};
  };
  for (int k = 0; k < 49; ++k)
    w.add_if_local(body{.shape = sphere{random.uniform(0.3, 0.48)},
                        .position = place(0.45, k),
                        .velocity = {1.5, random.uniform(0.2, 0.9), 0},
                        .angular_velocity = random.uniform(vec3(-3, -3, -3), vec3(3, 3, 3))});
  for (int k = 0; k < 49; ++k)
    if (k % 3 == 0)
      w.add_if_local(body{.shape = box{{0.8, 0.6, 0.5}},
                          .position = place(0.95, k),
                          .velocity = {1.5, 0.5, 0},
                          .orientation = random.rotation()});
    else
      w.add_if_local(body{.shape = sphere{random.uniform(0.15, 0.45)},
                          .position = place(0.95, k),
                          .velocity = {1.5, 0.5, 0}});
  // Larger than all bodies so far known to the ranks to which it moves.
  w.add_if_local(body{.shape = sphere{1.1}, .position = {-5, -0.4, 1.1}, .velocity = {6, 0.3, 0}});
}

struct moment {
  vec3 position, velocity, angular_velocity;
};
struct outcome {
  std::map<system_id, moment> bodies;
  std::uint64_t crossings = 0, kept = 0;  ///< bodies that changed owner; contacts in the history
  double penetration = 0;
  std::uint64_t contacts = 0;
};

template <class Scenario>
outcome run_heap(int ranks, int steps, real dt) {
  outcome all;
  std::mutex one_by_one;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, cells{.lower = {-6, -6}, .upper = {6, 6}});
    set_up_heap(w);
    w.synchronize();
    std::uint64_t crossings = 0;
    for (int k = 0; k < steps; ++k) {
      std::map<system_id, bool> mine;
      w.for_each_local([&](const auto& b) { mine[b.id()] = true; });
      w.step(dt);
      w.for_each_local([&](const auto& b) { crossings += !mine.contains(b.id()); });
    }
    const auto figures = summarize(w, 0, 0);
    const std::lock_guard lock(one_by_one);
    all.crossings += crossings;
    all.kept += talus::detail::state_of(w).history.entries().size();
    all.penetration = figures.overlap.mean;
    all.contacts = figures.contacts;
    w.for_each_local([&](const auto& b) {
      CHECK(all.bodies.try_emplace(b.id(), moment{b.position(), b.velocity(), b.angular_velocity()})
                .second);
    });
  });
  return all;
}

template <class Scenario>
void compare_ranks(const std::string& name) {
  const auto one = run_heap<Scenario>(1, 1200, 1e-3);
  CHECK(one.kept > 40);
  for (const int ranks : {2, 4}) {
    CAPTURE(ranks);
    const auto many = run_heap<Scenario>(ranks, 1200, 1e-3);
    REQUIRE(many.bodies.size() == one.bodies.size());
    real furthest = 0, fastest = 0;
    for (const auto& [id, here] : one.bodies) {
      const moment& there = many.bodies.at(id);
      furthest = std::max(furthest, (here.position - there.position).norm());
      fastest = std::max({fastest, (here.velocity - there.velocity).norm(),
                          (here.angular_velocity - there.angular_velocity).norm()});
    }
    MESSAGE(name, ", ", ranks, " ranks against 1: positions differ by ", furthest,
            ", velocities by ", fastest, "; ", many.crossings, " changes of owner, ", many.contacts,
            " contacts");
    CHECK(many.crossings > 20);
    CHECK(furthest == 0);
    CHECK(fastest == 0);
    CHECK(many.contacts == one.contacts);
    CHECK(std::abs(many.penetration - one.penetration) < 1e-10);
  }
}

/// Spheres and boxes that fly towards a common centre, without gravity.
template <class Scenario>
void check_momentum(const std::string& name) {
  for (const int ranks : {1, 4}) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<Scenario> w(link, cells{.lower = {-6, -6}, .upper = {6, 6}});
      w.material(stuff);
      random_stream random(5, 1);
      for (int k = 0; k < 64; ++k) {
        const vec3 at = 1.1 * vec3(k % 4 - 1.5, k / 4 % 4 - 1.5, k / 16 - 1.5);
        const vec3 v = -2 * at + random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
        if (k % 4 == 0)
          w.add_if_local(body{.shape = box{{0.8, 0.7, 0.5}},
                              .position = at,
                              .velocity = v,
                              .orientation = random.rotation()});
        else
          w.add_if_local(body{.shape = sphere{random.uniform(0.3, 0.5)},
                              .position = at,
                              .velocity = v,
                              .angular_velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 2))});
      }
      w.synchronize();
      const auto before = measure_motion(w);
      std::uint64_t met = 0;
      for (int k = 0; k < 500; ++k) {
        w.step(1e-3);
        met += talus::detail::state_of(w).history.entries().size();
      }
      const auto after = measure_motion(w);
      link.reduce(reduction::sum, std::span(&met, 1));
      if (link.rank() != 0) return;
      const real scale = std::sqrt(2 * before.mass * before.kinetic_energy);
      const real linear_change = (after.momentum - before.momentum).norm() / scale;
      const real angular_change =
          (after.angular_momentum - before.angular_momentum).norm() / (3 * scale);
      MESSAGE(name, ", ", ranks, " ranks: momentum changed by ", linear_change, ", angular by ",
              angular_change, " of the scale; energy from ", before.kinetic_energy, " to ",
              after.kinetic_energy, ", ", met, " contacts in all steps");
      CHECK(met > 5000);
      CHECK(linear_change < 1e-13);
      CHECK(angular_change < 1e-12);
      CHECK(after.kinetic_energy < before.kinetic_energy);
    });
  }
}

}  // namespace

TEST_CASE("a heap that slides and rolls across boundaries moves alike on 1, 2 and 4 ranks") {
  compare_ranks<soft_scene<linear, semi_implicit_euler>>("linear, semi-implicit Euler");
  compare_ranks<soft_scene<hertz, velocity_verlet>>("Hertz, velocity Verlet");
}

TEST_CASE("colliding soft bodies conserve linear and angular momentum on 1 and 4 ranks") {
  check_momentum<soft_scene<linear, semi_implicit_euler>>("linear, semi-implicit Euler");
  check_momentum<soft_scene<hertz, velocity_verlet>>("Hertz, velocity Verlet");
}

TEST_CASE("a step sends one handover and no iterations; a dt beyond the critical one is reported") {
  using scene = soft_scene<linear, semi_implicit_euler>;
  threads::launch({.ranks = 2}, [](threads::link& link) {
    const auto figures_with = [&](real dt) {
      world<scene> w(link, cells{.lower = {-6, -6}, .upper = {6, 6}});
      w.material(stuff);
      w.gravity({0, 0, -1});
      w.global([](auto& s) { s.add(plane{}, {}); });
      for (int k = 0; k < 4; ++k)
        w.add_if_local(body{.shape = sphere{0.5}, .position = {k - 1.5, k - 1.5, 0.5}});
      w.simulate({.steps = 10, .dt = dt});
      return summarize(w, 0, 0);
    };
    const real mass = pi / 6, z = detail::damping_of_restitution(0.2);
    const real critical = 2 * (std::sqrt(1 + z * z) - z) / std::sqrt(2e4 / mass);
    const auto fine = figures_with(critical / 5), coarse = figures_with(critical * 1.01);
    CHECK(fine.messages_per_step_max == 3);  // changes, migration, shadow copies
    CHECK(fine.collectives_per_step == 0);
    CHECK(fine.critical_dt == doctest::Approx(critical));
    CHECK_FALSE(dt_above_critical(fine));
    CHECK(to_text(fine).find("warning") == std::string::npos);
    CHECK(to_json(fine).find("\"dt_above_critical\": 0") != std::string::npos);
    CHECK(dt_above_critical(coarse));
    CHECK(to_text(coarse).find("above the critical time step") != std::string::npos);
    CHECK(to_json(coarse).find("\"dt_above_critical\": 1") != std::string::npos);
    CHECK(to_json(coarse).find("\"critical_dt\": ") != std::string::npos);
  });
}

TEST_CASE("what the user moves between steps touches in the next one") {
  using scene = soft_scene<linear, semi_implicit_euler>;
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scene> w(link, cells{.lower = {-6, -6}, .upper = {6, 6}});
    w.material(stuff);
    handle<plane> ground;
    handle<box> table;
    w.global([&](auto& s) {
      ground = s.add(plane{}, {});
      table = s.add(body{.shape = box{{1, 1, 1}}, .position = {4, 0, 3}});
    });
    const auto ball = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0.7}});
    const auto other = w.add(body{.shape = sphere{0.5}, .position = {0, 3, 0.7}});
    const auto touching_after_step = [&] {
      w.step(1e-5);
      return std::get<detail::soft_contacts>(talus::detail::state_of(w).contacts).size();
    };
    CHECK(touching_after_step() == 0);
    w[ground].translate({0, 0, 0.21});
    CHECK(touching_after_step() == 2);
    CHECK(contact_force(w, ground)[2] < 0);
    CHECK(contact_force(w, ball)[2] > 0);
    w[ground].rotate(rotation({1, 0, 0}, 0.3));  // away from the second ball, into the first
    w[ground].translate({0, 0, -0.3});
    CHECK(touching_after_step() == 1);
    w[other].translate({0, -2.1, 0});
    w[ground].translate({0, 0, -3});
    CHECK(touching_after_step() == 1);
    w[other].translate({0, 5, 0});
    CHECK(touching_after_step() == 0);
    w[table].translate({-3.1, 0, -2.3});
    CHECK(touching_after_step() == 1);
    w.destroy(table);
    CHECK(touching_after_step() == 0);
    w.add(body{.shape = sphere{0.5}, .position = {0, 0, -0.25}});
    CHECK(touching_after_step() == 1);
  });
}

namespace {

using sand = scenario<bodies<sphere, plane>,
                      soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>,
                      integrator<velocity_verlet>, decomposition<grid<dynamic, dynamic>>>;

/// The force on the floor over the weight.
real pour(world<sand>& world) {
  const auto grain = world.material({.density = 2,
                                     .restitution = 0.4,
                                     .friction = 0.5,
                                     .stiffness = 1e4,
                                     .rolling_friction = 0.05});
  world.gravity({0, 0, -9.81});
  handle<plane> floor;
  world.global([&](auto& scope) { floor = scope.add(plane{}, grain); });
  const auto sites = simple_cubic{.spacing = 1} & box_region{{-3, -3, 0.4}, {3, 3, 2.6}};
  world.fill(sites, [&](const site& s, random_stream& random) {
    return body{.shape = sphere{random.uniform(0.4, 0.5)}, .position = s.position};
  });
  const real dt = critical_dt(world) / 5;
  world.simulate({.steps = 3000, .dt = dt});
  return -contact_force(world, floor)[2] / (9.81 * measure_motion(world).mass);
}

}  // namespace

TEST_CASE("the scenario of docs/soft_contacts.md: its floor bears its weight") {
  threads::launch({.ranks = 2}, [](threads::link& link) {
    world<sand> w(link, {.lower = {-6, -6}, .upper = {6, 6}});
    const real borne = pour(w);
    if (link.rank() == 0) MESSAGE("force on the floor over weight: ", borne);
    CHECK(std::abs(borne - 1) < 0.01);
  });
}

TEST_CASE("what a soft law does not name is not stored") {
  using smooth = soft_contact<linear_spring_dashpot>;
  using rough = soft_contact<linear_spring_dashpot, coulomb_friction>;
  static_assert(!smooth::remembers && rough::remembers);
  static_assert(sizeof(rough::memory) < sizeof(linear::memory));
  static_assert(
      !detail::body_store<sphere,
                          soft_scene<linear, semi_implicit_euler>::features>::keeps_contact_forces);
  static_assert(
      detail::body_store<sphere,
                         soft_scene<linear, velocity_verlet>::features>::keeps_contact_forces);
  const auto entry = [](auto* law) {
    using memory = typename std::remove_pointer_t<decltype(law)>::memory;
    return sizeof(detail::kept_contact<memory>);
  };
  MESSAGE("bytes that a contact keeps: ", entry(static_cast<rough*>(nullptr)), " with friction, ",
          entry(static_cast<linear*>(nullptr)), " with rolling too, ",
          entry(static_cast<hertz*>(nullptr)), " with Hertz' springs; a body ",
          sizeof(detail::soft_body), " for its forces");
  CHECK(entry(static_cast<rough*>(nullptr)) <= 56);

  threads::launch({.ranks = 2}, [](threads::link& link) {
    world<scenario<bodies<sphere>, smooth, decomposition<cells>>> w(
        link, cells{.lower = {-6, -6}, .upper = {6, 6}});
    w.material(stuff);
    w.add_if_local(body{.shape = sphere{0.5}, .position = {-0.4, 0, 0}, .velocity = {1, 0, 0}});
    w.add_if_local(body{.shape = sphere{0.5}, .position = {0.4, 0.1, 0}});
    w.simulate({.steps = 5, .dt = 1e-3});
    CHECK(talus::detail::state_of(w).history.entries().empty());
    CHECK(std::get<detail::soft_contacts>(talus::detail::state_of(w).contacts).size() == 1);
    CHECK_THROWS_WITH_AS(w.material({.density = 1}),
                         "a material of a scenario with linear_spring_dashpot needs a positive "
                         "stiffness, but has 0: set .stiffness",
                         std::invalid_argument);
  });
}
