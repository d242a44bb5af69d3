// Tutorial: tasks that users of the ancestor had to do and that are unnecessary now. Each of these
// tests would fail, hang or not compile there.
#include <doctest/doctest.h>
#include <talus/scene/run.hpp>  // any header first, in any order

#include <cmath>
#include <talus/talus.hpp>

#include "ranks.hpp"

using namespace talus;
using namespace talus::tutorial;

using scene = scenario<bodies<sphere, plane>, decomposition<by_hand>>;
using stair = join<ring<dynamic>, slabs<dynamic>>;

namespace {
const half_space west(-1, 0, 0, 0), east(1, 0, 0, 0);

/// Two ranks that meet at x = 0.
void connect_halves(auto& world) {
  world.rank() == 0 ? world.connect(1, east) : world.connect(0, west);
}
}  // namespace

TEST_CASE("smooth is not needed: the planes of a stair fit without it, to the last bit") {
  const half_space foot(1, 0, 0, 0), below(0, -1, 0, 0);
  for (const int sectors : {6, 8}) {
    const stair d =
        join(ring<dynamic>{.sectors = sectors,
                           .axis = {0, 0, -1},
                           .start = {-1, 0, 0},
                           .angle = pi,
                           .closed = true},
             within(intersect(foot, below),
                    slabs<dynamic>{.count = 2, .axis = {0, -1, 0}, .lower = 0, .upper = 20}))
            .closed(intersect(complement(foot), below));
    threads::launch({.ranks = sectors + 2}, [&](threads::link& link) {
      world<scenario<bodies<sphere>, decomposition<stair>>> w(link, d);
      CHECK_NOTHROW(w.check_connections());
      for (int k = 1; k < sectors; ++k) {
        const double angle = pi - k * pi / sectors;
        near_plane({-std::sin(angle), std::cos(angle), 0},
                   [&](const vec3& p) { CHECK(owners_of(w, p) == 1); });
      }
      CHECK(w.connections().size() == (w.rank() == 0 || w.rank() == sectors + 1 ? 1 : 2));
    });
  }
}

TEST_CASE("planes that differ by round-off are called so; one plane and its other side never do") {
  const int sectors = 6, i = 2;
  const double alpha = pi / sectors;
  const auto turned = [](double angle) {
    return rotated(rotation({0, 0, -1}, angle), vec3(0, 1, 0));
  };
  const vec3 forwards = turned((i + 1) * alpha);        // from sector i towards the next
  const vec3 backwards = turned((i + 1) * alpha - pi);  // and from there back
  REQUIRE(forwards != -backwards);                      // by some 1e-16
  const auto wrong = [&](auto& world) {
    world.exclusive(0, [&] { world.connect(1, half_space(forwards, 0)); });
    world.exclusive(1, [&] { world.connect(0, half_space(backwards, 0)); });
    world.check_connections();
  };
  refused_on<scene, std::runtime_error>(2, wrong, R"(
      the domains of the ranks do not fit together:
      - ranks 0 and 1 draw their boundary differently: rank 0 gives ..., rank 1 gives ..., which is
      ... off; ... the point (...); use the same numbers on both ranks, all signs reversed
  )");
  on_ranks<scene>(2, [&](auto& world) {
    const half_space beyond(forwards, 0);
    world.exclusive(0, [&] { world.connect(1, beyond); });
    world.exclusive(1, [&] { world.connect(0, complement(beyond)); });
    world.check_connections();
    near_plane(forwards, [&](const vec3& p) { CHECK(owners_of(world, p) == 1); });
  });
}

TEST_CASE("a normal may have any length") {
  on_ranks<scene>(2, [](auto& world) {
    world.exclusive(0, [&] { world.connect(1, vec3(1, 1, 0), 3.0); });
    world.exclusive(1, [&] { world.connect(0, vec3(-7, -7, 0), -3.0); });
    world.check_connections();
    const vec3 foot = 3 * unit(vec3(1, 1, 0));
    near_plane({1, 1, 0}, [&](const vec3& p) { CHECK(owners_of(world, foot + p) == 1); });
  });
}

TEST_CASE("bodies may be created before the connections, by connect alone") {
  on_ranks<scene>(2, [](auto& world) {
    const auto stone = world.material(materials::granite);
    world.exclusive(0, [&] {
      for (int k = -5; k < 5; ++k)
        world.add(body{.shape = sphere{0.4}, .position = {k + 0.5, 0, 0}, .material = stone});
    });
    connect_halves(world);
    world.check_connections();
    world.synchronize();
    CHECK(world.local_bodies() == 5);  // each has one owner, and both have some
    world.for_each_local([&](const auto& body) { CHECK(world.contains(body.position())); });
  });
}

TEST_CASE("the first step brings bodies to their ranks without being asked") {
  on_ranks<scene>(2, [](auto& world) {
    const auto stone = world.material({.density = 1, .restitution = 1});
    world.exclusive(0, [&] {
      world.add(body{.shape = sphere{0.5},
                     .position = {-0.52, 0, 0},
                     .material = stone,
                     .velocity = {1, 0, 0}});
      world.add(body{.shape = sphere{0.5},
                     .position = {0.52, 0, 0},
                     .material = stone,
                     .velocity = {-1, 0, 0}});
    });
    connect_halves(world);
    for (int step = 0; step < 10; ++step) world.step(0.01);
    CHECK(world.local_bodies() == 1);
    world.for_each_local([&](const auto& body) {
      CHECK(body.velocity()[0] == doctest::Approx(world.rank() == 0 ? -1 : 1));
    });
  });
}

TEST_CASE("restitution is honoured, between bodies of two ranks and against the ground") {
  on_ranks<scene>(2, [](auto& world) {
    connect_halves(world);
    const auto rubber = world.material({.density = 1, .restitution = 0.7});
    world.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, 1}, .offset = -5}, rubber); });
    const double side = world.rank() == 0 ? -1 : 1;
    const auto hitting = world.add(body{.shape = sphere{0.5},
                                        .position = {0.53 * side, 0, 0},
                                        .material = rubber,
                                        .velocity = {-2 * side, 0, 0}});
    const auto falling = world.add(body{.shape = sphere{0.5},
                                        .position = {9 * side, 0, -4.4},
                                        .material = rubber,
                                        .velocity = {0, 0, -3}});
    for (int step = 0; step < 20; ++step) world.step(0.01);
    CHECK(world[hitting].velocity()[0] == doctest::Approx(0.7 * 2 * side));
    CHECK(world[falling].velocity()[2] == doctest::Approx(0.7 * 3));
  });
}

TEST_CASE("a global sphere is fixed, whatever pulls or hits it") {
  on_ranks<scene>(2, [](auto& world) {
    connect_halves(world);
    const auto oak = world.material(materials::oak);
    world.gravity({0, 0, -10});
    handle<sphere> boulder;
    world.global([&](auto& scope) { boulder = scope.add(sphere{5}, oak); });
    world.add_if_local(
        body{.shape = sphere{1}, .position = {1, 0, 7}, .material = oak, .velocity = {0, 0, -9}});
    for (int step = 0; step < 100; ++step) world.step(0.01);
    CHECK(world[boulder].is_fixed());
    CHECK(world[boulder].position() == vec3(0, 0, 0));
    CHECK(world[boulder].velocity() == vec3(0, 0, 0));
  });
}

TEST_CASE("a body with copies is destroyed without synchronize, and no rank waits for it") {
  on_ranks<scene>(2, [](auto& world) {
    connect_halves(world);
    const auto oak = world.material(materials::oak);
    handle<sphere> ball;
    world.exclusive(0, [&] {
      ball = world.add(body{.shape = sphere{1}, .position = {-0.5, 0, 0}, .material = oak});
      world.add(body{.shape = sphere{1}, .position = {-9, 0, 0}, .material = oak});
    });
    world.step(0.01);
    int known = 0;
    world.for_each_known([&](const auto&) { ++known; });
    CHECK(known == (world.rank() == 0 ? 2 : 1));
    world.exclusive(0, [&] { world.destroy(ball); });
    world.step(0.01);
    known = 0;
    world.for_each_known([&](const auto&) { ++known; });
    CHECK(known == (world.rank() == 0 ? 1 : 0));
  });
}

TEST_CASE("a one-sided connection that nobody checks is an error of the first step") {
  refused_on<scene, std::runtime_error>(
      2,
      [](auto& world) {
        world.exclusive(1, [&] { world.connect(0, west); });
        world.step(0.01);
      },
      "rank 1 is connected to rank 0, but rank 0 is not connected to rank 1: ...");
}

TEST_CASE("two worlds of different types live in one program, each with its own ranks") {
  on_ranks<scene>(2, [](auto& outer) {
    on_ranks<scenario<bodies<sphere>>>(3, [&](auto& inner) { CHECK(inner.ranks() == 3); });
    CHECK(outer.ranks() == 2);
  });
}
