// A body whose velocity grows stays awake, however slow it is.
#include <doctest/doctest.h>

#include <talus/constraint/ball_joint.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>
#include <type_traits>
#include <vector>

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

TEST_CASE("a stack that the correction of positions still moves stays awake until it stands") {
  using boxes = bodies<box, plane>;
  using awake = scenario<boxes, transport<serial>>;
  using sleepy = scenario<boxes, features<sleeping>, transport<serial>>;
  const real size = 0.02, dt = 1.0 / 60;
  const auto stack = [&]<class Scenario>(std::type_identity<Scenario>) {
    serial::link link;
    world<Scenario> w(link);
    w.gravity({0, 0, -9.81});
    w.material({.restitution = 0.3, .friction = 0.5});
    w.global([](auto& s) { s.add(plane{}, {}); });
    for (int k = 0; k < 5; ++k)
      w.add(body{.shape = box{{size, size, size}},
                 .position = {0.05 * size * k, 0, (k + 0.55) * size}});
    for (int k = 0; k < 600; ++k) w.step(dt);
    if constexpr (std::is_same_v<Scenario, sleepy>) CHECK(measure_motion(w).asleep == 5);
    std::vector<vec3> places;
    w.for_each_local([&](const auto& b) { places.push_back(b.position()); });
    return places;
  };
  const auto expected = stack(std::type_identity<awake>{});
  const auto found = stack(std::type_identity<sleepy>{});
  REQUIRE(found.size() == expected.size());
  for (std::size_t k = 0; k < found.size(); ++k)
    CHECK((found[k] - expected[k]).norm() < 1e-3 * size);
}
