// Boxes on planes, against closed forms: sliding, sticking, tipping, coming to rest.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "../scenes/alone.hpp"
#include "../validation/record.hpp"

using namespace talus;
using namespace talus::validation;
using blocks = scenes::alone;

namespace {

constexpr real g = 9.81, dt = 1.0 / 240, degree = pi / 180;

struct scene {
  serial::link link;
  world<blocks> w{link};

  explicit scene(const material& m, real weight = g) {
    w.material(m);
    w.gravity({0, 0, -weight});
  }
  /// A plane through the origin that falls by `angle` along +x.
  scene& floor(real angle = 0) {
    w.global([&](auto& s) { s.add(plane{.normal = {std::sin(angle), 0, std::cos(angle)}}, {}); });
    return *this;
  }
  handle<box> block(const vec3& size, const vec3& position, const quat& q = {1, 0, 0, 0},
                    const vec3& velocity = {0, 0, 0}) {
    return w.add(
        body{.shape = box{size}, .position = position, .velocity = velocity, .orientation = q});
  }
  /// A box that lies flat on the floor at that angle.
  handle<box> flat(const vec3& size, real angle) {
    return block(size, 0.5 * size[2] * vec3(std::sin(angle), 0, std::cos(angle)),
                 rotation(vec3::UnitY(), angle));
  }
  void run(real time) {
    for (int k = 0, n = static_cast<int>(std::lround(time / dt)); k < n; ++k) w.step(dt);
  }
  real energy() {
    const auto m = measure_motion(w);
    return m.kinetic_energy + m.potential_energy;
  }
};

}  // namespace

// The first steps start from zero impulses; with the usual number of iterations it takes some tens
// of steps until the four corners agree.

TEST_CASE("a box slides down an incline with g (sin - mu cos), to 1e-9") {
  const real angle = 30 * degree;
  const vec3 along{std::cos(angle), 0, -std::sin(angle)};
  for (const int iterations : {10, 200})
    for (const real mu : {0.0, 0.2, 0.4, 0.5}) {
      CAPTURE(iterations);
      CAPTURE(mu);
      scene s({.friction = mu});
      s.w.solver().iterations = iterations;
      const auto h = s.floor(angle).flat({1, 1, 1}, angle);
      if (iterations == 10) s.run(1);
      const real before = along.dot(s.w[h].velocity());
      s.run(2);
      const vec3 v = s.w[h].velocity();
      const real a = (along.dot(v) - before) / 2,
                 expected = g * (std::sin(angle) - mu * std::cos(angle));
      check_absolute(fmt::format("box on 30 degrees, {} iterations", iterations),
                     fmt::format("acceleration, mu = {}", mu), expected, a, 1e-9);
      CHECK((v - along.dot(v) * along).norm() < (iterations == 10 ? 1e-6 : 1e-9));
      if (iterations == 10) CHECK(before == doctest::Approx(expected).epsilon(2e-3));
    }
}

TEST_CASE(
    "a box sticks on an incline below the angle of friction: it creeps less than 1e-9 in 10 s") {
  const real angle = 30 * degree;
  for (const int iterations : {10, 400})
    for (const real mu : {0.6, 1.0}) {
      CAPTURE(iterations);
      CAPTURE(mu);
      scene s({.friction = mu});
      s.w.solver().iterations = iterations;
      const auto h = s.floor(angle).flat({1, 1, 1}, angle);
      const vec3 placed = s.w[h].position();
      if (iterations == 10) {
        s.run(0.5);
        CHECK((s.w[h].position() - placed).norm() < 1e-4);
      }
      const vec3 start = s.w[h].position();
      s.run(10);
      const real creep = (s.w[h].position() - start).norm();
      MESSAGE("moved ", (start - placed).norm(), " at first");
      check_error(fmt::format("box on 30 degrees, {} iterations", iterations),
                  fmt::format("creep in 10 s (m), mu = {}", mu), creep, 1e-9);
      CHECK(s.w[h].velocity().norm() < 1e-12);
    }
}

TEST_CASE("the angle of friction is met within 0.01 degrees") {
  const real mu = 0.5, angle = std::atan(mu);
  for (const real off : {-0.01 * degree, 0.01 * degree}) {
    CAPTURE(off);
    scene s({.friction = mu});
    s.w.solver().iterations = 100;
    const auto h = s.floor(angle + off).flat({1, 1, 0.5}, angle + off);
    const vec3 start = s.w[h].position();
    s.run(2);
    const real way = (s.w[h].position() - start).norm();
    const real a = g * (std::sin(angle + off) - mu * std::cos(angle + off));
    MESSAGE("way in 2 s: ", way, ", expected ", std::max(0., 2 * a));
    CHECK(s.w[h].velocity().norm() == doctest::Approx(off < 0 ? 0 : 2 * a).epsilon(0.02));
    check_holds("box on an incline, mu = 0.5",
                fmt::format("slides {:+} degrees off the angle of friction", off / degree), off > 0,
                way > 1e-5);
  }
}

TEST_CASE("a box of 1 by 2 tips at 26.565 degrees, within 0.01") {
  const real critical = std::atan(0.5);
  for (const real off : {-0.01 * degree, 0.01 * degree}) {
    CAPTURE(off);
    scene s({.friction = 1});
    s.w.solver().iterations = 100;
    const auto h = s.floor(critical + off).flat({1, 1, 2}, critical + off);
    s.run(5);
    const vec3 axis = s.w[h].orientation() * vec3::UnitZ();
    const real tilt = std::acos(std::min(
        1., std::abs(axis.dot(vec3(std::sin(critical + off), 0, std::cos(critical + off))))));
    MESSAGE("off by ", off / degree, " degrees: tilt after 5 s ", tilt);
    check_holds("box of 1 by 2 on an incline",
                fmt::format("tips {:+} degrees off 26.565", off / degree), off > 0, tilt > 0.5);
    if (off < 0) CHECK(tilt < 1e-3);
  }
}

TEST_CASE("static friction holds where dynamic friction would let slide, until the box moves") {
  const real angle = 25 * degree;  // tan = 0.466
  for (const bool correction_impulse : {false, true}) {
    CAPTURE(correction_impulse);
    scene s({.friction = 0.6, .dynamic_friction = 0.3});
    const auto h = s.floor(angle).flat({1, 1, 1}, angle);
    const vec3 along{std::cos(angle), 0, -std::sin(angle)};
    if (correction_impulse) s.w[h].set_velocity(0.5 * along);
    s.run(2);
    const real a = (along.dot(s.w[h].velocity()) - (correction_impulse ? 0.5 : 0)) / 2;
    CHECK(std::abs(a - (correction_impulse ? g * (std::sin(angle) - 0.3 * std::cos(angle)) : 0)) <
          (correction_impulse ? 2e-4 : 1e-9));
  }
}

TEST_CASE(
    "a box dropped flat, on an edge or on a corner, or tilted and let go, comes to rest flat") {
  const auto turn = [](real angle, const vec3& axis) { return rotation(axis.normalized(), angle); };
  const vec3 size{1, 0.8, 0.6};
  const std::vector<quat> ways{turn(0, {1, 0, 0}),   turn(0.2, {0, 1, 0}), turn(0.78, {0, 1, 0}),
                               turn(1.2, {1, 0, 0}), turn(0.6, {1, 1, 0}), turn(0.9, {1, 2, 3})};
  for (const real e : {0.0, 0.4})
    for (std::size_t k = 0; k < ways.size(); ++k) {
      CAPTURE(e);
      CAPTURE(k);
      scene s({.restitution = e, .friction = 0.5});
      const auto h = s.floor().block(size, {0, 0, 1.2}, ways[k]);
      real energy = s.energy(), gain = 0;
      for (int i = 0; i < 240 * 5; ++i) {
        s.w.step(dt);
        const real now = s.energy();
        gain = std::max(gain, now - energy);
        energy = std::min(energy, now);
      }
      const real fall = s.w[h].mass() * g * 0.3;
      const auto m = measure_motion(s.w);
      MESSAGE("e ", e, " way ", k, ": kinetic energy ", m.kinetic_energy / fall, ", gain ",
              gain / fall, " of m g h/2; rests at ", s.w[h].position()[2]);
      CHECK(m.kinetic_energy < 1e-12 * fall);
      CHECK(gain < 0.02 * fall);
      const vec3 up = s.w[h].orientation().conjugate() * vec3::UnitZ();
      CHECK(up.cwiseAbs().maxCoeff() > 1 - 1e-6);
      int axis = 0;
      up.cwiseAbs().maxCoeff(&axis);
      CHECK(std::abs(s.w[h].position()[2] - 0.5 * size[axis]) < 1e-4);
    }
}

TEST_CASE("ten boxes in a stack stand for 5 s, and rest where the iterations suffice") {
  for (const int iterations : {10, 200}) {
    CAPTURE(iterations);
    scene s({.friction = 0.5});
    s.w.solver().iterations = iterations;
    s.floor();
    std::vector<handle<box>> stack;
    for (int k = 0; k < 10; ++k) stack.push_back(s.block({1, 1, 1}, {0, 0, k + 0.5}));
    s.run(5);
    const vec3 top = s.w[stack.back()].position();
    const auto m = measure_motion(s.w);
    const real fall = m.mass * g * 0.5;
    MESSAGE(iterations, " iterations: top at ", top, ", kinetic energy ", m.kinetic_energy / fall);
    CHECK(std::hypot(top[0], top[1]) < (iterations < 200 ? 1e-3 : 1e-4));
    CHECK(std::abs(top[2] - 9.5) < 1e-5);
    CHECK(m.kinetic_energy < (iterations < 200 ? 1e-6 : 1e-12) * fall);
  }
}

TEST_CASE("PYRAMID(10) stands for 5 s, the stiller the more iterations") {
  for (const int iterations : {10, 50}) {
    CAPTURE(iterations);
    scene s({.friction = 0.6});
    s.w.solver().iterations = iterations;
    s.floor();
    std::vector<handle<box>> all;
    std::vector<vec3> start;
    for (int row = 0; row < 10; ++row)
      for (int k = 0; k < 10 - row; ++k) {
        start.push_back({k + 0.5 * row, 0, row + 0.5});
        all.push_back(s.block({1, 1, 1}, start.back()));
      }
    s.run(5);
    real drift = 0;
    for (std::size_t k = 0; k < all.size(); ++k)
      drift = std::max(drift, (s.w[all[k]].position() - start[k]).norm());
    const auto m = measure_motion(s.w);
    const real fall = m.mass * g * 0.5;
    MESSAGE(iterations, " iterations: largest drift ", drift, ", kinetic energy ",
            m.kinetic_energy / fall);
    CHECK(drift < 1e-3);
    CHECK(m.kinetic_energy < (iterations < 50 ? 1e-6 : 1e-12) * fall);
  }
}

TEST_CASE("HEAVY(100) stands for 5 s with 400 iterations") {
  scene s({.friction = 0.5});
  s.w.solver().iterations = 400;
  s.floor();
  const auto heavy = s.w.material({.density = 100, .friction = 0.5});
  std::vector<handle<box>> stack;
  for (int k = 0; k < 10; ++k)
    stack.push_back(s.w.add(body{.shape = box{{1, 1, 1}},
                                 .position = {0, 0, k + 0.5},
                                 .material = k == 9 ? heavy : material_id{}}));
  s.run(5);
  const vec3 top = s.w[stack.back()].position();
  MESSAGE("top at ", top);
  CHECK(std::hypot(top[0], top[1]) < 0.1);
  CHECK(std::abs(top[2] - 9.5) < 0.02);
}

TEST_CASE("the correction of overlaps moves boxes apart and leaves their velocities at zero") {
  scene s({.restitution = 0.5, .friction = 0.5}, 0);
  const auto a = s.block({1, 1, 1}, {0, 0, 0}),
             b = s.block({0.8, 1.2, 0.5}, {0.6, 0.5, 0.2},
                         rotation(vec3(1, 2, 3).normalized(), 0.4));
  const real ma = s.w[a].mass(), mb = s.w[b].mass();
  const vec3 centre = ma * s.w[a].position() + mb * s.w[b].position();
  for (int k = 0; k < 400; ++k) {
    s.w.step(dt);
    CHECK(s.w[a].velocity() == vec3(0, 0, 0));
    CHECK(s.w[b].velocity() == vec3(0, 0, 0));
    CHECK(s.w[a].angular_velocity() == vec3(0, 0, 0));
    CHECK(s.w[b].angular_velocity() == vec3(0, 0, 0));
  }
  CHECK((ma * s.w[a].position() + mb * s.w[b].position() - centre).norm() < 1e-12 * mb);
  real deepest = 0;
  collide(s.w[a].shape(), s.w[a].pose(), s.w[b].shape(), s.w[b].pose(), 0.1,
          [&](const contact_geometry& c) { deepest = std::min(deepest, c.gap); });
  CHECK(deepest > -1e-6);
}

TEST_CASE(
    "static friction needs no gravity: a box that a force presses on holds and slides as one "
    "that weighs as much") {
  using pressed = scenario<bodies<box, plane>, transport<serial>, features<forces>>;
  for (const real pull : {4.0, 5.5}) {  // of a normal force of 10: 3 is dynamic, 5 is static
    CAPTURE(pull);
    serial::link link;
    world<pressed> w(link);
    const auto m = w.material({.friction = 0.5, .dynamic_friction = 0.3});
    w.global([&](auto& s) { s.add(plane{}, m); });
    const auto below = w.add(body{.shape = box{{1, 1, 1}}, .position = {0, 0, 0.5}, .material = m});
    const auto above = w.add(body{.shape = box{{1, 1, 1}}, .position = {0, 0, 1.5}, .material = m});
    for (int k = 0; k < 480; ++k) {
      const real part = std::min(1.0, k / 120.0);
      w[above].add_force({0, 0, -10});
      w[below].add_force({pull * part, 0, 0});
      w.step(dt);
    }
    if (pull < 5)
      CHECK(std::abs(w[below].position()[0]) < 1e-3);
    else
      CHECK(w[below].velocity()[0] > 1);
  }
}
