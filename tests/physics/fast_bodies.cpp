// long
// Bodies that move far in a step, with features<continuous_collision>: they stop at bodies in their
// way, and are not deflected by bodies that they pass. On 1 rank and on 4, cut through the scene.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <vector>

#include "../validation/record.hpp"
#include "../validation/track.hpp"

using namespace talus;
using namespace talus::validation;

namespace {

using fast = scenario<bodies<sphere, box, capsule, plane>, transport<threads>,
                      decomposition<grid<dynamic, dynamic>>, features<continuous_collision>>;

constexpr real dt = 1.0 / 240;
constexpr real huge = 1000 / dt;  ///< 1000 radii per step

template <class World>
void set_material(World& w, real restitution, real friction = 0) {
  w.material({.restitution = restitution, .friction = friction});
}

}  // namespace

TEST_CASE("a sphere at 1000 radii per step rebounds from a wall, however thin, with -e v") {
  struct wall {
    const char* name;
    real surface;
  };
  for (const int ranks : {1, 4})
    for (const auto& [name, surface] : {wall{"box, 1/100 r thick", -0.005}, wall{"plane", 0}})
      for (const real e : {0.0, 0.5, 1.0})
        for (const real across : {0.0, 0.5}) {
          const auto way = follow<fast>(ranks, dt, 3, [&](auto& w) {
            set_material(w, e);
            w.global([&](auto& s) {
              if (surface < 0)
                s.add(body{.shape = box{{0.01, 5000, 5000}}});
              else
                s.add(plane{.normal = {-1, 0, 0}}, material_id{});
            });
            w.add_if_local(body{.shape = sphere{1},
                                .position = {-1500.3, -across * 1400, 0.3},
                                .velocity = {huge, across * huge, 0}});
          })[0];
          CAPTURE(name);
          CAPTURE(e);
          real furthest = -1e9;
          for (const moment& m : way) furthest = std::max(furthest, m.position[0]);
          // It never overlaps, and reaches the wall before it turns around.
          CHECK(furthest + 1 - surface < 1e-9);
          CHECK(way[2].position[0] > surface - 1 - 0.51);
          CHECK(std::abs(way[3].velocity[0] + e * huge) < 1e-8 * huge);
          CHECK(std::abs(way[3].velocity[1] - across * huge) < 1e-12 * huge);
        }
}

TEST_CASE("a sphere is not deflected by a sphere, box or capsule that it passes") {
  for (const int ranks : {1, 4})
    for (const real speed : {huge, 30 / dt, 0.4 / dt, 0.05 / dt})
      for (const real distance : {0.03, 0.2}) {
        CAPTURE(speed * dt);
        const vec3 v{speed, 0, 0};
        const auto all = follow<fast>(
            ranks, dt, static_cast<std::size_t>(2.2 * (10 / (speed * dt) + 1)), [&](auto& w) {
              set_material(w, 0.5, 0.5);
              const real x = -10 - 0.93 * speed * dt;
              w.add_if_local(body{.shape = sphere{1}, .position = {x, 0.01, 0}, .velocity = v});
              w.add_if_local(body{.shape = sphere{1}, .position = {-3, 2.01 + distance, 0}});
              w.add_if_local(body{.shape = box{{2, 2, 2}}, .position = {0, -1.99 - distance, 0}});
              w.add_if_local(body{.shape = capsule{1, 2}, .position = {3, 0.01, 3 + distance}});
            });
        for (const auto& way : all)
          for (std::size_t k = 0; k < way.size(); ++k) {
            CHECK(way[k].velocity == way[0].velocity);
            CHECK((way[k].position - way[0].position - static_cast<real>(k) * dt * way[0].velocity)
                      .norm() < 1e-9);
          }
        CHECK(all[0].back().position[0] > 10);
      }
}

TEST_CASE("two fast spheres cross each other's path at different times, and do not touch") {
  for (const int ranks : {1, 4}) {
    const auto all = follow<fast>(ranks, dt, 3, [&](auto& w) {
      set_material(w, 0.5);
      w.add_if_local(
          body{.shape = sphere{1}, .position = {-510.3, 0.1, 0}, .velocity = {huge, 0, 0}});
      w.add_if_local(
          body{.shape = sphere{1}, .position = {0.1, 505.3, 0}, .velocity = {0, -huge, 0}});
    });
    for (const auto& way : all) CHECK(way.back().velocity == way.front().velocity);
  }
}

TEST_CASE("fast spheres collide with the normal of their true impact, and keep their momentum") {
  const real mass = 4 * pi / 3;
  real worst = 0, momentum = 0;
  for (const int ranks : {1, 4})
    for (const real e : {0.0, 0.7, 1.0})
      for (const real offset : {0.0, 0.3, 1.0, 1.7, 1.9})
        for (const real speed : {huge, 7 / dt}) {
          // One from each side of the cut, met off centre by `offset`.
          const vec3 va{speed, 0, 0}, vb{-0.5 * speed, 0, 0};
          const auto all = follow<fast>(ranks, dt, 4, [&](auto& w) {
            set_material(w, e);
            w.add_if_local(body{.shape = sphere{1},
                                .position = {-0.73 * speed * dt - 2, 0.5 * offset, 0},
                                .velocity = va});
            w.add_if_local(body{.shape = sphere{1},
                                .position = {0.41 * speed * dt + 2, -0.5 * offset, 0},
                                .velocity = vb});
          });
          const vec3 n{std::sqrt(1 - offset * offset / 4), -offset / 2, 0};
          const vec3 change = -(1 + e) / 2 * n.dot(va - vb) * n;
          worst = std::max({worst, (all[0].back().velocity - va - change).norm() / speed,
                            (all[1].back().velocity - vb + change).norm() / speed});
          momentum = std::max(
              momentum, mass * (all[0].back().velocity + all[1].back().velocity - va - vb).norm() /
                            (mass * speed));
        }
  check_error("fast spheres, off centre", "velocities after the impact, over the speed", worst,
              1e-5);
  check_error("fast spheres, off centre", "momentum", momentum, 1e-12);
}

TEST_CASE("a fast sphere never leaves a box of thin walls, and keeps its speed where e = 1") {
  for (const int ranks : {1, 4}) {
    const vec3 v0{0.3 * huge, 0.017 * huge, -0.0071 * huge};
    const auto way = follow<fast>(ranks, dt, 1500, [&](auto& w) {
      set_material(w, 1);
      w.global([&](auto& s) {
        for (int axis = 0; axis < 3; ++axis)
          for (const real side : {-5.0, 5.0}) {
            vec3 size{10, 10, 10};
            size[axis] = 0.001;
            s.add(body{.shape = box{size}, .position = side * vec3::Unit(axis)});
          }
      });
      w.add_if_local(body{.shape = sphere{1}, .velocity = v0});
    })[0];
    real furthest = 0;
    for (const moment& m : way) furthest = std::max(furthest, m.position.cwiseAbs().maxCoeff());
    const std::string test = fmt::format("fast sphere in a box, {} rank(s)", ranks);
    check_error(test, "furthest from the centre beyond 4, over r", furthest - 4, 0.01);
    check_error(test, "speed", way.back().velocity.norm() / v0.norm() - 1, 1e-9);
    int turns = 0;
    for (std::size_t k = 1; k < way.size(); ++k)
      turns += way[k].velocity[0] * way[k - 1].velocity[0] < 0;
    CHECK(turns > 300);
  }
}

TEST_CASE("tumbling boxes and capsules do not pass a thin wall, whichever way they hit it") {
  for (const int ranks : {1, 4}) {
    std::vector<real> energy;
    const auto all = follow<fast>(ranks, dt, 40, [&](auto& w) {
      set_material(w, 0.3, 0.4);
      w.global([&](auto& s) {
        s.add(body{.shape = box{{0.01, 4000, 4000}}, .position = {0.3, 0, 0}});
      });
      random_stream random(11);
      for (int k = 0; k < 60; ++k) {
        const vec3 at{-20 - random.uniform(0., 300.), 30. * (k % 10) - 140, 30. * (k / 10) - 80},
            v{random.uniform(12., 300.) / dt, random.uniform(-5., 5.) / dt, 0},
            spin = random.uniform(vec3(-300, -300, -300), vec3(300, 300, 300));
        const quat q = rotation(random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1)), 3);
        if (k % 2 == 0)
          w.add_if_local(body{.shape = box{{2, 1, 0.2}},
                              .position = at,
                              .velocity = v,
                              .angular_velocity = spin,
                              .orientation = q});
        else
          w.add_if_local(body{.shape = capsule{0.2, 2},
                              .position = at,
                              .velocity = v,
                              .angular_velocity = spin,
                              .orientation = q});
      }
    });
    REQUIRE(all.size() == 60);
    int hit = 0, passed = 0;
    for (const auto& way : all) {
      hit += way.back().velocity[0] != way.front().velocity[0];
      for (const moment& m : way) passed += m.position[0] > 0.3;
    }
    check_absolute(fmt::format("tumbling bodies and a thin wall, {} rank(s)", ranks),
                   "steps beyond the wall", 0, passed, 0);
    CHECK(hit == 60);
  }
}

TEST_CASE("a thin rod that spins fast does not reach through a wall beside it") {
  for (const int ranks : {1, 4})
    for (const real turn : {0.7, 3.0, 20.0}) {  // radians per step
      const auto way = follow<fast>(ranks, dt, 60, [&](auto& w) {
        set_material(w, 0.5);
        w.global([&](auto& s) { s.add(body{.shape = box{{0.01, 400, 400}}}); });
        w.add_if_local(body{.shape = box{{0.02, 10, 0.02}},
                            .position = {-1, 0.1, 0},
                            .angular_velocity = {0, 0, turn / dt}});
      })[0];
      int through = 0;
      for (const moment& m : way)
        for (const real end : {-5., 5.})
          through += pose{m.position, m.orientation}.to_world({0, end, 0})[0] > 0.03;
      check_absolute(fmt::format("rod that turns by {} a step, {} rank(s)", turn, ranks),
                     "ends beyond the wall", 0, through, 0);
      CHECK(way.back().velocity[0] < 0);
    }
}

TEST_CASE(
    "with continuous collision a ball bounces to h e^(2k), to 1e-3, and without loss at e = 1") {
  for (const real e : {0.5, 0.8, 1.0}) {
    const auto way = follow<fast>(1, dt, 240 * 10, [&](auto& w) {
      set_material(w, e);
      w.gravity({0, 0, -9.81});
      w.global([&](auto& s) { s.add(plane{}, material_id{}); });
      w.add_if_local(body{.shape = sphere{0.5}, .position = {0, 0, 1.5}});
    })[0];
    // An apex of the parabola that the scheme follows: its velocity is that of half a step before.
    real worst = 0, expected = 1 + 9.81 * dt * dt / 8;
    int bounces = 0;
    for (std::size_t k = 1; k + 1 < way.size() && bounces < (e == 1 ? 10 : 4); ++k) {
      const real before = way[k - 1].velocity[2], v = way[k].velocity[2];
      if (before < 0 && v > 0) {
        expected *= e * e, ++bounces;
        const real now = v - 0.5 * dt * 9.81;
        const real apex = way[k].position[2] - 0.5 + now * now / (2 * 9.81);
        worst = std::max(worst, std::abs(apex / expected - 1));
      }
    }
    CHECK(bounces == (e == 1 ? 10 : 4));
    check_error(fmt::format("bouncing ball, continuous collision, e = {}", e), "apexes", worst,
                e == 1 ? 1e-9 : 1e-3);
  }
}

TEST_CASE("the energy ledger and the momentum balance close with continuous collision") {
  using watched = scenario<bodies<sphere, box, plane>, transport<threads>,
                           decomposition<grid<dynamic, dynamic>>,
                           features<continuous_collision, energy_ledger, momentum_balance>>;
  for (const int ranks : {1, 4})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<watched> w(link);
      w.material({.restitution = 0.6, .friction = 0.3});
      w.gravity({0, 0, -9.81});
      w.global([&](auto& s) { s.add(plane{}, material_id{}); });
      random_stream random(3);
      for (int k = 0; k < 12; ++k) {
        const vec3 at{random.uniform(-3., 3.), random.uniform(-3., 3.), 1.5 + 1.8 * k},
            v = random.uniform(vec3(-30, -30, -300), vec3(30, 30, 30));
        if (k % 2 == 0)
          w.add_if_local(body{.shape = sphere{0.5}, .position = at, .velocity = v});
        else
          w.add_if_local(body{.shape = box{{1, 0.7, 0.4}},
                              .position = at,
                              .velocity = v,
                              .angular_velocity = 0.3 * v});
      }
      for (int k = 0; k < 480; ++k) w.step(dt);
      const auto energy = measure_energy(w);
      const auto momentum = measure_momentum(w);
      if (link.rank() != 0) return;
      const std::string test = fmt::format("monitors of fast bodies, {} rank(s)", ranks);
      check_error(test, "largest closure of the energy of a step", energy.worst, 1e-11);
      check_error(test, "closure of the momentum of the last step", momentum.error(), 1e-11);
    });
}

TEST_CASE("a pile comes to rest with continuous collision as it does without") {
  const auto settle = []<class... Features>(int ranks, features<Features...>) {
    using pile = scenario<bodies<sphere, plane>, transport<threads>,
                          decomposition<grid<dynamic, dynamic>>, features<Features...>>;
    std::pair<motion, penetration> end;
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<pile> w(link);
      const auto m = w.material({.restitution = 0.2, .friction = 0.5});
      w.gravity({0, 0, -9.81});
      w.global([&](auto& s) {
        s.add(plane{}, m);
        for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
          s.add(plane{.normal = n, .offset = -2.6}, m);
      });
      random_stream random(5);
      for (int k = 0; k < 125; ++k)
        w.add_if_local(body{
            .shape = sphere{random.uniform(0.4, 0.5)},
            .position = vec3(1.05 * (k % 5) - 2.1, 1.05 * (k / 5 % 5) - 2.1, 1.05 * (k / 25) + 1) +
                        random.uniform(vec3(-.02, -.02, -.02), vec3(.02, .02, .02)),
            .material = m});
      for (int k = 0; k < 960; ++k) w.step(dt);
      const auto motion = measure_motion(w);
      const auto depth = measure_penetration(w);
      if (link.rank() == 0) end = {motion, depth};
    });
    return end;
  };
  for (const int ranks : {1, 4}) {
    const auto [with, depth] = settle(ranks, features<continuous_collision>{});
    const auto [without, depth_without] = settle(ranks, features<>{});
    CHECK(with.bodies == 125);
    MESSAGE(ranks, " rank(s): kinetic energy ", with.kinetic_energy, ", without ",
            without.kinetic_energy, "; height ", with.potential_energy / with.mass / 9.81,
            ", without ", without.potential_energy / with.mass / 9.81);
    CHECK(with.kinetic_energy < 5e-3 * with.mass * 9.81 * 0.45);
    CHECK(depth.mean < 2 * depth_without.mean + 1e-4);
    CHECK(with.potential_energy == doctest::Approx(without.potential_energy).epsilon(0.03));
  }
}

TEST_CASE("a flight over domains that are not connected is refused, with the reach that it needs") {
  using row = scenario<bodies<sphere>, transport<threads>, decomposition<grid<4>>,
                       features<continuous_collision>>;
  const auto fly = [](const reach& within) {
    threads::launch({.ranks = 4}, [&](threads::link& link) {
      world<row> w(link, grid<4>{.lower = {-20}, .upper = {20}}, within);
      w.material({.restitution = 1});
      w.add_if_local(
          body{.shape = sphere{1}, .position = {-15, 0, 0}, .velocity = {25 / dt, 0, 0}});
      w.add_if_local(body{.shape = sphere{1}, .position = {15, 0.1, 0}});
      for (int k = 0; k < 4; ++k) w.step(dt);
      double moved = 0;
      w.for_each_local([&](const auto& b) { moved += b.velocity().norm() > 0; });
      link.reduce(reduction::sum, std::span(&moved, 1));
      CHECK(moved == 2);
    });
  };
  CHECK_THROWS_WITH_AS(fly({}), doctest::Contains("decompose with a reach of 25"),
                       std::runtime_error);
  fly({.distance = 60});
}

TEST_CASE("a sphere that falls while it strikes two walls in every step keeps its energy") {
  const auto way = follow<fast>(1, 0.007, 200, [](auto& w) {
    set_material(w, 1);
    w.gravity({0, 0, -10});
    w.global([](auto& s) {
      s.add(plane{.normal = {1, 0, 0}, .offset = -0.52}, material_id{});
      s.add(plane{.normal = {-1, 0, 0}, .offset = -0.52}, material_id{});
    });
    w.add_if_local(body{.shape = sphere{0.5}, .velocity = {60, 0, 0}});
  })[0];
  const auto energy = [](const moment& m) {
    return 0.5 * m.velocity.squaredNorm() + 10 * m.position[2];
  };
  real most = 0, least = 1e9;
  for (const moment& m : way) {
    most = std::max(most, energy(m));
    least = std::min(least, energy(m));
  }
  // Stopped at a wall it falls less far in a step than freely, and gets no faster than that.
  CHECK(way.back().position[2] < -0.05);
  CHECK(most < 1800 * (1 + 1e-3));
  CHECK(least > 1800 * (1 - 1e-2));
}
