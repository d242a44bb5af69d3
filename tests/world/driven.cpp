// features<driven>: global bodies follow their motion exactly, and contacts use their velocity.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <talus/observe/energy.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/summary.hpp>
#include <talus/observe/warnings_of_scales.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using scene = scenario<bodies<sphere, box, plane>, transport<serial>,
                       features<driven, energy_ledger, momentum_balance>>;
using scene_world = world<scene>;

struct course {
  serial::link link;
  scene_world w{link};
  material_id rough = w.material({.density = 2, .friction = 0.5});

  template <class Shape>
  handle<Shape> global(const Shape& shape, const vec3& at = {0, 0, 0}) {
    handle<Shape> h;
    w.global([&](auto& s) { h = s.add(shape, rough, at); });
    return h;
  }
  void run(real time, real dt) {
    for (long n = std::lround(time / dt); n > 0; --n) w.step(dt);
    CHECK(measure_energy(w).worst < 1e-12);
    CHECK(measure_momentum(w).error() < 1e-12);
  }
};

}  // namespace

TEST_CASE("poses follow from the time alone, however many steps there are") {
  course c;
  const auto floor = c.global(plane{.normal = {0, 0, 2}, .offset = 0.3});
  const auto wall = c.global(plane{.normal = {1, 0, 0}, .offset = -1});
  const auto paddle = c.global(box{{1, 2, 3}}, {4, 0, 0});
  const auto ball = c.global(sphere{1}, {0, 9, 0});
  const oscillation shake{.amplitude = {0.1, 0, 0.2}, .frequency = 3, .phase = 0.4};
  const turning spin{.about = {1, 0, 0}, .axis = {0, 1, 0}, .speed = -0.7};
  c.w.drive(floor, shake);
  c.w.drive(wall, spin);
  c.w.drive(paddle, spin);
  c.w.drive(ball, gliding{{0, 1, 0}});
  c.run(40, 0.01);
  const real t = c.w.time();
  const vec3 by = shake(t).shift;
  CHECK(std::abs(c.w[floor].shape().offset - (0.3 + by[2])) < 1e-14);
  CHECK((c.w[floor].position() - by).norm() < 1e-14);
  const quat q = rotation({0, 1, 0}, -0.7 * t);
  CHECK((c.w[wall].shape().normal - rotated(q, vec3(1, 0, 0))).norm() < 1e-14);
  CHECK(std::abs(c.w[wall].shape().distance(vec3(1, 0, 0)) - 2) < 1e-14);
  CHECK((c.w[paddle].position() - (vec3(1, 0, 0) + rotated(q, vec3(3, 0, 0)))).norm() < 1e-14);
  CHECK(std::abs(std::abs(c.w[paddle].orientation().dot(q)) - 1) < 1e-14);
  CHECK(std::abs(c.w[ball].position()[1] - (9 + t)) < 1e-13);
}

TEST_CASE("a plane that is driven again turns about where its reference point has come") {
  course c;
  const auto wall = c.global(plane{.normal = {1, 0, 0}, .offset = -1});
  c.w.drive(wall, gliding{{0.5, 0, 1}});
  c.run(2, 0.01);
  const vec3 point = c.w[wall].position();
  CHECK((point - vec3(1, 0, 2)).norm() < 1e-12);
  CHECK(std::abs(c.w[wall].shape().distance(point) - 1) < 1e-12);
  c.w.drive(wall, [point](real) {
    return rigid_velocity{.angular_velocity = {0, 0.5, 0}, .about = point};
  });
  c.run(1, 0.01);
  CHECK((c.w[wall].position() - point).norm() < 1e-12);
  CHECK(std::abs(c.w[wall].shape().distance(point) - 1) < 1e-12);
  CHECK((c.w[wall].shape().normal - rotated(rotation({0, 1, 0}, 0.5), vec3(1, 0, 0))).norm() <
        1e-9);
}

TEST_CASE("a motion that begins later begins where the body is") {
  course c;
  const auto lid = c.global(plane{.normal = {0, 0, -1}, .offset = -4});
  const auto paddle = c.global(box{{1, 2, 3}}, {4, 0, 0});
  const auto wall = c.global(plane{.normal = {1, 0, 0}, .offset = -9});
  c.run(1, 0.01);
  c.w.drive(lid, gliding{{0, 0, -0.5}});
  c.w.drive(paddle, turning{.axis = {0, 0, 1}, .speed = 0.5});
  c.w.drive(wall, oscillation{.amplitude = {0.1, 0, 0}, .frequency = 2, .phase = 1});
  c.run(0.5, 0.01);
  CHECK(std::abs(c.w[lid].position()[2] + 0.25) < 1e-13);
  CHECK((c.w[paddle].position() - 4 * vec3(std::cos(0.25), std::sin(0.25), 0)).norm() < 1e-12);
  CHECK(std::abs(c.w[wall].position()[0] - 0.1 * (std::sin(2 * pi + 1) - std::sin(1.0))) < 1e-12);
  // Again, from there.
  c.w.drive(lid, gliding{{0, 0, 1}});
  c.run(0.5, 0.01);
  CHECK(std::abs(c.w[lid].position()[2] - 0.25) < 1e-13);
  // A function of the time of the world that would jump is refused.
  const auto jumps = [](real t) { return rigid_displacement{.shift = {0, 0, t}}; };
  CHECK_THROWS_WITH_AS(c.w.drive(paddle, jumps),
                       doctest::Contains("the jump of 2 as a velocity; subtract"),
                       std::invalid_argument);
  c.w.add(body{.shape = sphere{0.5}, .position = {0, 0, -1}, .material = c.rough});
  c.w.add(body{.shape = sphere{0.3}, .position = {0, 0, -3}, .material = c.rough});
  const char* const words =
      "the jump of 2, which is 5 radii of the bodies that move, as a velocity";
  CHECK_THROWS_WITH_AS(c.w.drive(paddle, jumps), doctest::Contains(words), std::invalid_argument);
  CHECK_THROWS_WITH_AS(c.w.drive(lid, jumps), doctest::Contains("at time 2"),
                       std::invalid_argument);
  const real begin = c.w.time();
  c.w.drive(lid, [=](real t) { return rigid_displacement{.shift = {0, 0, t - begin}}; });
  c.run(0.5, 0.01);
  CHECK(std::abs(c.w[lid].position()[2] - 0.75) < 1e-12);
}

TEST_CASE("a velocity is added up, with an error of second order in the step") {
  real error[2];
  for (int k = 0; k < 2; ++k) {
    course c;
    const auto bar = c.global(box{{1, 1, 1}}, {1, 0, 0});
    const auto wall = c.global(plane{});
    c.w.drive(bar, [](real) { return rigid_velocity{.angular_velocity = {0, 0, 0.5}}; });
    c.w.drive(wall, [](real t) { return rigid_velocity{.velocity = {1, 0, std::cos(t)}}; });
    c.run(2, 0.04 / (1 + k));
    error[k] = std::abs(c.w[wall].shape().offset - std::sin(2.0));
    CHECK((c.w[bar].position() - vec3(std::cos(1.0), std::sin(1.0), 0)).norm() < 1e-12);
  }
  CHECK(error[0] < 1e-4);
  CHECK(error[0] / error[1] == doctest::Approx(4).epsilon(0.01));
}

TEST_CASE("what lies on a conveyor goes along with it") {
  const real speed = 0.7;
  for (const bool moves : {true, false}) {
    course c;
    c.w.gravity({0, 0, -10});
    const auto floor = c.global(plane{});
    if (moves)
      c.w.drive(floor, gliding{{speed, 0, 0}});
    else
      c.w.drive(floor, belt{{speed, 0, 0}});
    const auto crate = c.w.add(box{{1, 1, 0.4}}, c.rough, {0, 0, 0.2});
    const auto ball = c.w.add(sphere{0.5}, c.rough, {0, 3, 0.5});
    c.run(1, 0.005);
    CHECK((c.w[crate].velocity() - vec3(speed, 0, 0)).norm() < 1e-9);
    // A ball that starts to roll: friction gives it m v and I w = m v r, until v + r w = u.
    CHECK(c.w[ball].velocity()[0] == doctest::Approx(2 * speed / 7).epsilon(1e-9));
    CHECK(c.w[ball].velocity()[0] - 0.5 * c.w[ball].angular_velocity()[1] ==
          doctest::Approx(speed).epsilon(1e-9));
    CHECK(c.w[floor].shape().offset == 0);
    CHECK(c.w[floor].position()[0] == doctest::Approx(moves ? speed : 0));
    // Work of the belt: the energy of the bodies, and the same amount for each is lost by sliding.
    const real mass = c.w[crate].mass();
    CHECK(measure_energy(c.w).total.work ==
          doctest::Approx(mass * speed * speed + c.w[ball].mass() * speed * speed * 2 / 7)
              .epsilon(1e-6));
    const vec3 weight = contact_force(c.w, floor);
    CHECK(weight[2] == doctest::Approx(-10 * (mass + c.w[ball].mass())).epsilon(1e-9));
    c.w.halt(floor);
    c.run(1, 0.005);
    CHECK(c.w[crate].velocity().norm() < 1e-9);
  }
}

TEST_CASE("restitution is relative to the wall") {
  course c;
  const auto rubber = c.w.material({.density = 1, .restitution = 0.5});
  c.w.material_pair(c.rough, rubber, {.restitution = 0.5});
  const auto wall = c.global(plane{.normal = {1, 0, 0}, .offset = -2});
  const auto bat = c.global(box{{4, 1, 4}}, {4, 0, 0});
  c.w.drive(wall, gliding{{2, 0, 0}});
  c.w.drive(bat, turning{.axis = {0, 0, 1}, .speed = 0.5});
  const auto struck = c.w.add(sphere{0.5}, rubber, {0, 50, 0});
  const auto coming = c.w.add(body{
      .shape = sphere{0.5}, .position = {0, -5, 0}, .material = rubber, .velocity = {-1, 0, 0}});
  const auto batted = c.w.add(sphere{0.5}, rubber, {4, 1.25, 0});
  c.run(2, 0.01);
  CHECK(c.w[struck].velocity()[0] == doctest::Approx(2 + 0.5 * 2).epsilon(1e-9));
  CHECK(c.w[coming].velocity()[0] == doctest::Approx(2 + 0.5 * 3).epsilon(1e-9));
  // The face moves at 0.5 * 4 along its normal, slightly rotated by then.
  CHECK(c.w[batted].velocity().norm() == doctest::Approx(1.5 * 0.5 * 4).epsilon(0.03));
  CHECK(c.w[batted].velocity()[1] > 2.8);
}

TEST_CASE("bodies rest on a shaken floor, and stick to a turntable") {
  course c;
  c.w.gravity({0, 0, -10});
  const oscillation shake{.amplitude = {0.3, 0, 0.1}, .frequency = 1};
  const auto floor = c.global(plane{});
  c.w.drive(floor, shake);
  const auto ball = c.w.add(sphere{0.5}, c.rough, {0, 0, 0.5});
  const auto crate = c.w.add(box{{1, 1, 0.4}}, c.rough, {3, 0, 0.2});
  real worst = 0;
  for (int k = 0; k < 400; ++k) {
    c.w.step(0.005);
    worst = std::max(worst, std::abs(c.w[ball].position()[2] - 0.5 - shake(c.w.time()).shift[2]));
    worst = std::max(worst, std::abs(c.w[crate].position()[2] - 0.2 - shake(c.w.time()).shift[2]));
  }
  CHECK(worst < 1e-5);

  course d;
  d.w.gravity({0, 0, -10});
  d.w.drive(d.global(plane{}), turning{.about = {1, 1, 0}, .speed = 1});
  const auto riding = [&](const auto& shape, const vec3& at) {
    return d.w.add(body{.shape = shape,
                        .position = at,
                        .material = d.rough,
                        .velocity = {1 - at[1], at[0] - 1, 0},
                        .angular_velocity = {0, 0, 1}});
  };
  const auto crate_there = riding(box{{1, 1, 0.4}}, {3, 1, 0.2});
  const auto ball_there = riding(sphere{0.5}, {1, -2, 0.5});
  d.run(2 * pi, 2 * pi / 100);
  CHECK((d.w[crate_there].position() - vec3(3, 1, 0.2)).norm() < 1e-3);
  CHECK(std::abs(d.w[crate_there].orientation().w()) > 1 - 1e-6);
  CHECK(d.w[ball_there].position()[2] == doctest::Approx(0.5));
}

TEST_CASE("what comes fast, from where nothing was in reach, is met") {
  course c;
  const auto wall = c.global(plane{.normal = {0, 1, 0}, .offset = -30});
  const auto ram = c.global(box{{2, 2, 2}}, {0, 0, -30});
  std::vector<handle<sphere>> row;
  for (int k = 0; k < 5; ++k) row.push_back(c.w.add(sphere{0.2}, c.rough, {real(k), 5, 0}));
  const auto target = c.w.add(sphere{0.2}, c.rough, {0, 0, 0});
  c.run(0.2, 0.01);  // the neighbour list is kept by now
  const auto later = [](const vec3& v) {
    return [v](real t) { return rigid_displacement{.shift = std::max(t - 1, real(0)) * v}; };
  };
  c.w.drive(wall, later({0, 30, 0}));
  c.w.drive(ram, later({0, 0, 30}));
  c.run(2.3, 0.01);
  for (const auto h : row) {
    CHECK(c.w[h].velocity()[1] == doctest::Approx(30));
    CHECK(c.w[wall].shape().distance(c.w[h].position()) == doctest::Approx(0.2).epsilon(1e-6));
  }
  CHECK(c.w[target].velocity()[2] == doctest::Approx(30));
}

TEST_CASE("what is held at a force exerts it, no more and no less") {
  course c;
  c.w.gravity({0, 0, -10});
  const auto floor = c.global(plane{});
  const auto lid = c.global(plane{.normal = {0, 0, -1}, .offset = -1.2});
  const auto press = c.global(box{{2, 2, 0.5}}, {9, 0, 0.85});
  c.w.hold_force(lid, {.force = 7, .max_speed = 0.2});
  c.w.hold_force(press, {.force = 30, .max_speed = 0.2, .axis = {0, 0, -2}});
  const auto ball = c.w.add(sphere{0.5}, c.rough, {0, 0, 0.5});
  const auto crate = c.w.add(box{{1, 1, 0.4}}, c.rough, {9, 0, 0.2});
  c.run(3, 0.005);
  const vec3 up = contact_force(c.w, lid), aside = contact_force(c.w, press);
  CHECK(up[2] == doctest::Approx(7).epsilon(1e-6));
  CHECK(aside[2] == doctest::Approx(30).epsilon(1e-6));
  CHECK(contact_force(c.w, floor)[2] ==
        doctest::Approx(-37 - 10 * (c.w[ball].mass() + c.w[crate].mass())).epsilon(1e-6));
  CHECK(c.w[lid].shape().offset == doctest::Approx(-1).epsilon(1e-4));
  CHECK(c.w[press].position()[2] == doctest::Approx(0.65).epsilon(1e-4));
}

TEST_CASE("what cannot be driven is refused") {
  course c;
  const auto loose = c.w.add(sphere{1}, c.rough, {0, 0, 5});
  CHECK_THROWS_AS(c.w.drive(loose, belt{}), std::invalid_argument);
  CHECK_THROWS_AS(c.w.halt(handle<plane>{}), std::invalid_argument);
  const auto floor = c.global(plane{});
  const auto block = c.global(box{{1, 1, 1}});
  CHECK_THROWS_AS(c.w.hold_force(floor, {.force = 0, .max_speed = 1}), std::invalid_argument);
  CHECK_THROWS_AS(c.w.hold_force(block, {.force = 1, .max_speed = 1}), std::invalid_argument);
  if (auto only = c.w.exclusive(0)) CHECK_THROWS_AS(c.w.drive(floor, belt{}), std::runtime_error);
  c.w.drive(floor, [](real t) {
    return rigid_displacement{
        .shift = {0, 0, t > 0.1 ? std::numeric_limits<real>::quiet_NaN() : 0}};
  });
  CHECK_THROWS_WITH_AS(c.run(1, 0.02), doctest::Contains("makes no sense at time"),
                       std::runtime_error);
  c.w.destroy(floor);
  c.w.step(0.01);
}

TEST_CASE("a motion that spins faster than steps can show is refused") {
  course c;
  const auto blade = c.global(box{{3, 1, 1}}, {0, 0, 9});
  c.w.drive(blade, turning{.axis = {0, 0, 1}, .speed = 300});
  c.run(0.1, 0.01);  // less than half a turn in a step
  for (const real dt : {0.011, 0.02, 0.03, 0.04, 0.05, 0.084, 0.1, 1.})
    CHECK_THROWS_WITH_AS(c.w.step(dt), doctest::Contains("turns by half a turn or more"),
                         std::runtime_error);
  c.w.drive(blade, [](real) { return rigid_velocity{.angular_velocity = {0, 0, 400}}; });
  CHECK_THROWS_WITH_AS(c.w.step(0.01), doctest::Contains("turns by half a turn or more"),
                       std::runtime_error);
}

TEST_CASE("a motion may depend on what was measured on the way") {
  course c;
  const auto lid = c.global(plane{.normal = {0, 0, -1}, .offset = -2});
  real height = 0;
  c.w.drive(lid, [&](real) { return rigid_displacement{.shift = {0, 0, height}}; });
  for (int k = 1; k <= 5; ++k) {
    height = -0.01 * k;
    c.w.step(0.01);
    CHECK(c.w[lid].position()[2] == height);
  }
}

TEST_CASE("a motion of a checkpoint that is another one is told from roundings of the time") {
  const oscillation shake{.amplitude = {0, 0, 0.3}, .frequency = 2};
  const turning spin{.axis = {0, 0, 1}, .speed = 40};
  const real dt = 0.005, lag = 1e-9;
  for (int k = 0; k < 400; ++k) {
    const real t = k * dt;
    const auto goes_on = [&](const auto& motion, real late) {
      detail::driven_state s;
      s.at = detail::place_of(s.origin, motion(t - late));
      return detail::step_to(s, motion(t), motion(t + detail::instant * dt), motion(t + dt), dt)
          .goes_on;
    };
    CHECK(goes_on(shake, lag));
    CHECK(goes_on(spin, lag));
    CHECK(!goes_on(spin, 0.03));
  }
}

TEST_CASE("a driven body that jumps within a run is named, with the time and the way in radii") {
  const auto said_after = [](const auto& motion) {
    course c;
    c.w.gravity({0, 0, -10});
    c.w.add(body{.shape = sphere{0.5}, .position = {3, 0, 0.5}, .material = c.rough});
    const auto wall = c.global(plane{.normal = {1, 0, 0}, .offset = -20});
    const auto belt_of = c.global(plane{.normal = {0, 0, 1}, .offset = 0});
    c.w.drive(wall, motion);
    c.w.drive(belt_of, belt{{900, 0, 0}});
    c.run(0.1, 0.01);
    return to_text(summarize(c.w, 0, 0));
  };
  const std::string jumps = said_after([](real t) {
    return rigid_displacement{.shift = {t < 0.05 ? 0.1 * t : real(6), 0, 0}};
  });
  CAPTURE(jumps);
  CHECK(jumps.find("in step 5, from time 0.04 on, driven plane ") != std::string::npos);
  CHECK(jumps.find(" went 6, 12 times the mean radius 0.5: ") != std::string::npos);
  const std::string steady = said_after(gliding{{0.1, 0, 0}});
  CAPTURE(steady);
  CHECK(steady.find("driven plane") == std::string::npos);
}

TEST_CASE("a step in which contacts make a body far faster than anything was is noted, and said") {
  course c;
  c.w.gravity({0, 0, -10});
  const auto lid = c.global(plane{.normal = {0, 0, -1}, .offset = -9});
  c.w.drive(lid, gliding{{0, 0, -2}});
  c.w.add(body{.shape = sphere{1}, .position = {0, 0, 3}, .material = c.rough});
  c.run(0.1, 0.01);
  CHECK(talus::detail::state_of(c.w).driving.leap.step == 0);
  auto& s = talus::detail::state_of(c.w);
  s.solver.bodies[0].v = {0, 0, 19};  // the lid moves at 2, the sphere at 1.1
  detail::monitor_leaps(s);
  CHECK(s.driving.leap.step == 0);
  s.solver.bodies[0].v = {0, 0, 40};
  detail::monitor_leaps(s);
  const detail::speed_leap leap = s.driving.leap;
  CHECK(leap.step == 11);
  CHECK(leap.after == 40);
  CHECK(leap.before == doctest::Approx(2));
  const std::string said = detail::warnings_of_scales({.bodies = 1,
                                                       .movable = 1,
                                                       .steps = 11,
                                                       .dt = 0.01,
                                                       .gravity = 10,
                                                       .radius = 1,
                                                       .leap = leap});
  CHECK(said.find("in step 11 contacts made a body as fast as 40") != said.npos);
}
