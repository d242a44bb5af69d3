// A body whose velocity grows stays awake, however slow it is.
#include <doctest/doctest.h>

#include <talus/constraint/ball_joint.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using scene =
    scenario<bodies<sphere, box, plane>, joints<ball_joint>, features<sleeping>, transport<serial>>;

/// Whether a body of the world sleeps at any time within 10 s.
template <class SetUp>
bool ever_sleeps(const SetUp& set_up, real dt = 1.0 / 60) {
  serial::link link;
  world<scene> w(link);
  set_up(w);
  for (int k = 0; k < static_cast<int>(10 / dt); ++k) {
    w.step(dt);
    if (measure_motion(w).asleep > 0) return true;
  }
  return false;
}
template <class World>
void put_floor(World& w, const vec3& gravity, real friction) {
  w.material({.restitution = 0, .friction = friction});
  w.gravity(gravity);
  w.global([](auto& s) { s.add(plane{}, {}); });
}

}  // namespace

TEST_CASE("a body that begins to slide or to roll at 1e-7 of gravity stays awake, at any dt") {
  // Some that divide the time after which bodies sleep, and a third of it, and some that do not.
  for (const real dt : {1.0 / 60, 1.0 / 240, 0.004, 0.0071, 0.05}) {
    CAPTURE(dt);
    for (const real slope : {1e-7, 1e-5, 1e-4}) {
      CAPTURE(slope);
      CHECK_FALSE(ever_sleeps(
          [&](auto& w) {
            put_floor(w, {9.81 * slope, 0, -9.81}, 0);
            w.add(body{.shape = box{{1, 1, 1}}, .position = {0, 0, 0.5}});
          },
          dt));
      CHECK_FALSE(ever_sleeps(
          [&](auto& w) {
            put_floor(w, {9.81 * slope, 0, -9.81}, 0.5);
            w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0.5}});
          },
          dt));
    }
    CHECK(ever_sleeps(
        [](auto& w) {
          put_floor(w, {9.81e-5, 0, -9.81}, 0.5);
          w.add(body{.shape = box{{1, 1, 1}}, .position = {0, 0, 0.5}});
        },
        dt));
  }
}

TEST_CASE("an inverted pendulum stays awake") {
  CHECK_FALSE(ever_sleeps([](auto& w) {
    w.gravity({0, 0, -9.81});
    w.material({});
    handle<sphere> foot;
    w.global([&](auto& s) { foot = s.add(sphere{0.1}, {}, {0, 0, 0}); });
    const auto bob = w.add(body{.shape = sphere{0.2}, .position = {1e-5, 0, 1}});
    (void)w.join(foot, bob, ball_joint{.at = {0, 0, 0}});
  }));
}
