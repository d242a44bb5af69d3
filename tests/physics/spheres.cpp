// Spheres on planes and against each other. The closed forms are in tests/validation/spheres.cpp.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

#include "../scenes/spheres_alone.hpp"

using namespace talus;
using balls = scenes::spheres_alone;

namespace {

constexpr real g = 9.81, dt = 1.0 / 240;

struct scene {
  serial::link link;
  world<balls> w{link};

  explicit scene(const material& m, real weight = g) {
    w.material(m);
    w.gravity({0, 0, -weight});
  }
  scene& floor() {
    w.global([&](auto& s) { s.add(plane{}, material_id{}); });
    return *this;
  }
  handle<sphere> ball(real radius, const vec3& position, const vec3& velocity = {0, 0, 0}) {
    return w.add(body{.shape = sphere{radius}, .position = position, .velocity = velocity});
  }
  void run(real time) {
    for (int k = 0, n = static_cast<int>(std::lround(time / dt)); k < n; ++k) w.step(dt);
  }
};

}  // namespace

TEST_CASE("a plastic impact ends on the surface, not short of it") {
  for (const real start : {0.01, 0.03, 0.05}) {
    scene s({.restitution = 0});
    const auto h = s.floor().ball(0.5, {0, 0, 0.5 + start}, {0, 0, -15});
    s.w.step(dt);
    CHECK(std::abs(s.w[h].position()[2] - 0.5) < 1e-12);
    s.run(1);
    CHECK(std::abs(s.w[h].position()[2] - 0.5) < 1e-12);
    CHECK(std::abs(s.w[h].velocity()[2]) < 1e-12);
  }
}

TEST_CASE("a resting ball does not jitter, whatever its restitution") {
  for (const real e : {0.0, 0.5, 1.0}) {
    CAPTURE(e);
    scene s({.restitution = e, .friction = 0.5});
    const auto low = s.floor().ball(0.5, {0, 0, 0.5}), high = s.ball(0.5, {0, 0, 1.5});
    for (int k = 0; k < 480; ++k) {
      s.w.step(dt);
      if (s.w[low].velocity().norm() > 1e-3 || s.w[high].velocity().norm() > 1e-3) {
        CAPTURE(k);
        CHECK(s.w[high].velocity().norm() <= 1e-3);
        break;
      }
    }
    CHECK(s.w[high].velocity().norm() < 1e-9);
    CHECK(s.w[high].position()[2] == doctest::Approx(1.5).epsilon(1e-5));
  }
}

TEST_CASE("the correction of overlaps moves spheres apart and leaves their velocities at zero") {
  scene s({.restitution = 0.5, .friction = 0.5}, 0);
  const auto a = s.ball(0.5, {0, 0, 0}), b = s.ball(0.8, {0.7, 0.3, 0.2});
  const real ma = s.w[a].mass(), mb = s.w[b].mass();
  const vec3 centre = ma * s.w[a].position() + mb * s.w[b].position();
  real before = -1e9;
  for (int k = 0; k < 200; ++k) {
    s.w.step(dt);
    const real gap = (s.w[b].position() - s.w[a].position()).norm() - 1.3;
    CHECK(gap >= before);
    before = gap;
    CHECK(s.w[a].velocity() == vec3(0, 0, 0));
    CHECK(s.w[b].velocity() == vec3(0, 0, 0));
    CHECK(s.w[a].angular_velocity() == vec3(0, 0, 0));
  }
  CHECK(std::abs(before) < 1e-9);
  CHECK((ma * s.w[a].position() + mb * s.w[b].position() - centre).norm() < 1e-13 * mb);
}
