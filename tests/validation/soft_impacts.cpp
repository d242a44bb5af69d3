// Soft contacts in impacts: any restitution, time steps that resolve a contact, rigid walls.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/summary.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>

#include "record.hpp"

using namespace talus;
using namespace talus::validation;

namespace {

using linear = soft_contact<linear_spring_dashpot, coulomb_friction>;
using hertz = soft_contact<hertz_mindlin, coulomb_friction>;
template <class Law, class Integrator>
using soft_scene =
    scenario<bodies<sphere, box, plane>, Law, integrator<Integrator>, transport<serial>>;
using linear_euler = soft_scene<linear, semi_implicit_euler>;
using hertz_verlet = soft_scene<hertz, velocity_verlet>;

constexpr real radius = 0.5;

struct rebound {
  real restitution = 0;
  int steps = 0;     ///< with an overlap
  real pull = 0;     ///< the largest decrease of the speed of separation over the impact speed
  bool over = true;  ///< the spheres have separated
};

/// Two spheres that meet head on at a relative speed; dt is that, or a fifth of critical_dt(world).
template <class Scenario>
rebound collide(const material& m, real speed, real dt, int most_steps = 100000) {
  serial::link link;
  world<Scenario> w(link);
  w.material(m);
  const auto a = w.add(
      body{.shape = sphere{radius}, .position = {-radius, 0, 0}, .velocity = {speed / 2, 0, 0}});
  const auto b = w.add(
      body{.shape = sphere{radius}, .position = {radius, 0, 0}, .velocity = {-speed / 2, 0, 0}});
  if (dt == 0) dt = critical_dt(w) / 5;
  rebound r;
  const auto leaving = [&] { return (w[b].velocity() - w[a].velocity())[0]; };
  const auto overlap = [&] { return 2 * radius - (w[b].position() - w[a].position())[0]; };
  real fastest = leaving();
  do {
    w.step(dt);
    ++r.steps;
    fastest = std::max(fastest, leaving());
    r.pull = std::max(r.pull, (fastest - leaving()) / speed);
    r.over = !(overlap() > 0);
  } while (!r.over && r.steps < most_steps);
  w.step(dt);
  r.restitution = leaving() / speed;
  CHECK((w[a].velocity() + w[b].velocity()).norm() < 1e-13 * speed);
  return r;
}

const real half_mass = 4.0 / 3 * pi * radius * radius * radius / 2;
const real k = 1e5, period = pi * std::sqrt(half_mass / k);

}  // namespace

TEST_CASE("the restitution of an impact is that of the material, down to 0, for both laws") {
  // 300 steps in a linear contact; Hertz: in an undamped one of Johnson's duration.
  const real modulus = 1e6, effective = modulus / (2 * (1 - 0.25 * 0.25));
  const auto run = [&]<class Scenario>(Scenario*, const std::string& name, real duration) {
    for (const real e : {1.0, 0.8, 0.5, 0.2, 0.14, 0.13, 0.1, 0.05, 0.02, 0.01}) {
      const material m{.restitution = e, .stiffness = k, .youngs_modulus = modulus};
      const std::string test = talus::detail::compose("{}, e = {}", name, e);
      const auto fine = collide<Scenario>(m, 2, duration / 4000);
      CHECK(fine.over);
      check_relative(test, "restitution", e, fine.restitution, 0.01);
      check_error(test, "pull", fine.pull, 1e-12);
      const auto coarse = collide<Scenario>(m, 2, duration / 100);
      check_absolute(test, "restitution, 100 steps", e, coarse.restitution, 0.02);
    }
    // A restitution of 0, which is the default, is one of 0.005; also in coarse steps.
    const material m{.stiffness = k, .youngs_modulus = modulus};
    for (const int steps : {4000, 200, 50, 20})
      check_absolute(talus::detail::compose("{}, e = 0, {} steps", name, steps), "restitution",
                     0.005, collide<Scenario>(m, 2, duration / steps).restitution,
                     steps > 100 ? 0.002 : 0.1);
  };
  run(static_cast<linear_euler*>(nullptr), "linear impact", period);
  const real deepest = std::pow(15 * half_mass * 4 / (16 * effective * std::sqrt(radius / 2)), 0.4);
  run(static_cast<hertz_verlet*>(nullptr), "Hertz impact", 2.94 * deepest / 2);
}

TEST_CASE("a fifth of the critical time step takes 20 to 50 steps in a contact, at any speed") {
  const auto run = [&]<class Scenario>(Scenario*, const material& m, const std::string& name) {
    for (const real speed : {0.01, 1.0, 10.0, 100.0})
      for (const real e : {1.0, 0.9, 0.5, 0.14}) {
        material of_e = m;
        of_e.restitution = e;
        const auto hit = collide<Scenario>(of_e, speed, 0);
        const std::string test = talus::detail::compose("{} at {}, e = {}", name, speed, e);
        check_at_least(test, "steps", 20, hit.steps);
        if (speed == 10 && e >= 0.5) CHECK(hit.steps <= 50);
        check_absolute(test, "restitution", e, hit.restitution, 0.05);
      }
  };
  run(static_cast<linear_euler*>(nullptr), {.stiffness = 1e5}, "linear impact");
  // Glass in SI units, and softened glass.
  run(static_cast<hertz_verlet*>(nullptr), {.density = 2500, .youngs_modulus = 7e10}, "glass");
  run(static_cast<hertz_verlet*>(nullptr), {.density = 2500, .youngs_modulus = 7e7}, "soft glass");
}

TEST_CASE("critical_dt takes the impact speed from motion and falls, or as an argument") {
  const material glass{.density = 2500, .restitution = 1, .youngs_modulus = 1e7};
  const auto of = [&](const vec3& velocity, real height, real g, auto&&... speed) {
    serial::link link;
    world<hertz_verlet> w(link);
    w.material(glass);
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{}, {}); });
    w.add(body{.shape = sphere{radius}, .position = {0, 0, height + radius}, .velocity = velocity});
    w.add(body{.shape = sphere{radius}, .position = {5, 0, height + radius}});
    return critical_dt(w, speed...);
  };
  const real stable = of({0, 0, 0}, 1, 0);
  CHECK(of({0, 0, 0}, 1, 0, 0) == stable);  // nothing moves: stability alone
  const real at_20 = of({0, 0, 0}, 0, 0, 20);
  CHECK(at_20 < stable);
  CHECK(of({10, 0, 0}, 0, 0) == doctest::Approx(at_20));          // 2 x 10
  CHECK(of({0, 0, 0}, 20, 10) == doctest::Approx(at_20));         // 2 g h = 400
  CHECK(of({0, 0, 0}, 0, 0, 640) == doctest::Approx(at_20 / 2));  // speed to the power -1/5
  CHECK_THROWS_WITH_AS(of({0, 0, 0}, 0, 0, -1),
                       "the impact speed of critical_dt must be finite and not negative, but is "
                       "-1: give the largest relative speed at which bodies meet",
                       std::invalid_argument);
}

TEST_CASE("critical_dt takes a body with a mass of its own for as large as it is") {
  const auto of = [&](real density, bool own) {
    serial::link link;
    world<hertz_verlet> w(link);
    w.material({.density = density, .restitution = 1, .youngs_modulus = 1e7});
    for (const real x : {0., 5.}) {
      body b{.shape = sphere{radius}, .position = {x, 0, 0}};
      if (own) b.mass = 2500 * b.shape.volume();
      w.add(b);
    }
    return critical_dt(w, 200);
  };
  CHECK(of(2.5, true) == doctest::Approx(of(2500, false)).epsilon(1e-12));
  CHECK(of(2.5, false) < 0.5 * of(2500, false));
}

TEST_CASE("the summary warns of contacts with fewer than 20 steps, at the speed that occurred") {
  const auto figures = [&](real part) {
    serial::link link;
    world<hertz_verlet> w(link);
    w.material({.density = 2500, .restitution = 1, .youngs_modulus = 7e7});
    w.add(body{.shape = sphere{radius}, .position = {-0.6, 0, 0}, .velocity = {5, 0, 0}});
    w.add(body{.shape = sphere{radius}, .position = {0.6, 0, 0}, .velocity = {-5, 0, 0}});
    const real dt = part * critical_dt(w);
    w.simulate({.steps = static_cast<std::uint64_t>(0.1 / dt), .dt = dt});
    return summarize(w, 0, 0);
  };
  const auto fine = figures(0.2), coarse = figures(0.4);
  CHECK(fine.impact_speed_max == doctest::Approx(10));
  CHECK(fine.steps_per_contact == doctest::Approx(21));
  CHECK_FALSE(contacts_unresolved(fine));
  CHECK(to_text(fine).find("warning") == std::string::npos);
  CHECK(contacts_unresolved(coarse));
  CHECK(to_text(coarse).find("takes 10.5 steps") != std::string::npos);
  CHECK(to_json(coarse).find("\"steps_per_contact\": 10.5") != std::string::npos);
}

TEST_CASE("a step above the critical one is warned of before the run, with both numbers") {
  serial::link link;
  world<hertz_verlet> w(link);
  w.material({.density = 2500, .restitution = 1, .youngs_modulus = 7e7});
  w.add(body{.shape = sphere{radius}, .velocity = {5, 0, 0}});
  const real longest = critical_dt(w, 0);
  CHECK(talus::detail::unstable_step(w, 0.99 * longest).empty());
  CHECK(talus::detail::unstable_step(w, 2 * longest) ==
        "dt " + talus::detail::text(2 * longest, 6) + " is above the critical time step " +
            talus::detail::text(longest, 4) +
            " of the soft contacts: the results will mean nothing; take a fifth of it or less");
}

TEST_CASE("against a rigid wall the stiffness is that of the body alone") {
  // A sphere at rest on a wall: m g over the stiffness, for walls of each kind.
  const real g = 10, weight = 2 * half_mass * g;
  const auto rest = [&]<class Scenario>(Scenario*, const material& grain, const material& wall,
                                        bool of_box) {
    serial::link link;
    world<Scenario> w(link);
    const auto of_wall = w.material(wall), of_grain = w.material(grain);
    w.gravity({0, 0, -g});
    if (of_box)
      w.add(body{
          .shape = box{{4, 4, 1}}, .position = {0, 0, -0.5}, .material = of_wall, .fixed = true});
    else
      w.global([&](auto& s) { s.add(plane{}, of_wall); });
    const auto h =
        w.add(body{.shape = sphere{radius}, .position = {0, 0, radius}, .material = of_grain});
    const real dt = critical_dt(w) / 5;
    for (int n = 0; n < 4000; ++n) w.step(dt);
    return radius - w[h].position()[2];
  };
  const auto of_linear = static_cast<linear_euler*>(nullptr);
  const auto of_hertz = static_cast<hertz_verlet*>(nullptr);
  const material grain{.restitution = 0.1, .stiffness = 1e4, .youngs_modulus = 1e5};
  const material wall{.restitution = 0.1, .stiffness = rigid, .youngs_modulus = rigid};
  // Two springs of 2 k each in series make k.
  check_relative("rigid plane", "overlap, linear", weight / 2e4,
                 rest(of_linear, grain, wall, false), 1e-9);
  check_relative("rigid box", "overlap, linear", weight / 2e4, rest(of_linear, grain, wall, true),
                 1e-9);
  const real effective = 1e5 / (1 - 0.25 * 0.25);
  const real on_plane = std::pow(weight / (4.0 / 3 * effective * std::sqrt(radius)), 2.0 / 3);
  check_relative("rigid plane", "overlap, Hertz", on_plane, rest(of_hertz, grain, wall, false),
                 1e-6);
  material stiff = wall;
  stiff.stiffness = stiff.youngs_modulus = 1e30;
  CHECK(rest(of_hertz, grain, stiff, true) == doctest::Approx(rest(of_hertz, grain, wall, true)));
}

TEST_CASE("a body that moves is not rigid") {
  const std::string refusal =
      "a sphere that moves cannot be of a rigid material: give that material a finite .stiffness, "
      "or add the body in world.global(...) or with .fixed = true";
  serial::link link;
  world<linear_euler> w(link);
  const auto stone = w.material({.stiffness = rigid});
  const body grain{.shape = sphere{radius}, .material = stone};
  CHECK_THROWS_WITH_AS(w.add(grain), refusal.c_str(), std::invalid_argument);
  CHECK_THROWS_WITH_AS(w.add_if_local(grain), refusal.c_str(), std::invalid_argument);
  CHECK(w.local_bodies() == 0);
  body still = grain;
  still.fixed = true;
  const auto h = w.add(still);
  CHECK_THROWS_WITH_AS(w[h].release(), refusal.c_str(), std::invalid_argument);
  CHECK(w[h].is_fixed());
  CHECK_THROWS_AS(w.material({.stiffness = -rigid}), std::invalid_argument);
}
