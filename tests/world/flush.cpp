// Flush fixed bodies are one surface on any ranks, and while they are driven together.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <talus/mesh.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

template <class World>
void put_box(World& w, const vec3& size, const vec3& at) {
  w.global([&](auto& scope) { scope.add(body<box>{.shape = box{size}, .position = at}); });
}
template <class World>
void put_rectangle(World& w, real x0, real x1) {
  const vec3 a(x0, -1, 0), b(x1, -1, 0), c(x1, 1, 0), d(x0, 1, 0);
  const triangle_mesh m({{a, b, c}, {a, c, d}});
  const pose at = placed(m);
  w.global([&](auto& scope) {
    scope.add(
        body<triangle_mesh>{.shape = m, .position = at.position, .orientation = at.orientation});
  });
}

using many = scenario<bodies<sphere, box, triangle_mesh>, solver<reproducible>,
                      decomposition<grid<dynamic, dynamic>>, transport<threads>>;

/// The digest after cubes and spheres have slid over a floor of fixed boxes and a mesh.
std::string slid(int ranks, bool fixed) {
  std::string digest;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<many> w(link, {.lower = {-1, -1}, .upper = {1, 1}});
    w.gravity({0, 0, -9.81});
    w.material({.restitution = 0, .friction = 0});
    const auto tile = [&](const vec3& size, const vec3& at) {
      if (fixed)
        w.add_if_local(body<box>{.shape = box{size}, .position = at, .fixed = true});
      else
        put_box(w, size, at);
    };
    tile({0.5, 1, 0.2}, {-0.25, -0.5, -0.1}), tile({0.5, 1, 0.2}, {0.25, -0.5, -0.1});
    tile({0.5, 1, 0.2}, {-0.25, 0.5, -0.1}), tile({0.5, 1, 0.2}, {0.25, 0.5, -0.1});
    put_rectangle(w, 0.5, 1.5), put_rectangle(w, -1.5, -0.5);
    for (int k = 0; k < 8; ++k) {
      const real y = -0.7 + 0.2 * k;
      w.add_if_local(body{.shape = box{{0.06, 0.06, 0.06}},
                          .position = {-0.3 + 0.01 * k, y, 0.03},
                          .velocity = {1, 0.1, 0}});
      w.add_if_local(body{.shape = sphere{0.03},
                          .position = {0.3 - 0.01 * k, y + 0.1, 0.03},
                          .velocity = {-1, 0.1, 0}});
    }
    for (int k = 0; k < 120; ++k) w.step(1.0 / 240);
    w.for_each_local([&](const auto& b) {
      if (b.position()[2] < 0) return;  // a tile
      CHECK(std::abs(b.velocity()[2]) < 1e-5);
      CHECK(std::abs(std::abs(b.velocity()[0]) - 1) < 1e-5);
    });
    const auto all = state_digest(w);
    if (link.rank() == 0) digest = all;
  });
  return digest;
}

}  // namespace

TEST_CASE("bodies slide over seams with the same bits on 1, 2 and 4 ranks whose cuts lie on them") {
  for (const bool fixed : {false, true}) {
    CAPTURE(fixed);
    const auto one = slid(1, fixed);
    CHECK(slid(2, fixed) == one);
    CHECK(slid(4, fixed) == one);
  }
}

TEST_CASE("boxes that are driven together are one surface, and apart from those that are not") {
  using driving = scenario<bodies<sphere, box>, features<driven>, transport<serial>>;
  serial::link link;
  world<driving> w(link);
  w.gravity({0, 0, -9.81});
  w.material({.restitution = 0, .friction = 0});
  std::vector<handle<box>> floor;
  w.global([&](auto& scope) {
    for (const real x : {-0.5, 0.5})
      floor.push_back(scope.add(body<box>{.shape = box{{1, 2, 0.2}}, .position = {x, 0, -0.1}}));
  });
  for (const auto& h : floor) w.drive(h, gliding{{0.3, 0, 0}});
  const auto cube = w.add(
      body{.shape = box{{0.06, 0.06, 0.06}}, .position = {0.2, 0, 0.03}, .velocity = {-0.5, 0, 0}});
  const auto ball =
      w.add(body{.shape = sphere{0.03}, .position = {0.2, 0.2, 0.03}, .velocity = {-0.5, 0, 0}});
  for (int k = 0; k < 240; ++k) {
    w.step(1.0 / 240);
    CHECK((w[cube].velocity() - vec3(-0.5, 0, 0)).norm() < 1e-5);
    CHECK((w[ball].velocity() - vec3(-0.5, 0, 0)).norm() < 1e-6);
  }
  CHECK(w[cube].position()[0] < -0.25);
}

TEST_CASE("planks that turn together are one surface") {
  using driving = scenario<bodies<sphere, box>, features<driven>, transport<serial>>;
  serial::link link;
  world<driving> w(link);
  w.gravity({0, 0, -9.81});
  w.material({.restitution = 0, .friction = 0});
  std::vector<handle<box>> planks;
  w.global([&](auto& scope) {
    for (int k = -4; k <= 4; ++k)
      planks.push_back(
          scope.add(body<box>{.shape = box{{0.1, 2, 0.2}}, .position = {0.1 * k, 0, -0.1}}));
  });
  for (const auto& h : planks) w.drive(h, turning{.axis = {0, 0, 1}, .speed = 1.5});
  const auto cube = w.add(
      body{.shape = box{{0.06, 0.06, 0.06}}, .position = {0.3, 0, 0.03}, .velocity = {-0.5, 0, 0}});
  const auto ball =
      w.add(body{.shape = sphere{0.03}, .position = {0.3, 0.2, 0.03}, .velocity = {-0.5, 0, 0}});
  for (int k = 0; k < 240; ++k) {
    w.step(1.0 / 240);
    CHECK((w[cube].velocity() - vec3(-0.5, 0, 0)).norm() < 1e-5);
    CHECK((w[ball].velocity() - vec3(-0.5, 0, 0)).norm() < 1e-6);
  }
}

TEST_CASE("a body that is driven from some step on leaves the common surface") {
  using driving = scenario<bodies<sphere, box>, features<driven>, transport<serial>>;
  serial::link link;
  world<driving> w(link);
  w.gravity({0, 0, -9.81});
  w.material({.restitution = 0, .friction = 0});
  std::vector<handle<box>> floor;
  w.global([&](auto& scope) {
    for (const real x : {-0.5, 0.5})
      floor.push_back(scope.add(body<box>{.shape = box{{1, 2, 0.2}}, .position = {x, 0, -0.1}}));
  });
  const auto cube = w.add(
      body{.shape = box{{0.06, 0.06, 0.06}}, .position = {-0.2, 0, 0.03}, .velocity = {1, 0, 0}});
  w.step(1.0 / 240);
  w.drive(floor[1], gliding{{0, 0, 0.4}});  // a step of 0.04 when the cube comes
  real most = -1;
  for (int k = 0; k < 120; ++k) {
    w.step(1.0 / 240);
    most = std::max(most, w[cube].position()[0]);
  }
  CHECK(most < -0.029);
  CHECK(std::abs(w[cube].velocity()[0]) < 0.1);
}

using hard_law = hard_contact<coulomb_friction, newton_restitution>;
using soft_law = soft_contact<linear_spring_dashpot, coulomb_friction>;
TEST_CASE_TEMPLATE("a belt flush with a plane carries what rests on it", Law, hard_law, soft_law) {
  using belts = scenario<bodies<sphere, box, plane>, Law, transport<serial>>;
  for (const bool plane_first : {false, true}) {
    serial::link link;
    world<belts> w(link);
    w.gravity({0, 0, -9.81});
    w.material({.density = 1000, .restitution = 0.2, .friction = 0.5, .stiffness = 1e5});
    const auto put_plane = [&] { w.global([](auto& scope) { scope.add(plane{}, {}); }); };
    if (plane_first) put_plane();
    const auto belt =
        w.add(body<box>{.shape = box{{2, 2, 0.2}}, .position = {0, 0, -0.1}, .fixed = true});
    w[belt].set_velocity({0.2, 0, 0});
    if (!plane_first) put_plane();
    const auto ball = w.add(body{.shape = sphere{0.03}, .position = {0, 0, 0.03}});
    const real dt = 2e-4;
    for (int k = 0; k < 500; ++k) w.step(dt);
    // It rolls backwards on the belt while friction drives it: at its lowest point it moves with
    // it.
    const auto& b = w[ball];
    const vec3 lowest = b.velocity() + b.angular_velocity().cross(vec3(0, 0, -0.03));
    CHECK(lowest[0] == doctest::Approx(0.2).epsilon(0.01));
    CHECK(b.velocity()[0] == doctest::Approx(0.2 * 2 / 7).epsilon(0.02));
  }
}
