// Bodies with continuous collision, with substeps and moving walls: no tunnelling, and impacts with
// the velocities of the law of impact.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/substepping.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using divided = scenario<bodies<sphere, box, plane>, solver<substepping>, transport<serial>,
                         features<continuous_collision, energy_ledger, momentum_balance>>;
using moved = scenario<bodies<sphere, box, plane>, transport<serial>,
                       features<continuous_collision, driven, energy_ledger>>;
constexpr real dt = 1.0 / 240;

template <class Scenario>
struct course {
  serial::link link;
  world<Scenario> w{link};

  explicit course(real restitution) { w.material({.restitution = restitution, .friction = 0}); }
  template <class Shape>
  handle<Shape> global(const Shape& shape, const vec3& at = {0, 0, 0}) {
    handle<Shape> h;
    w.global([&](auto& s) { h = s.add(shape, material_id{}, at); });
    return h;
  }
  auto ball(const vec3& at, const vec3& v) {
    return w.add(body{.shape = sphere{1}, .position = at, .velocity = v});
  }
};

}  // namespace

TEST_CASE("where the step is divided, a bullet rebounds from a thin wall with -e v") {
  for (const real speed : {1000 / dt, 30 / dt, 2 / dt})
    for (const real e : {0.0, 0.5, 1.0}) {
      CAPTURE(speed);
      CAPTURE(e);
      course<divided> c(e);
      c.global(box{{0.01, 50, 50}});
      const auto h = c.ball({-1.5 * speed * dt - 3, 0, 0}, {speed, 0, 0});
      real furthest = -1e9;
      for (int k = 0; k < 6; ++k) {
        c.w.step(dt);
        furthest = std::max(furthest, c.w[h].position()[0]);
      }
      CHECK(furthest <= -1.005 + 2e-6);
      CHECK(furthest > -1.52);
      CHECK(c.w[h].velocity()[0] == doctest::Approx(-e * speed).epsilon(1e-6));
      CHECK(measure_energy(c.w).worst < 1e-11);
      CHECK(measure_momentum(c.w).error() < 1e-11);
    }
}

TEST_CASE("where the step is divided, a ball that is dropped rises to e^2 of its height") {
  for (const real e : {0.5, 0.8, 1.0}) {
    CAPTURE(e);
    course<divided> c(e);
    c.w.gravity({0, 0, -10});
    c.global(plane{.normal = {0, 0, 1}});
    const auto h = c.ball({0, 0, 21}, {0, 0, 0});
    real top = 0;
    bool struck = false;
    for (int k = 0; k < 1000 && !(struck && c.w[h].velocity()[2] < 0); ++k) {
      c.w.step(dt);
      struck = struck || c.w[h].velocity()[2] > 0;
      if (struck) top = std::max(top, c.w[h].position()[2] - 1);
    }
    CHECK(top == doctest::Approx(20 * e * e).epsilon(0.01));
    CHECK(top < 20 * e * e * 1.001);  // no gain of energy
    CHECK(measure_energy(c.w).worst < 1e-11);
  }
}

TEST_CASE("where the step is divided, bullets that meet exchange their momentum") {
  course<divided> c(1);
  const auto left = c.ball({-700, 0, 0}, {500 / dt, 0, 0});
  const auto right = c.ball({650, 0, 0}, {-300 / dt, 0, 0});
  for (int k = 0; k < 3; ++k) c.w.step(dt);
  CHECK(c.w[left].velocity()[0] == doctest::Approx(-300 / dt).epsilon(1e-9));
  CHECK(c.w[right].velocity()[0] == doctest::Approx(500 / dt).epsilon(1e-9));
  CHECK(c.w[left].position()[0] < c.w[right].position()[0]);
}

TEST_CASE("a wall that moves far in a step carries what it strikes along, and passes nothing") {
  for (const real speed : {1.0 / dt, 20 / dt, 300 / dt})
    for (const real e : {0.0, 1.0})
      for (const bool thin : {true, false}) {
        CAPTURE(speed);
        CAPTURE(e);
        CAPTURE(thin);
        course<moved> c(e);
        const auto rests = c.ball({5 + 0.3 * speed * dt, 0.2, 0}, {0, 0, 0});
        const auto drive = [&](auto h) {
          c.w.drive(h, [=](real) { return rigid_velocity{.velocity = {speed, 0, 0}}; });
          return h;
        };
        std::vector<real> ahead;
        const auto run = [&](auto h) {
          for (int k = 0; k < 60; ++k) {
            c.w.step(dt);
            ahead.push_back(c.w[rests].position()[0] - 1 - c.w[h].position()[0]);
          }
        };
        if (thin)
          run(drive(c.global(box{{0.01, 50, 50}})));
        else
          run(drive(c.global(plane{.normal = {1, 0, 0}})));
        CHECK(*std::min_element(ahead.begin(), ahead.end()) > -1e-3);
        CHECK(c.w[rests].velocity()[0] == doctest::Approx((1 + e) * speed).epsilon(1e-6));
        CHECK(measure_energy(c.w).worst < 1e-9);
      }
}

TEST_CASE("a bullet meets a wall that comes or goes where that is, with its velocity") {
  for (const real wall : {-40 / dt, 40 / dt, 90 / dt}) {
    CAPTURE(wall);
    course<moved> c(1);
    const auto h = c.global(box{{0.01, 50, 50}});
    c.w.drive(h, [=](real) { return rigid_velocity{.velocity = {wall, 0, 0}}; });
    const auto bullet = c.ball({-130, 0, 0}, {100 / dt, 0, 0});
    real last = 0;
    for (int k = 0; k < 20; ++k) {
      c.w.step(dt);
      last = c.w[bullet].position()[0] + 1.005 - c.w[h].position()[0];
      CHECK(last < 1e-6);
    }
    CHECK(c.w[bullet].velocity()[0] == doctest::Approx(2 * wall - 100 / dt).epsilon(1e-6));
    CHECK(last < -10);
  }
}

TEST_CASE("a blade that turns by a sixth of a turn in a step strikes what is in its way") {
  course<moved> c(0);
  const auto blade = c.global(box{{40, 0.02, 4}});
  const real turn = pi / 3 / dt;
  c.w.drive(blade, [=](real) { return rigid_velocity{.angular_velocity = {0, 0, turn}}; });
  const auto rests = c.ball({9, 9, 0}, {0, 0, 0});
  c.w.step(dt);
  const vec3 v = c.w[rests].velocity(), p = c.w[rests].position();
  const real arm = std::hypot(9.0, 9.0);
  // At its impact the blade has its velocity w r across the blade.
  CHECK(v.norm() > 0.9 * turn * arm);
  CHECK(v.norm() < 1.2 * turn * arm);
  // It is still in front of the blade, which is at 60 degrees now.
  const vec3 normal(-std::sin(pi / 3), std::cos(pi / 3), 0);
  CHECK(normal.dot(p) > 1 - 0.02);
}
