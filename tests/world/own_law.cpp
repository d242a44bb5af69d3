// A user-defined law in a scenario: the liquid bridges of examples/own_law act beyond touch, over
// ranks and sides of a periodic box, on driven bodies, and in the energy ledger.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <mutex>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/summary.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/each_contact.hpp>
#include <talus/world/world.hpp>
#include <type_traits>
#include <utility>

#include "../../examples/own_law/liquid_bridge.hpp"

using namespace talus;

namespace {

using wet_grains =
    soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance, liquid_bridge>;
using domains = grid<dynamic, dynamic>;
template <class Integrator, class... Features>
using wet_scene = scenario<bodies<sphere, box, plane>, wet_grains, integrator<Integrator>,
                           decomposition<domains>, features<driven, Features...>>;

const material grain{
    .density = 1, .restitution = 0.3, .friction = 0.4, .stiffness = 1e4, .rolling_friction = 0.05};
const liquid_bridge::parameters water{.tension = 2, .angle = 0.2, .volume = 1e-2};
const real rupture = 1.1 * std::cbrt(1e-2);

/// The work that breaks a bridge between two bodies of this effective radius.
real work_of_rupture(real radius) {
  const contact_kinematics touch{.gap = 0, .radius = radius};
  return -liquid_bridge::stored(touch, water, {.wet = true}).normal;
}

template <class World>
void set_up_grains(World& w) {
  const auto m = w.material(grain);
  w.interaction(m, m, water);
  w.gravity({0, 0, -10});
  w.global([&](auto& s) { s.add(plane{}, m); });
  random_stream random(11, 1);
  for (int k = 0; k < 60; ++k) {
    const vec3 at{-2.5 + 0.9 * (k % 6), -2.2 + 0.9 * (k / 6 % 5), 0.5 + 0.9 * (k / 30)};
    const vec3 v = vec3(1.2, 0.6, 0) + random.uniform(vec3(-0.5, -0.5, -1), vec3(0.5, 0.5, 1));
    if (k % 5 == 0)
      w.add_if_local(body{.shape = box{{0.6, 0.5, 0.7}},
                          .position = at,
                          .velocity = v,
                          .orientation = random.rotation()});
    else
      w.add_if_local(
          body{.shape = sphere{random.uniform(0.2, 0.45)}, .position = at, .velocity = v});
  }
}

struct outcome {
  std::string digest;
  std::uint64_t contacts = 0, beyond = 0, crossings = 0;
  real closure = 0, scheme = 0, dissipated = 0;
};
template <class Scenario>
outcome run_grains(int ranks) {
  outcome all;
  std::mutex mutex;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
    set_up_grains(w);
    std::uint64_t crossings = 0;
    for (int k = 0; k < 3000; ++k) {
      std::uint64_t mine = 0, still = 0;
      w.for_each_local([&](const auto& b) { mine += static_cast<std::uint64_t>(b.id()); });
      w.step(2e-4);
      w.for_each_local([&](const auto& b) { still += static_cast<std::uint64_t>(b.id()); });
      crossings += mine != still;
    }
    const std::string digest = state_digest(w);
    const auto figures = summarize(w, 0, 0);
    // Attractive forces at a positive gap.
    std::uint64_t beyond = 0;
    detail::each_loaded_contact(talus::detail::state_of(w),
                                [&](const loaded_contact& c, bool counts) {
                                  beyond += counts && c.force.dot(c.normal) < 0;
                                });
    link.reduce(reduction::sum, std::span(&beyond, 1));
    real closure = 0, scheme = 0, dissipated = 0;
    if constexpr (Scenario::template has_feature<energy_ledger>) {
      const auto e = measure_energy(w);
      closure = e.worst, scheme = e.total.scheme, dissipated = e.total.friction + e.total.impact;
    }
    const std::lock_guard lock(mutex);
    all.crossings += crossings;
    if (link.rank() != 0) return;
    all.digest = digest, all.contacts = figures.contacts, all.beyond = beyond;
    all.closure = closure, all.scheme = scheme, all.dissipated = dissipated;
  });
  return all;
}

/// Wet spheres and boxes move alike on 1, 2 and 4 ranks.
template <class Scenario>
void compare_ranks() {
  const outcome one = run_grains<Scenario>(1);
  CHECK(one.beyond > 0);
  CHECK(one.contacts > 60);
  for (const int ranks : {2, 4}) {
    CAPTURE(ranks);
    const outcome many = run_grains<Scenario>(ranks);
    CHECK(many.digest == one.digest);
    CHECK(many.contacts == one.contacts);
    CHECK(many.beyond == one.beyond);
    CHECK(many.crossings > 2);
    if constexpr (Scenario::template has_feature<energy_ledger>) {
      CHECK(many.closure < 1e-10);
      CHECK(many.scheme == doctest::Approx(one.scheme));
      CHECK(many.dissipated == doctest::Approx(one.dissipated));
      CHECK(std::abs(one.scheme) < 0.2 * one.dissipated);  // of first order in dt
    }
  }
}

/// Two spheres that touch and fly apart along x: the kinetic energy that they lose, and the last
/// gap at which a force acts.
template <class Integrator>
std::pair<real, real> pull_apart(int ranks) {
  const real speed = 2, r = 0.5, dt = 1e-4;
  // Verlet computes the contact for the first time after a step.
  const bool later = std::is_same_v<Integrator, velocity_verlet>;
  const real overlap = (later ? 2 * speed * dt : 0) + 1e-9;
  std::pair<real, real> result;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scenario<bodies<sphere>, soft_contact<linear_spring_dashpot, liquid_bridge>,
                   integrator<Integrator>, decomposition<domains>>>
        w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
    const auto m = w.material(grain);
    w.interaction(m, m, water);
    for (const int side : {-1, 1})
      w.add_if_local(body{.shape = sphere{r},
                          .position = {side * (r - 0.5 * overlap), 0, 0},
                          .velocity = {side * speed, 0, 0}});
    const real before = measure_motion(w).kinetic_energy;
    real end = 0;
    for (int k = 0; k < 1500; ++k) {
      w.step(dt);
      std::array<double, 2> sums{};  // gap, by the symmetry, and contacts
      w.for_each_local([&](const auto& b) { sums[0] += std::abs(b.position()[0]) - r; });
      for_each_contact(w, [&](const loaded_contact&) { sums[1] += 1; });
      link.reduce(reduction::sum, std::span<double>(sums));
      if (sums[1] > 0) end = sums[0];
    }
    const real after = measure_motion(w).kinetic_energy;
    if (link.rank() == 0) result = {before - after, end};
  });
  return result;
}

}  // namespace

TEST_CASE("wet spheres and boxes move alike on 1, 2 and 4 ranks, and the books close") {
  compare_ranks<wet_scene<semi_implicit_euler, energy_ledger>>();
  compare_ranks<wet_scene<velocity_verlet, energy_ledger>>();
}

TEST_CASE("a bridge breaks at its distance, and costs the work of the closed form") {
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    for (const auto& [lost, end] :
         {pull_apart<semi_implicit_euler>(ranks), pull_apart<velocity_verlet>(ranks)}) {
      CHECK(end == doctest::Approx(rupture).epsilon(3e-3));
      CHECK(lost == doctest::Approx(work_of_rupture(0.25)).epsilon(5e-3));
    }
  }
}

TEST_CASE("a bridge acts across the sides of a periodic box") {
  using around = scenario<bodies<sphere>, soft_contact<linear_spring_dashpot, liquid_bridge>,
                          decomposition<periodic<grid<dynamic>, along::x>>>;
  std::string digest;
  for (const int ranks : {1, 3}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<around> w(link, {{.cells = {ranks, 1, 1}, .lower = {-4, -4}, .upper = {4, 4}}},
                      reach{2});
      const auto m = w.material(grain);
      w.interaction(m, m, water);
      // They touch across the side, and separate; the bridge pulls them back.
      w.add_if_local(
          body{.shape = sphere{0.5}, .position = {-3.51, 0, 0}, .velocity = {0.3, 0, 0}});
      w.add_if_local(
          body{.shape = sphere{0.5}, .position = {3.51, 0, 0}, .velocity = {-0.3, 0, 0}});
      real widest = -1;
      for (int k = 0; k < 3000; ++k) {
        w.step(1e-4);
        std::array<double, 1> gap{};
        w.for_each_local([&](const auto& b) { gap[0] += 3.5 - std::abs(b.position()[0]); });
        link.reduce(reduction::sum, std::span<double>(gap));
        widest = std::max(widest, gap[0]);
      }
      const std::string now = state_digest(w);
      std::uint64_t contacts = 0;
      for_each_contact(w, [&](const loaded_contact&) { ++contacts; });
      link.reduce(reduction::sum, std::span(&contacts, 1));
      if (link.rank() != 0) return;
      CHECK(contacts == 1);
      CHECK(widest > 1e-3);
      CHECK(widest < rupture);
      CHECK((digest.empty() || now == digest));
      digest = now;
    });
  }
}

TEST_CASE("a driven plate lifts a wet grain, and a dry one stays") {
  for (const bool wet : {false, true}) {
    CAPTURE(wet);
    threads::launch({.ranks = 2}, [&](threads::link& link) {
      world<wet_scene<semi_implicit_euler>> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
      const auto m = w.material(grain);
      auto liquid = water;
      if (!wet) liquid.volume = 0;
      w.interaction(m, m, liquid);
      w.gravity({0, 0, -10});
      handle<plane> floor, plate;
      w.global([&](auto& s) {
        floor = s.add(plane{.offset = -3}, m);
        plate = s.add(plane{.normal = {0, 0, -1}, .offset = -0.4999}, m);
      });
      w.drive(plate, gliding{{0, 0, 0.5}});
      const auto h = w.add_if_local(body{.shape = sphere{0.5}, .position = {0.3, 0.3, 0}});
      for (int k = 0; k < 10000; ++k) w.step(1e-4);
      const vec3 pull = contact_force(w, plate);
      if (h && wet) CHECK(w[*h].position()[2] == doctest::Approx(0.5).epsilon(0.02));
      if (h && !wet) CHECK(w[*h].position()[2] < -2);
      // The hanging body's weight acts on the plate.
      const real weight = 10 * pi / 6;
      CHECK(pull[2] == doctest::Approx(wet ? -weight : 0).epsilon(0.02));
    });
  }
}

TEST_CASE("parameters of pairs: given, derived, asked for, changed, and missing") {
  using scene = scenario<bodies<sphere>, soft_contact<linear_spring_dashpot, liquid_bridge>,
                         decomposition<domains>>;
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scene> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
    const auto a = w.material(grain), b = w.material(grain);
    w.interaction(a, b, water);
    CHECK(w.template interaction<liquid_bridge>(b, a) == water);
    CHECK(w.template interaction<linear_spring_dashpot>(a, b).stiffness == doctest::Approx(1e4));
    w.interaction(a, b, linear_spring_dashpot::parameters{.stiffness = 7});
    CHECK(w.template interaction<linear_spring_dashpot>(b, a).stiffness == 7);
    CHECK(w.template interaction<linear_spring_dashpot>(a, a).stiffness == doctest::Approx(1e4));
    CHECK_THROWS_AS(w.interaction(a, material_id{7}, water), std::invalid_argument);
    CHECK_THROWS_WITH_AS((void)w.template interaction<liquid_bridge>(a, a),
                         "liquid_bridge has no parameters for the materials 0 and 0: give them to "
                         "world.interaction, as a value of liquid_bridge::parameters",
                         std::runtime_error);
    w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0}, .material = a});
    w.add(body{.shape = sphere{0.5}, .position = {0.99, 0, 0}, .material = b});
    w.step(1e-4);
    CHECK(std::get<detail::soft_contacts>(talus::detail::state_of(w).contacts).size() == 1);
    w.add(body{.shape = sphere{0.5}, .position = {-0.99, 0, 0}, .material = a});
    CHECK_THROWS_WITH_AS(w.step(1e-4),
                         "bodies of the materials 0 and 0 touch, and liquid_bridge has no "
                         "parameters for that pair: give them to world.interaction, as a value of "
                         "liquid_bridge::parameters",
                         std::runtime_error);
  });
}

TEST_CASE("a law that acts beyond touch takes few materials, and says so") {
  using scene = scenario<bodies<sphere>, soft_contact<linear_spring_dashpot, liquid_bridge>,
                         decomposition<domains>>;
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scene> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
    for (int k = 0; k < 65; ++k) w.material(grain);
    w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0}});
    CHECK_THROWS_WITH_AS(w.step(1e-4),
                         "a contact law that acts beyond touch takes at most 64 materials, and "
                         "this world has 65: reuse some of them",
                         std::runtime_error);
  });
}

TEST_CASE("a pair within range without a bridge is no contact") {
  using scene = scenario<bodies<sphere>, soft_contact<linear_spring_dashpot, liquid_bridge>,
                         decomposition<domains>>;
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scene> w(link, domains{.lower = {-4, -4}, .upper = {4, 4}});
    const auto m = w.material(grain);
    w.interaction(m, m, water);
    w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0}});
    const auto b = w.add(body{.shape = sphere{0.5}, .position = {1.1, 0, 0}});
    w.step(1e-5);
    CHECK(std::get<detail::soft_contacts>(talus::detail::state_of(w).contacts).size() == 0);
    w[b].translate({-0.11, 0, 0});
    w.step(1e-5);
    CHECK(std::get<detail::soft_contacts>(talus::detail::state_of(w).contacts).size() == 1);
    w[b].translate({0.11, 0, 0});  // apart, and joined
    w.step(1e-5);
    CHECK(std::get<detail::soft_contacts>(talus::detail::state_of(w).contacts).size() == 1);
    CHECK(contact_force(w, b)[0] < 0);
    w[b].translate({0.3, 0, 0});
    w.step(1e-5);
    w[b].translate({-0.3, 0, 0});  // back, and dry
    w.step(1e-5);
    CHECK(std::get<detail::soft_contacts>(talus::detail::state_of(w).contacts).size() == 0);
    CHECK(contact_force(w, b)[0] == 0);
    // A law added to a running world reaches farther from the next step on.
    auto more = water;
    more.volume = 1;
    w.interaction(m, m, more);
    w[b].translate({-0.11, 0, 0});
    w.step(1e-5);
    w[b].translate({0.6, 0, 0});
    w.step(1e-5);
    CHECK(std::get<detail::soft_contacts>(talus::detail::state_of(w).contacts).size() == 1);
  });
}
