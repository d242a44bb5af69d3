// Bonds: the deflection and first eigenfrequency of a fibre, the load that breaks a bond, and the
// same bits and momentum on any ranks.
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <mutex>
#include <string>
#include <talus/observe/bond_breaks.hpp>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/summary.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/bonds.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using domains = grid<dynamic, dynamic>;
using glued = soft_contact<linear_spring_dashpot, parallel_bond>;
using fibre = scenario<bodies<sphere>, glued, transport<serial>, features<forces, damping>>;

/// Linear and angular momentum of all bodies.
template <class World, class Link>
std::array<vec3, 2> momentum_of(World& w, Link& link) {
  vec3 p{0, 0, 0}, l{0, 0, 0};
  w.for_each_local([&](const auto& b) {
    p += b.mass() * b.velocity();
    l += b.mass() * (b.position().cross(b.velocity()) + 0.4 * 0.25 * b.angular_velocity());
  });
  std::array<real, 6> sum{p[0], p[1], p[2], l[0], l[1], l[2]};
  link.reduce(reduction::sum, std::span(sum));
  return {vec3(sum[0], sum[1], sum[2]), vec3(sum[3], sum[4], sum[5])};
}

}  // namespace

TEST_CASE("a fibre of bonds bends and swings as a beam") {
  const real L = 0.15, d = 2.83e-3, E = 1e9, rho = 420;
  const int elements = 20;
  const real l = L / elements, R = l / 2, section = pi * d * d / 4,
             second = pi * d * d * d * d / 64;
  serial::link link;
  world<fibre> w{link};
  const real density = rho * section * l / (4 * pi / 3 * R * R * R);
  const auto wood = w.material({.density = density, .stiffness = 1});
  const auto tip = w.material({.density = density / 2, .stiffness = 1});  // half an element
  const parallel_bond::parameters p{
      .youngs_modulus = E, .poisson_ratio = 0.3, .radius_multiplier = d / (2 * R), .range = R};
  w.interaction(wood, wood, p), w.interaction(wood, tip, p), w.interaction(tip, tip, p);
  system_id last{};
  for (int k = 0; k <= elements; ++k) {
    const auto b = w.add(body{.shape = sphere{R},
                              .position = {k * l, 0, 0},
                              .material = k == elements ? tip : wood,
                              .fixed = k == 0});
    last = w[b].id();
  }
  CHECK(bond_within(w, 1e-3 * R) == elements);
  CHECK(bond_within(w, 1e-3 * R) == 0);
  const real P = 1e-4, expected = P * L * L * L / (3 * E * second), dt = 1.5e-6;
  const auto height = [&] {
    real z = 0;
    w.for_each_local([&](const auto& b) {
      if (b.id() == last) z = b.position()[2];
    });
    return z;
  };
  w.damping(std::exp(-340.0));
  for (int k = 0; k < 60000; ++k) {
    w.for_each_local([&](auto& b) {
      if (b.id() == last) b.add_force({0, 0, P});
    });
    w.step(dt);
  }
  CHECK(height() == doctest::Approx(expected).epsilon(0.01));
  // Released, it swings: the time between two downward crossings of zero.
  w.damping(1);
  real before = height(), first = 0;
  int crossings = 0;
  real period = 0;
  for (int k = 1; k < 80000 && crossings < 3; ++k) {
    w.step(dt);
    const real now = height();
    if (before > 0 && now <= 0) {
      const real at = (k - now / (now - before)) * dt;
      if (++crossings == 1) first = at;
      if (crossings == 3) period = (at - first) / 2;
    }
    before = now;
  }
  const real frequency =
      1.87510407 * 1.87510407 / (2 * pi) * std::sqrt(E * second / (rho * section)) / (L * L);
  CHECK(1 / period == doctest::Approx(frequency).epsilon(0.01));
}

TEST_CASE("a bond breaks at the load of its strength, in tension and in shear") {
  // A load applied at once doubles the static stress.
  const auto broken_by = [](real load, const vec3& along, bool tension) {
    serial::link link;
    world<fibre> w{link};
    const auto m = w.material({.density = 1000, .stiffness = 1});
    parallel_bond::parameters p{.youngs_modulus = 1e7, .range = 0.5};
    (tension ? p.tensile_strength : p.shear_strength) = 1e4;
    w.interaction(m, m, p);
    const real R = 1;
    (void)w.add(body{.shape = sphere{R}, .position = {0, 0, 0}, .fixed = true});
    const auto b = w.add(body{.shape = sphere{R}, .position = {2 * R, 0, 0}});
    REQUIRE(bond_within(w, 1e-9) == 1);
    const auto id = w[b].id();
    for (int k = 0; k < 4000; ++k) {
      w.for_each_local([&](auto& x) {
        if (x.id() != id) return;
        x.add_force(load * along);
        if (!tension) x.add_torque(load * vec3(1, 0, 0));
      });
      w.step(2e-4);
      if (const bond_count n = count_bonds(w); n.intact == 0) return tension ? n.tension : n.shear;
    }
    return std::uint64_t{0};
  };
  const real pull = 1e4 * pi;        // strength times area
  const real torque = 1e4 * pi / 2;  // strength times polar moment over radius
  CHECK(broken_by(0.49 * pull, {1, 0, 0}, true) == 0);
  CHECK(broken_by(0.51 * pull, {1, 0, 0}, true) == 1);
  CHECK(broken_by(0.49 * torque, {0, 0, 0}, false) == 0);
  CHECK(broken_by(0.51 * torque, {0, 0, 0}, false) == 1);
}

TEST_CASE("bonded bodies move alike on any ranks, and keep their momentum") {
  using scene = scenario<bodies<sphere>, glued, decomposition<domains>, transport<threads>>;
  const auto run = [](int ranks) {
    std::string digest;
    bond_count count;
    real drift = 0, turn = 0;
    std::mutex mutex;
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<scene> w(link, domains{.lower = {-6, -6}, .upper = {6, 6}});
      const auto m = w.material({.density = 1, .stiffness = 1e3});
      w.interaction(m, m,
                    parallel_bond::parameters{.youngs_modulus = 1e4,
                                              .poisson_ratio = 0.2,
                                              .range = 0.3,
                                              .tensile_strength = 3,
                                              .shear_strength = 3,
                                              .weibull_modulus = 3,
                                              .damping_ratio = 0.02});
      for (int k = 0; k < 64; ++k) {
        const vec3 x{k % 4 - 1.5, k / 4 % 4 - 1.5, k / 16 - 1.5};
        w.add_if_local(
            body{.shape = sphere{0.5},
                 .position = x,
                 .velocity = vec3(1, 0.3, 0) + vec3(-1.2 * x[1], 1.2 * x[0], 0.4 * x[0])});
      }
      CHECK(bond_within(w, 1e-9) == 144);
      const auto before = momentum_of(w, link);
      for (int k = 0; k < 1500; ++k) w.step(1e-3);
      const auto now = momentum_of(w, link);
      const bond_count n = count_bonds(w);
      const std::string d = state_digest(w);
      const std::lock_guard lock(mutex);
      if (link.rank() != 0) return;
      digest = d, count = n;
      drift = (now[0] - before[0]).norm() / before[0].norm();
      turn = (now[1] - before[1]).norm() / before[1].norm();
    });
    CAPTURE(ranks);
    CHECK(drift < 1e-12);
    CHECK(turn < 1e-12);
    CHECK(count.intact > 0);
    CHECK(count.tension + count.shear > 0);
    return digest;
  };
  const std::string one = run(1);
  CHECK(run(2) == one);
  CHECK(run(4) == one);
}

TEST_CASE("the energy of bonds that swing, break and damp is booked") {
  using scene = scenario<bodies<sphere>, glued, transport<serial>, features<energy_ledger>>;
  serial::link link;
  world<scene> w{link};
  const auto m = w.material({.density = 1, .stiffness = 1e3});
  w.interaction(m, m,
                parallel_bond::parameters{.youngs_modulus = 1e4,
                                          .poisson_ratio = 0.2,
                                          .range = 0.3,
                                          .tensile_strength = 100,
                                          .damping_ratio = 0.02});
  for (int k = 0; k < 4; ++k)
    (void)w.add(body{.shape = sphere{0.5},
                     .position = {real(k), 0, 0},
                     .velocity = {k == 3 ? 2.0 : 0.0, 0.3 * k * k, 0},
                     .angular_velocity = {0.5 * k, 0, 0}});
  CHECK(bond_within(w, 1e-9) == 3);
  for (int k = 0; k < 1000; ++k) w.step(1e-4);
  const bond_count n = count_bonds(w);
  CHECK(n.tension > 0);
  CHECK(n.intact + n.tension == 3);
  const auto e = measure_energy(w);
  CHECK(e.total.friction + e.total.impact > 0);
  CHECK(std::abs(e.worst) < 1e-9);
}

TEST_CASE("one run at a time writes a table of broken bonds") {
  const std::string file = "/tmp/talus_breaks_" + std::to_string(getpid()) + ".csv";
  serial::link alone;
  world<fibre> one(alone), other(alone);
  record_breaks(one, file, every{1});
  CHECK_THROWS_WITH_AS(
      record_breaks(other, file, every{1}),
      doctest::Contains(("the table of broken bonds " + file + " is being written by").c_str()),
      std::runtime_error);
  CHECK_THROWS_WITH_AS(record_breaks(other, "/dev/null", every{1}),
                       doctest::Contains("the table of broken bonds /dev/null "),
                       std::runtime_error);
  std::remove(file.c_str());
}

TEST_CASE("parameters of bonds without meaning are refused, with the field and its value") {
  serial::link link;
  world<fibre> w{link};
  const auto m = w.material({.density = 1, .stiffness = 1});
  const parallel_bond::parameters good{.youngs_modulus = 1, .range = 0.1};
  w.interaction(m, m, good);
  const real infinite = std::numeric_limits<real>::infinity();
  for (const real bad : {real(-1), infinite, real(std::nan(""))}) {
    CAPTURE(bad);
    const auto refused = [&](real parallel_bond::parameters::*field) {
      auto p = good;
      p.*field = bad;
      CHECK_THROWS_WITH_AS(w.interaction(m, m, p), doctest::Contains("parallel_bond has ."),
                           std::invalid_argument);
    };
    using p = parallel_bond::parameters;
    for (const auto field : {&p::youngs_modulus, &p::poisson_ratio, &p::radius_multiplier,
                             &p::range, &p::weibull_modulus, &p::damping_ratio})
      refused(field);
    if (bad != infinite) refused(&p::tensile_strength), refused(&p::shear_strength);
  }
  auto p = good;
  p.poisson_ratio = 0.6;
  CHECK_THROWS_WITH_AS(
      w.interaction(m, m, p),
      "parallel_bond has .poisson_ratio = 0.6: give a number above -1 and up to 0.5",
      std::invalid_argument);
}

TEST_CASE(
    "a distance of bonds beyond the range is refused, and pairs without a modulus stay free") {
  serial::link link;
  world<fibre> w{link};
  const auto rock = w.material({.density = 1, .stiffness = 1e3}),
             sand = w.material({.density = 1, .stiffness = 1e3});
  w.interaction(rock, rock, parallel_bond::parameters{.youngs_modulus = 1e4, .range = 0.3});
  w.interaction(rock, sand, parallel_bond::parameters{});
  system_id ids[3];
  for (int k = 0; k < 3; ++k)
    ids[k] =
        w[w.add(body{
              .shape = sphere{0.5}, .position = {1.01 * k, 0, 0}, .material = k < 2 ? rock : sand})]
            .id();
  CHECK_THROWS_WITH_AS((void)bond_within(w, 0.5),
                       "bond_within(world, 0.5) reaches beyond the range of parallel_bond, 0.3, "
                       "where bonds break: give parallel_bond::parameters a longer range, or a "
                       "shorter distance",
                       std::invalid_argument);
  CHECK_THROWS_AS((void)bond_within(w, std::nan("")), std::invalid_argument);
  CHECK(bond_within(w, 0.1) == 1);
  const std::pair<system_id, system_id> list[] = {{ids[1], ids[2]}};
  CHECK_THROWS_WITH_AS((void)bond_pairs(w, list), doctest::Contains("bonded 0 of 1 pairs"),
                       std::invalid_argument);
}

TEST_CASE("critical_dt contains the stiffness of bonds: motion is bounded below, and grows above") {
  const auto kinetic = [](real multiplier, real part, int width, bool& stable) {
    serial::link link;
    world<fibre> w{link};
    const auto m = w.material({.density = 1, .restitution = 1, .stiffness = 1e-3});
    w.interaction(m, m,
                  parallel_bond::parameters{.youngs_modulus = 1e4,
                                            .poisson_ratio = 0.2,
                                            .radius_multiplier = multiplier,
                                            .range = 0.3});
    random_stream random(1, 1);
    for (int k = 0; k < 8 * width * width; ++k)
      (void)w.add(body{.shape = sphere{0.5},
                       .position = vec3(k % 8, k / 8 % width, k / 8 / width),
                       .velocity = 1e-9 * random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1)),
                       .angular_velocity = 1e-9 * random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1))});
    CHECK(bond_within(w, 1e-9) > 0);
    const real dt = part * critical_dt(w);
    for (int k = 0; k < 2000; ++k) w.step(dt);
    stable = measure_motion(w).max_speed < 1e-7;
    return summarize(w, 0, 0);
  };
  bool stable = false;
  for (const int width : {1, 3})
    for (const real multiplier : {0.3, 1.0, 2.0}) {
      CAPTURE(width);
      CAPTURE(multiplier);
      summary s = kinetic(multiplier, 0.98, width, stable);
      CHECK(stable);
      CHECK_FALSE(dt_above_critical(s));
      s = kinetic(multiplier, 1.5, width, stable);
      CHECK_FALSE(stable);
      // Also where bonds are broken at the end.
      CHECK(dt_above_critical(s));
    }
}
