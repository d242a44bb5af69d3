// Spheres on planes and against each other, against closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;
using balls = scenario<bodies<sphere, plane>, transport<serial>>;

namespace {

constexpr real g = 9.81, dt = 1.0 / 240, degree = pi / 180;

struct scene {
  serial::link link;
  world<balls> w{link};

  explicit scene(const material& m, real weight = g) {
    w.material(m);
    w.gravity({0, 0, -weight});
  }
  /// A plane through the origin that falls by `angle` along +x.
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
  void run(real time, real step = dt) {
    for (int k = 0, n = static_cast<int>(std::lround(time / step)); k < n; ++k) w.step(step);
  }
};

}  // namespace

TEST_CASE("a sliding sphere rolls with 5/7 of its speed after 2 v0 / (7 mu g)") {
  const real v0 = 5, mu = 0.3, radius = 0.5;
  scene s({.friction = mu});
  const auto h = s.floor().ball(radius, {0, 0, radius}, {v0, 0, 0});
  real slipping = 0;
  for (int k = 1; k <= 240; ++k) {
    s.w.step(dt);
    const real slip = s.w[h].velocity()[0] - radius * s.w[h].angular_velocity()[1];
    if (slip > 1e-9) slipping = k * dt;
  }
  const real v = s.w[h].velocity()[0], t = 2 * v0 / (7 * mu * g);
  MESSAGE("v_f - 25/7 = ", v - 25.0 / 7, ", slips until ", slipping, ", t* = ", t);
  CHECK(std::abs(v - 25.0 / 7) < 1e-6);
  CHECK(std::abs(slipping - t) <= dt);
  // The way: 12 v0^2 / (49 mu g) while it slips, then v_f.
  const real way = 12 * v0 * v0 / (49 * mu * g) + 25.0 / 7 * (1 - t);
  CHECK(std::abs(s.w[h].position()[0] - way) < 0.02);
  CHECK(std::abs(s.w[h].position()[2] - radius) < 1e-12);
}

TEST_CASE(
    "a sphere rolls down an incline with 5/7 g sin(angle), and slides with g (sin - mu cos)") {
  const real angle = 30 * degree, radius = 0.5, critical = 2.0 / 7 * std::tan(angle);
  for (const real mu : {0.0, 0.05, 0.16, 0.999 * critical, 1.001 * critical, 0.17, 0.3, 1.0}) {
    CAPTURE(mu);
    scene s({.friction = mu});
    const auto h = s.floor(angle).ball(radius, radius * vec3(std::sin(angle), 0, std::cos(angle)));
    s.run(2);
    const vec3 along{std::cos(angle), 0, -std::sin(angle)};
    const real a = along.dot(s.w[h].velocity()) / 2;
    const bool rolls = mu >= critical;
    const real expected =
        rolls ? 5.0 / 7 * g * std::sin(angle) : g * (std::sin(angle) - mu * std::cos(angle));
    CHECK(std::abs(a - expected) < 1e-9);
    const real slip = along.dot(s.w[h].velocity()) - radius * s.w[h].angular_velocity()[1];
    CHECK((std::abs(slip) < 1e-9) == rolls);
  }
}

TEST_CASE(
    "a bouncing ball rests after sqrt(2h/g)(1+e)/(1-e), within 5 % at 1/240, and nearer with dt") {
  // When the ball last moves, over several heights so that the phase of the steps averages out.
  const auto error = [](real e, real step) {
    real sum = 0;
    const int heights = 16;
    for (int i = 0; i < heights; ++i) {
      const real h = 1 + 0.01 * i;
      scene s({.restitution = e});
      const auto ball = s.floor().ball(0.5, {0, 0, 0.5 + h});
      const real expected = std::sqrt(2 * h / g) * (1 + e) / (1 - e);
      real last = 0;
      for (int k = 1; k * step < 1.5 * expected; ++k) {
        s.w.step(step);
        if (std::abs(s.w[ball].velocity()[2]) > 1e-9) last = k * step;
      }
      CHECK(std::abs(s.w[ball].position()[2] - 0.5) < 1e-9);
      sum += std::abs(last / expected - 1);
    }
    return sum / heights;
  };
  for (const real e : {0.5, 0.8, 0.9}) {
    CAPTURE(e);
    const real coarse = error(e, dt), fine = error(e, dt / 16);
    MESSAGE("e = ", e, ": relative error ", coarse, " at 1/240, ", fine, " at 1/3840");
    CHECK(coarse < 0.05);
    // Each bounce is late by O(dt), and the number of bounces that are resolved grows as log(1/dt).
    CHECK(fine < coarse / 3);
  }
}

TEST_CASE("a bouncing ball returns to h e^(2k), and never gains energy") {
  for (const real e : {0.5, 0.8, 1.0}) {
    CAPTURE(e);
    scene s({.restitution = e});
    const auto ball = s.floor().ball(0.5, {0, 0, 1.5});
    const real step = dt / 16;
    real apex = 0, before = 0, expected = e * e;
    int bounces = 0;
    for (int k = 0; k < 20 * 240 * 16 && bounces < 6; ++k) {
      s.w.step(step);
      const real v = s.w[ball].velocity()[2], height = s.w[ball].position()[2] - 0.5;
      if (before < 0 && v > 0 && ++bounces > 1) {
        CHECK(apex == doctest::Approx(expected).epsilon(0.01));
        if (e == 1) CHECK(apex < 1 + 1e-3);
        expected *= e * e;
      }
      apex = v > 0 ? height : apex;
      before = v;
    }
    CHECK(bounces == 6);
  }
}

TEST_CASE("Newton's cradle with gaps passes ((1+e)/2)^(n-1) on") {
  for (const real e : {0.0, 0.5, 0.9, 1.0}) {
    CAPTURE(e);
    scene s({.restitution = e}, 0);
    const real v0 = 1, gap = 3 * v0 * dt;
    std::vector<handle<sphere>> row;
    for (int k = 0; k < 5; ++k)
      row.push_back(s.ball(0.5, {k * (1 + gap), 0, 0}, {k == 0 ? v0 : 0, 0, 0}));
    const real mass = s.w[row[0]].mass();
    s.run(0.1);
    real momentum = 0;
    // Until the last ball has its speed; ever slower ones follow behind.
    for (const auto h : row) momentum += mass * s.w[h].velocity()[0];
    CHECK(std::abs(momentum - mass * v0) < 1e-12 * mass);
    if (e == 0) continue;  // they all move on together, later
    const real last = s.w[row[4]].velocity()[0];
    CHECK(std::abs(last - std::pow((1 + e) / 2, 4)) < 1e-9);
  }
}

TEST_CASE("a cradle whose balls touch obeys the simultaneous law of Newton") {
  scene s({.restitution = 1}, 0);
  s.w.solver().iterations = 400;
  std::vector<handle<sphere>> row;
  for (int k = 0; k < 5; ++k) row.push_back(s.ball(0.5, {1.0 * k, 0, 0}, {k == 0 ? 1. : 0., 0, 0}));
  s.w.step(dt);
  CHECK(std::abs(s.w[row[0]].velocity()[0] + 0.6) < 1e-9);
  for (int k = 1; k < 5; ++k)
    CHECK(std::abs(s.w[row[static_cast<std::size_t>(k)]].velocity()[0] - 0.4) < 1e-9);
}

TEST_CASE(
    "oblique impact of a sphere on a plane: sliding beyond v_t / v_n = 3.5 mu (1 + e), sticking "
    "below") {
  const real e = 0.5, mu = 0.3, radius = 0.5, speed = 3;
  real worst = 0;
  int sliding = 0, sticking = 0;
  for (int k = 0; k <= 89; ++k) {
    const real angle = k * degree, heading = 0.7 + k;  // from the normal; about it
    const real vn = speed * std::cos(angle), vt = speed * std::sin(angle);
    const vec3 t{std::cos(heading), std::sin(heading), 0};
    scene s({.restitution = e, .friction = mu}, 0);
    const auto h =
        s.floor().ball(radius, {0, 0, radius + 0.37 * vn * dt}, vt * t - vn * vec3(0, 0, 1));
    s.run(2 * dt);
    const bool slides = vt >= 3.5 * mu * (1 + e) * vn;
    ++(slides ? sliding : sticking);
    const real vt_after = slides ? vt - mu * (1 + e) * vn : 5.0 / 7 * vt;
    const real spin = (slides ? 2.5 * mu * (1 + e) * vn : 5.0 / 7 * vt) / radius;
    const vec3 v = vt_after * t + e * vn * vec3(0, 0, 1), w = spin * vec3(0, 0, 1).cross(t);
    worst = std::max(
        {worst, (s.w[h].velocity() - v).norm(), radius * (s.w[h].angular_velocity() - w).norm()});
  }
  MESSAGE("largest error ", worst, " over ", sliding, " sliding and ", sticking,
          " sticking impacts");
  CHECK(worst < 1e-9);
  CHECK(sliding > 10);
  CHECK(sticking > 10);
}

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
