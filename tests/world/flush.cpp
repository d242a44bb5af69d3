// Flush fixed bodies are one surface on any ranks, and while they are driven together.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
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

#include "../flush_scene.hpp"

using namespace talus;

namespace {

using many = scenario<bodies<sphere, box, triangle_mesh>, solver<reproducible>,
                      decomposition<grid<dynamic, dynamic>>, transport<threads>>;

/// The digest after cubes and spheres have slid over a floor of fixed boxes and a mesh.
std::string slid(int ranks, bool fixed) {
  std::string digest;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<many> w(link, {.lower = {-1, -1}, .upper = {1, 1}});
    without_friction(w);
    put_tiles(w, fixed), put_rims(w), put_sliders(w);
    for (int k = 0; k < 120; ++k) w.step(1.0 / 240);
    check_sliders(w, 1e-6);
    const auto all = state_digest(w);
    if (link.rank() == 0) digest = all;
  });
  return digest;
}

using driving = scenario<bodies<sphere, box>, features<driven>, transport<serial>>;

/// Global boxes beside each other along x, with the middle at x = 0.
std::vector<handle<box>> row_of_boxes(world<driving>& w, real width, int count) {
  std::vector<handle<box>> all;
  w.global([&](auto& scope) {
    for (int k = 0; k < count; ++k)
      all.push_back(scope.add(body<box>{.shape = box{{width, 2, 0.2}},
                                        .position = {(k - 0.5 * (count - 1)) * width, 0, -0.1}}));
  });
  return all;
}
/// A cube and a sphere slide from x at 0.5 against the x axis for one unit of time. Returns the
/// cube.
handle<box> check_slides(world<driving>& w, real x) {
  const vec3 v(-0.5, 0, 0);
  const auto cube =
      w.add(body{.shape = box{{0.06, 0.06, 0.06}}, .position = {x, 0, 0.03}, .velocity = v});
  const auto ball = w.add(body{.shape = sphere{0.03}, .position = {x, 0.2, 0.03}, .velocity = v});
  for (int k = 0; k < 240; ++k) {
    w.step(1.0 / 240);
    CHECK((w[cube].velocity() - v).norm() < 1e-5);
    CHECK((w[ball].velocity() - v).norm() < 1e-6);
  }
  return cube;
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
  serial::link link;
  world<driving> w(link);
  without_friction(w);
  const auto floor = row_of_boxes(w, 1, 2);
  for (const auto& h : floor) w.drive(h, gliding{{0.3, 0, 0}});
  const auto cube = check_slides(w, 0.2);
  CHECK(w[cube].position()[0] < -0.25);
}

TEST_CASE("planks that turn together are one surface") {
  serial::link link;
  world<driving> w(link);
  without_friction(w);
  const auto planks = row_of_boxes(w, 0.1, 9);
  for (const auto& h : planks) w.drive(h, turning{.axis = {0, 0, 1}, .speed = 1.5});
  check_slides(w, 0.3);
}

TEST_CASE("a body that is driven from some step on leaves the common surface") {
  serial::link link;
  world<driving> w(link);
  without_friction(w);
  const auto floor = row_of_boxes(w, 1, 2);
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
