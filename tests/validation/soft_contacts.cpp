// Soft contacts against closed forms: impacts, sliding, sticking, rolling, rest, energy.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "record.hpp"

using namespace talus;
using namespace talus::validation;

namespace {

constexpr real g = 9.81;

using linear = soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>;
using hertz = soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>;

template <class Law, class Integrator = semi_implicit_euler>
using soft_scene =
    scenario<bodies<sphere, box, plane>, Law, integrator<Integrator>, transport<serial>>;

template <class Scenario>
struct scene {
  serial::link link;
  world<Scenario> w{link};

  explicit scene(const material& m, real weight = 0) {
    w.material(m);
    w.gravity({0, 0, -weight});
  }
  scene& floor(real angle = 0) {
    w.global([&](auto& s) { s.add(plane{.normal = {std::sin(angle), 0, std::cos(angle)}}, {}); });
    return *this;
  }
  handle<sphere> ball(real radius, const vec3& position, const vec3& velocity = {0, 0, 0},
                      const vec3& spin = {0, 0, 0}) {
    return w.add(body{.shape = sphere{radius},
                      .position = position,
                      .velocity = velocity,
                      .angular_velocity = spin});
  }
};

/// Two equal spheres that meet head on, with the relative speed 2.
struct impact {
  real restitution = 0, duration = 0, overlap = 0;  ///< the time of overlap, the largest overlap
  real energy_error = 0;                            ///< largest, over the energy at the start
};
constexpr real impact_radius = 0.5, impact_speed = 2;

/// `phase` is the part of a step between the first touch and the step before it.
template <class Scenario>
impact collide_spheres(const material& m, real dt, real phase, real half_speed = 1) {
  scene<Scenario> s(m);
  const real gap = 2 * half_speed * dt * phase;
  const auto a = s.ball(impact_radius, {-impact_radius - gap / 2, 0, 0}, {half_speed, 0, 0});
  const auto b = s.ball(impact_radius, {impact_radius + gap / 2, 0, 0}, {-half_speed, 0, 0});
  const real mass = s.w[a].mass(), energy = mass * half_speed * half_speed;
  impact r;
  real last = -gap, entered = -1;
  for (int k = 1;; ++k) {
    s.w.step(dt);
    const vec3 d = s.w[b].position() - s.w[a].position();
    const real now = 2 * impact_radius - d[0], crossing = (k - now / (now - last)) * dt;
    r.overlap = std::max(r.overlap, now);
    real elastic = 0.5 * m.stiffness * now * now;
    if (m.stiffness == 0)
      elastic = 8.0 / 15 * m.youngs_modulus / (2 * (1 - m.poisson_ratio * m.poisson_ratio)) *
                std::sqrt(impact_radius / 2) * std::pow(std::max(real{0}, now), 2.5);
    const real total =
        0.5 * mass * (s.w[a].velocity().squaredNorm() + s.w[b].velocity().squaredNorm()) +
        (now > 0 ? elastic : 0);
    r.energy_error = std::max(r.energy_error, std::abs(total / energy - 1));
    if (last <= 0 && now > 0) entered = crossing;
    if (last > 0 && now <= 0) {
      r.duration = crossing - entered;
      break;
    }
    last = now;
    REQUIRE(k < 1000000);
  }
  r.restitution = (s.w[b].velocity()[0] - s.w[a].velocity()[0]) / (2 * half_speed);
  CHECK((s.w[a].velocity() + s.w[b].velocity()).norm() < 1e-14);
  return r;
}

/// The mean over phases of |f(impact)|.
template <class Scenario, class F>
real mean_error(const material& m, real dt, F&& f) {
  const int phases = 8;
  real sum = 0;
  for (int k = 0; k < phases; ++k)
    sum += std::abs(f(collide_spheres<Scenario>(m, dt, (k + 0.5) / phases)));
  return sum / phases;
}

/// The order of convergence from `coarse` to `coarse`/8.
template <class F>
real order_of(real coarse, F&& error) {
  return std::log2(error(coarse) / error(coarse / 8)) / 3;
}

const real impact_mass = 4.0 / 3 * pi * std::pow(impact_radius, 3) / 2;  // reduced

}  // namespace

TEST_CASE("linear springs: restitution and duration of an impact are those of the closed form") {
  // Schwager, Poeschel 2007: the force lasts 2 acos(z) / (w0 sqrt(1 - z^2)), pi / w0 for e = 1;
  // then the spheres separate at e v from the remaining overlap 2 z e v / w0.
  const real k = 1e5, w0 = std::sqrt(k / impact_mass), dt = pi / w0 / 400;
  const auto run = [&]<class Scenario>(Scenario*, const std::string& name) {
    for (const real e : {1.0, 0.9, 0.5, 0.2}) {
      const material m{.restitution = e, .stiffness = k};
      const real z = talus::detail::damping_of_restitution(e);
      const real force = z < 1 ? 2 * std::acos(z) / std::sqrt(1 - z * z) / w0 : 2 / w0;
      const real overlapping = force + 2 * z / w0;
      const auto hit = collide_spheres<Scenario>(m, dt, 0.4);
      const std::string test = talus::detail::compose("linear impact, {}, e = {}", name, e);
      check_absolute(test, "restitution", e, hit.restitution, 0.01);
      check_relative(test, "time of overlap", overlapping, hit.duration, 0.01);
      const real of_e = order_of(dt, [&](real step) {
        return mean_error<Scenario>(m, step, [&](const impact& r) { return r.restitution - e; });
      });
      // A dashpot starts with a jump of the force, which the steps resolve to first order.
      check_at_least(test, "order of the restitution", e < 1 ? 0.9 : 1.9, of_e);
    }
  };
  run(static_cast<soft_scene<linear>*>(nullptr), "semi-implicit Euler");
  run(static_cast<soft_scene<linear, velocity_verlet>*>(nullptr), "velocity Verlet");
}

TEST_CASE("Hertz: duration, largest overlap and restitution of an impact, at any speed") {
  // Johnson, Contact Mechanics, 11.3: overlap (15 m v^2 / (16 E* sqrt R))^(2/5), duration 2.868
  // (m^2 / (R E*^2 v))^(1/5).
  using verlet = soft_scene<hertz, velocity_verlet>;
  const real modulus = 1e6, nu = 0.25, effective = modulus / (2 * (1 - nu * nu)),
             radius = impact_radius / 2;
  for (const real v : {0.2, 2.0}) {
    const real deepest =
        std::pow(15 * impact_mass * v * v / (16 * effective * std::sqrt(radius)), 0.4);
    const real duration = 0.8 * std::beta(0.4, 0.5) * deepest / v;
    CHECK(duration == doctest::Approx(2.868 * std::pow(impact_mass * impact_mass /
                                                           (radius * effective * effective * v),
                                                       0.2))
                          .epsilon(1e-3));
    const std::string test = talus::detail::compose("Hertz impact at {}", v);
    const auto hit = collide_spheres<verlet>({.restitution = 1, .youngs_modulus = modulus},
                                             duration / 400, 0.4, v / 2);
    check_relative(test, "time of overlap", duration, hit.duration, 1e-3);
    check_relative(test, "largest overlap", deepest, hit.overlap, 1e-3);
    for (const real e : {1.0, 0.7, 0.3}) {
      const auto damped = collide_spheres<verlet>({.restitution = e, .youngs_modulus = modulus},
                                                  duration / 400, 0.4, v / 2);
      check_absolute(test, talus::detail::compose("restitution {}", e), e, damped.restitution,
                     0.01);
    }
  }
}

TEST_CASE("velocity Verlet keeps the energy of elastic impacts to second order") {
  const material soft{.restitution = 1, .stiffness = 1e5},
      round{.restitution = 1, .youngs_modulus = 1e6};
  const auto worst = [](const impact& r) { return r.energy_error; };
  const real coarse = pi / std::sqrt(1e5 / impact_mass) / 100;
  const auto of = [&]<class Scenario>(Scenario*, const material& m) {
    return order_of(coarse, [&](real dt) { return mean_error<Scenario>(m, dt, worst); });
  };
  check_at_least("energy of elastic impacts", "order, linear, Verlet", 1.9,
                 of(static_cast<soft_scene<linear, velocity_verlet>*>(nullptr), soft));
  check_at_least("energy of elastic impacts", "order, Hertz, Verlet", 1.9,
                 of(static_cast<soft_scene<hertz, velocity_verlet>*>(nullptr), round));
  check_at_least("energy of elastic impacts", "order, linear, Euler", 0.9,
                 of(static_cast<soft_scene<linear>*>(nullptr), soft));
}

TEST_CASE(
    "an oblique impact that slides throughout changes the tangential velocity by mu (1+e) v_n") {
  const auto run = [&]<class Scenario>(Scenario*, const material& m, const std::string& test) {
    const real vn = 1, vt = 6, mu = m.friction, e = m.restitution, radius = 0.5;
    REQUIRE(vt > 3.5 * mu * (1 + e) * vn);
    scene<Scenario> s(m);
    const auto h = s.floor().ball(radius, {0, 0, radius}, {vt, 0, -vn});
    for (int k = 0; k < 2000; ++k) s.w.step(2e-5);
    const vec3 v = s.w[h].velocity(), w = s.w[h].angular_velocity();
    REQUIRE(v[2] > 0);
    check_relative(test, "loss over mu (v_n + v_n')", mu * (vn + v[2]), vt - v[0], 1e-12);
    check_relative(test, "loss over mu (1 + e) v_n", mu * (1 + e) * vn, vt - v[0], 0.005);
    check_relative(test, "spin", 2.5 * (vt - v[0]) / radius, w[1], 1e-12);
  };
  const material m{.restitution = 0.5, .friction = 0.3, .stiffness = 1e6, .youngs_modulus = 1e7};
  run(static_cast<soft_scene<linear>*>(nullptr), m, "oblique impact, linear");
  run(static_cast<soft_scene<hertz, velocity_verlet>*>(nullptr), m, "oblique impact, Hertz");
}

TEST_CASE("the critical time step parts bounded from growing oscillations") {
  // A sphere squeezed between two planes hangs on two springs k, as in a contact of two such
  // spheres.
  const auto swing = [&]<class Scenario>(Scenario*, real part) {
    const real radius = 0.5, k = 1e4;
    scene<Scenario> s({.restitution = 1, .stiffness = k});
    s.w.global([&](auto& scope) {
      for (const real side : {1.0, -1.0})
        scope.add(plane{.normal = {0, 0, side}, .offset = 0.05 - radius}, {});
    });
    const auto h = s.ball(radius, {0, 0, 1e-4});
    const real dt = part * critical_dt(s.w);
    real furthest = 0;
    for (int step = 0; step < 300 && furthest < 0.01; ++step) {
      s.w.step(dt);
      furthest = std::max(furthest, std::abs(s.w[h].position()[2]));
    }
    return furthest;
  };
  const auto check = [&]<class Scenario>(Scenario* type, const std::string& name) {
    check_holds("critical time step, " + name, "bounded at 0.99 of it", true,
                swing(type, 0.99) < 2e-3);
    check_holds("critical time step, " + name, "bounded at 1.01 of it", false,
                swing(type, 1.01) < 2e-3);
  };
  check(static_cast<soft_scene<linear>*>(nullptr), "semi-implicit Euler");
  check(static_cast<soft_scene<linear, velocity_verlet>*>(nullptr), "velocity Verlet");

  scene<soft_scene<hertz, velocity_verlet>> s(
      {.density = 2.5, .youngs_modulus = 7e6, .poisson_ratio = 0.3});
  s.ball(0.2, {0, 0, 0}), s.ball(0.1, {1, 0, 0});
  // Of the smaller one: pi R sqrt(rho / G) / (0.1631 nu + 0.8766).
  check_relative("critical time step, Hertz", "Rayleigh time",
                 pi * 0.1 * std::sqrt(2.5 * 2.6 / 7e6) / 0.92553, critical_dt(s.w), 1e-12);
}

TEST_CASE("a box on an incline sticks below the angle of friction and slides beyond it") {
  const real angle = 30 * pi / 180, dt = 2e-4;
  const vec3 up{std::sin(angle), 0, std::cos(angle)}, down{std::cos(angle), 0, -std::sin(angle)};
  const auto start = [&](scene<soft_scene<linear>>& s) {
    s.floor(angle);
    return s.w.add(body{
        .shape = box{{1, 1, 1}}, .position = 0.5 * up, .orientation = rotation({0, 1, 0}, angle)});
  };
  {
    scene<soft_scene<linear>> s({.restitution = 0.2, .friction = 0.6, .stiffness = 1e5}, g);
    const auto h = start(s);
    std::array<vec3, 3> at;
    for (int second = 0; second < 3; ++second) {
      for (int k = 0; k < 5000; ++k) s.w.step(dt);
      at[second] = s.w[h].position();
    }
    // Four springs of 2/7 k hold the weight; the start overshoots.
    const real stretch = g * std::sin(angle) / (4 * 2.0 / 7 * 1e5);
    check_at_least("box on an incline, sticking", "stretch of the springs", stretch,
                   down.dot(at[0] - 0.5 * up));
    CHECK(down.dot(at[0] - 0.5 * up) < 20 * stretch);
    check_error("box on an incline, sticking", "creep from 1 s to 2 s", (at[1] - at[0]).norm(),
                1e-9);
    check_error("box on an incline, sticking", "creep from 2 s to 3 s", (at[2] - at[1]).norm(),
                1e-12);
    check_error("box on an incline, sticking", "speed", s.w[h].velocity().norm(), 1e-12);
  }
  {
    scene<soft_scene<linear>> s({.restitution = 0.2, .friction = 0.4, .stiffness = 1e5}, g);
    const auto h = start(s);
    for (int k = 0; k < 5000; ++k) s.w.step(dt);
    const real before = down.dot(s.w[h].velocity());
    for (int k = 0; k < 5000; ++k) s.w.step(dt);
    check_relative("box on an incline, sliding", "acceleration",
                   g * (std::sin(angle) - 0.4 * std::cos(angle)),
                   down.dot(s.w[h].velocity()) - before, 1e-9);
  }
}

TEST_CASE("rolling resistance stops a rolling sphere with 5/7 mu_r g") {
  const real v0 = 1, radius = 0.5, arm = 0.05, a = 5.0 / 7 * arm * g, dt = 1e-4, k = 1e5;
  scene<soft_scene<linear>> s(
      {.restitution = 0.3, .friction = 0.5, .stiffness = k, .rolling_friction = arm}, g);
  const real mass = 4.0 / 3 * pi * std::pow(radius, 3);
  const auto h =
      s.floor().ball(radius, {0, 0, radius - mass * g / k}, {v0, 0, 0}, {0, v0 / radius, 0});
  const auto speed_after = [&](real time) {
    for (int n = static_cast<int>(std::lround(time / dt)); n > 0; --n) s.w.step(dt);
    return s.w[h].velocity()[0];
  };
  const real at_half = speed_after(0.5), at_one = speed_after(0.5);
  check_relative("rolling resistance", "deceleration", a, (at_half - at_one) / 0.5, 1e-3);
  const real rest = speed_after(4 * v0 / a - 1);
  check_error("rolling resistance", "speed at the end", rest, 1e-6);
  check_relative("rolling resistance", "way", v0 * v0 / (2 * a), s.w[h].position()[0], 0.002);
  check_error("rolling resistance", "spin at the end", s.w[h].angular_velocity().norm(), 1e-6);
}

TEST_CASE("at rest the floor bears the weight of a pile to 1e-6") {
  const auto run = [&]<class Scenario>(Scenario*, const material& m, const std::string& name) {
    scene<Scenario> s(m, g);
    const auto ground =
        s.w.add(body{.shape = box{{40, 40, 1}}, .position = {0, 0, -0.5}, .fixed = true});
    real weight = 0;
    // Layers of 3 x 3, 2 x 2, 3 x 3: the upper ones rest in the hollows, the last ones roll off
    // some.
    std::vector<vec3> places;
    for (const real z : {0.5, 1.21, 1.92})
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          if (z != 1.21)
            places.emplace_back(i - 1.5, j - 1.5, z);
          else if (i < 3 && j < 3)
            places.emplace_back(i - 1.0, j - 1.0, z);
    for (const vec3& p : places) weight += g * s.w[s.ball(0.5, p)].mass();
    for (int k = 0; k < 20000; ++k) s.w.step(2e-4);
    const real load = -contact_force(s.w, ground)[2];
    check_relative("force on the floor", name, weight, load, 1e-6);
    MESSAGE(name, ": fastest ", measure_motion(s.w).max_speed, ", mean overlap ",
            measure_penetration(s.w).mean);
  };
  const material m{.restitution = 0.2,
                   .friction = 0.5,
                   .stiffness = 2e4,
                   .youngs_modulus = 1e6,
                   .rolling_friction = 0.1};
  run(static_cast<soft_scene<linear>*>(nullptr), m, "linear");
  run(static_cast<soft_scene<hertz, velocity_verlet>*>(nullptr), m, "Hertz");
}
