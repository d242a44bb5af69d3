// Faults that were reported of other engines, with spheres and boxes:
// docs/validation/faults_elsewhere.md.
// timeout: 300
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/observe/force.hpp>
#include <vector>

#include "../scenes/alone.hpp"
#include "elsewhere.hpp"

using namespace talus;
using namespace talus::validation;

namespace {

using scene = elsewhere<scenes::alone>;

/// A box that lies flat on a floor of this slope.
handle<box> flat(scene& s, const vec3& size, real slope = 0, real height = 0) {
  const vec3 n(std::sin(slope), 0, std::cos(slope));
  return s.add(box{size}, (height + 0.5 * size[2]) * n, {0, 0, 0}, rotation(vec3::UnitY(), slope));
}
real yaw(const quat& q) { return 2 * std::atan2(q.z(), q.w()); }

}  // namespace

// Impacts.

TEST_CASE("a ball of restitution 1 never rises above the height from which it falls") {
  scene s({.restitution = 1});
  const auto h = s.floor().add(sphere{0.5}, {0, 0, 1.5});
  const real top = s.most(0.3, [&] { return s.w[h].position()[2]; });
  CHECK(top <= 1.5);
  const real later = s.most(18, [&] { return s.w[h].position()[2]; });
  check_absolute("JoltPhysics #1286", "highest apex of 20, m", 1.5, later, 1e-6);
  CHECK(later <= 1.5 * (1 + 1e-9));
}

TEST_CASE("the rebound of a box depends neither on its size nor on its shape") {
  real least = 1e300, most = 0;
  for (const vec3& size : {vec3(0.3, 0.3, 1.2), vec3(1.2, 1.2, 1.2), vec3(3, 0.5, 0.2)}) {
    scene s({.restitution = 1}, 0);
    const auto h = s.floor().add(box{size}, {0, 0, 0.5 * size[2] + 0.1}, {0, 0, -2});
    s.run(0.5);
    least = std::min(least, s.w[h].velocity()[2]), most = std::max(most, s.w[h].velocity()[2]);
  }
  check_absolute("matter-js #13", "least rebound speed, m/s", 2, least, 1e-9);
  check_absolute("matter-js #13", "largest rebound speed, m/s", 2, most, 1e-9);
}

TEST_CASE("a box of restitution 1 that falls on a smaller one does not overshoot its start") {
  scene s({.restitution = 1});
  s.wall(box{{0.75, 0.75, 0.75}}, {0, 0, -0.375});
  const auto h = s.add(box{{1, 1, 1}}, {0, 0, 1.5});
  s.run(0.5);
  check_absolute("box3d #83", "apex after the rebound, m", 1.5,
                 s.most(0.6, [&] { return s.w[h].position()[2]; }), 1e-6);
}

TEST_CASE("a box of restitution 0 that falls on another one does not bounce") {
  scene s({.restitution = 0, .friction = 0.5});
  (void)flat(s.floor(), {0.1, 0.1, 0.1});
  const auto h = s.add(box{{0.1, 0.1, 0.1}}, {0, 0, 0.15 + 0.09});
  check_absolute("newton #1137", "largest speed upward, m/s", 0,
                 s.most(1, [&] { return s.w[h].velocity()[2]; }), 1e-5);
  check_absolute("newton #1137", "height at the end, m", 0.15, s.w[h].position()[2], 1e-6);
}

TEST_CASE(
    "two bodies rebound from each other with the given coefficient, and keep their momentum") {
  scene s({.restitution = 0.5}, 0);
  const auto a = s.add(sphere{0.5}, {-0.6, 0, 0}, {1, 0, 0});
  const auto b = s.add(sphere{1}, {1, 0, 0});  // eight times the mass
  s.run(0.5);
  check_absolute("newton #1289", "velocity of the light one, m/s", 1.0 / 9 - 4.0 / 9,
                 s.w[a].velocity()[0], 1e-9);
  check_absolute("newton #1289", "velocity of the heavy one, m/s", 1.5 / 9, s.w[b].velocity()[0],
                 1e-9);
}

TEST_CASE("the last ball of Newton's cradle takes all of the velocity") {
  scene s({.restitution = 1}, 0);
  std::vector<handle<sphere>> row;
  for (int k = 0; k < 5; ++k)
    row.push_back(s.add(sphere{0.5}, {1.02 * k, 0, 0}, {k == 0 ? 1. : 0., 0, 0}));
  s.run(1);
  check_absolute("edyn #49", "velocity of the last ball, m/s", 1, s.w[row[4]].velocity()[0], 1e-9);
  real others = 0;
  for (int k = 0; k < 4; ++k) others = std::max(others, s.w[row[k]].velocity().norm());
  check_absolute("edyn #49", "largest speed of the others, m/s", 0, others, 1e-9);
}

TEST_CASE("slow balls of restitution 1 exchange their velocities, too") {
  scene s({.restitution = 1}, 0);
  const auto a = s.add(sphere{0.5}, {-0.501, 0, 0}, {1e-4, 0, 0}),
             b = s.add(sphere{0.5}, {0.5, 0, 0});
  s.run(20);
  check_absolute("matter-js #361", "velocity of the struck ball, m/s", 1e-4, s.w[b].velocity()[0],
                 1e-12);
  check_absolute("matter-js #361", "velocity of the striking ball, m/s", 0, s.w[a].velocity()[0],
                 1e-12);
}

TEST_CASE("of balls with several coefficients none rises above e^2 of its height") {
  real worst = 0;
  for (const real e : {0., 0.1, 0.3, 0.5, 0.75, 0.9, 1.}) {
    scene s({.restitution = e}, earth, 1e-3);
    const auto h = s.floor().add(sphere{0.5}, {0, 0, 1.5});
    s.run(std::sqrt(2 / earth) + 0.002);
    const real apex = s.most(1, [&] { return s.w[h].position()[2]; }) - 0.5;
    worst = std::max(worst, std::abs(apex - e * e));
  }
  check_absolute("box2d #76", "largest deviation of an apex from e^2 h, m", 0, worst, 1e-5);
}

TEST_CASE("friction in an oblique impact needs no gravity") {
  scene s({.restitution = 0.5, .friction = 0.3}, 0);
  const auto h = s.floor().add(sphere{0.5}, {0, 0, 0.6}, {5, 0, -1});
  s.run(0.5);
  check_absolute("p2.js #71", "tangential velocity, m/s", 5 - 0.3 * 1.5, s.w[h].velocity()[0],
                 1e-9);
  check_absolute("p2.js #71", "spin, rad/s", 2.5 * 0.3 * 1.5 / 0.5, s.w[h].angular_velocity()[1],
                 1e-9);
}

// Free motion.

TEST_CASE("a body that spins about its intermediate axis flips") {
  scene s({}, 0);
  const auto h = s.add(box{{1, 2, 0.3}}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0, 0}, {5, 5e-3, 0});
  int flips = 0;
  real last = 5;
  s.run(0);
  for (int k = 0; k < 4 * 9.298477344 * 240; ++k) {
    s.w.step(s.dt);
    const real x = (s.w[h].orientation().conjugate() * s.w[h].angular_velocity())[0];
    flips += (x > 0) != (last > 0);
    last = x;
  }
  check_absolute("JoltPhysics #803", "flips in four periods", 8, flips, 0);
}

TEST_CASE("a body that spins about a stable axis keeps that axis and its energy") {
  scene s({}, 0);
  const auto h = s.add(box{{1, 2, 0.3}}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0, 0}, {0.3, 0, 5});
  const real before = s.energy();
  const real tilt = s.most(100, [&] {
    const vec3 w = s.w[h].orientation().conjugate() * s.w[h].angular_velocity();
    return std::atan2(std::hypot(w[0], w[1]), w[2]);
  });
  const vec3 i = box{{1, 2, 0.3}}.inertia();  // the closed form: the largest ratio of w_y to w_z
  const real y = 0.3 * std::sqrt(i[0] * (i[2] - i[0]) / (i[1] * (i[2] - i[1])));
  check_absolute("avian #993", "largest tilt of the spin in 100 s, rad",
                 std::atan2(std::max(y, 0.3), 5), tilt, 1e-8);
  check_absolute("avian #993", "energy over that at the start", 1, s.energy() / before, 1e-9);
}

TEST_CASE("the spin of a free symmetric body precesses about its axis at (I3 - I1) / I1 w3") {
  scene s({}, 0);
  const vec3 size(1, 1, 0.25), i = box{size}.inertia();
  const auto h = s.add(box{size}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0, 0}, {1, 0, 3});
  s.run(1);
  const vec3 w = s.w[h].orientation().conjugate() * s.w[h].angular_velocity();
  check_absolute("brax #48", "angle of precession after 1 s, rad", (i[2] - i[0]) / i[0] * 3,
                 std::atan2(w[1], w[0]), 1e-9);
}

TEST_CASE("the angular momentum of a free body is constant as a vector") {
  scene s({}, 0);
  const vec3 size(1, 2, 0.3), i = box{size}.inertia();
  const auto h = s.add(box{size}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0, 0}, {5, 1, 2});
  const auto momentum = [&] {
    const quat q = s.w[h].orientation();
    return vec3(q * vec3(i.cwiseProduct(q.conjugate() * s.w[h].angular_velocity())));
  };
  const vec3 before = momentum();
  s.run(60);
  check_absolute("reactphysics3d #422", "change in 60 s over its size", 0,
                 (momentum() - before).norm() / before.norm(), 1e-9);
}

TEST_CASE("a spinning body flies along the parabola of its centre") {
  scene s({});
  const auto h = s.add(box{{1, 2, 0.3}}, {0, 0, 0}, {1, 2, 9}, {1, 0, 0, 0}, {5, 1, 2});
  s.run(2);
  // By the default integrator, of first order: it is g t dt / 2 below.
  const vec3 end(2, 4, 18 - 2 * earth - earth * s.dt);
  check_absolute("dart #424", "distance from the parabola of the step after 2 s, m", 0,
                 (s.w[h].position() - end).norm(), 1e-11);
}

TEST_CASE("a tumbling free body keeps its energy") {
  scene s({}, 0, 1e-2);
  (void)s.add(box{{1, 2, 0.3}}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0, 0}, {5, 1, 2});
  const real before = s.energy();
  s.run(60);
  check_absolute("genesis-world #3074", "energy after 60 s over that at the start", 1,
                 s.energy() / before, 1e-9);
}

// Friction.

TEST_CASE("a box on a slope below its friction angle stays where it is") {
  scene s({.friction = 1});
  const auto h = flat(s.floor(20 * degree), {1, 1, 1}, 20 * degree);
  const vec3 at = s.w[h].position();
  s.run(10);
  check_absolute("matter-js #752", "way in 10 s, m", 0, (s.w[h].position() - at).norm(), 1e-4);
}

TEST_CASE("a stack on a slope of one degree does not creep") {
  scene s({.friction = 0.7});
  s.floor(degree);
  std::vector<handle<box>> all;
  std::vector<vec3> at;
  for (int k = 0; k < 3; ++k) {
    all.push_back(flat(s, {0.5, 0.5, 0.5}, degree, 0.5 * k));
    at.push_back(s.w[all.back()].position());
  }
  s.run(60);
  real way = 0;
  for (std::size_t k = 0; k < 3; ++k) way = std::max(way, (s.w[all[k]].position() - at[k]).norm());
  check_absolute("matter-js #612", "largest way in 60 s, m", 0, way, 1e-4);
}

TEST_CASE("a ball rolls down a slope with 5/7 g sin") {
  scene s({.friction = 0.5});
  const real slope = 20 * degree;
  const auto h = s.floor(slope).add(sphere{0.5}, 0.5 * vec3(std::sin(slope), 0, std::cos(slope)));
  s.run(2);
  check_absolute("matter-js #1158", "acceleration, m/s^2", 5.0 / 7 * earth * std::sin(slope),
                 down(s.w[h].velocity(), slope) / 2, 1e-6);
}

TEST_CASE("balls roll down a slope alike in all directions") {
  const real slope = 20 * degree;
  real least = 1e300, most = 0;
  for (const real angle : {0., 30., 45., 60., 90.}) {
    const vec3 to(std::cos(angle * degree), std::sin(angle * degree), 0);
    scene s({.friction = 0.5});
    const auto h = s.floor(slope, to).add(
        sphere{0.5}, 0.5 * vec3(std::sin(slope) * to + vec3(0, 0, std::cos(slope))));
    s.run(2);
    const real v = s.w[h].velocity().dot(std::cos(slope) * to - vec3(0, 0, std::sin(slope)));
    least = std::min(least, v / 2), most = std::max(most, v / 2);
  }
  check_absolute("gazebo-classic #480", "least acceleration, m/s^2",
                 5.0 / 7 * earth * std::sin(slope), least, 1e-6);
  check_absolute("gazebo-classic #480", "largest acceleration, m/s^2",
                 5.0 / 7 * earth * std::sin(slope), most, 1e-6);
}

TEST_CASE("a ball that rolls on a level floor keeps its speed") {
  scene s({.friction = 0.5});
  const auto h = s.floor().add(sphere{0.5}, {0, 0, 0.5}, {2, 0, 0}, {1, 0, 0, 0}, {0, 4, 0});
  s.run(10);
  check_absolute("box2d #617", "speed after 10 s, m/s", 2, s.w[h].velocity()[0], 1e-9);
}

TEST_CASE("a rolling ball does not bounce") {
  scene s({.restitution = 0.8, .friction = 0.5});
  const auto h = s.floor().add(sphere{0.5}, {0, 0, 0.5}, {20, 0, 0}, {1, 0, 0, 0}, {0, 40, 0});
  check_absolute("GoblinPhysics #74", "largest height above the floor in 10 s, m", 0,
                 s.most(10, [&] { return std::abs(s.w[h].position()[2] - 0.5); }), 1e-9);
}

TEST_CASE("a box that is launched flat slides flat, and as far as friction lets it") {
  scene s({.friction = 0.5}, earth, 0.005);
  const auto h = s.floor().add(box{{0.1, 0.1, 0.1}}, {0, 0, 0.05}, {6, 0, 0});
  const real rise = s.most(1.6, [&] { return s.w[h].position()[2] - 0.05; });
  check_absolute("genesis-world #3115", "largest rise of the centre, m", 0, rise, 1e-5);
  check_absolute("genesis-world #3115", "way until it stops, m", 36 / earth, s.w[h].position()[0],
                 0.02);
}

TEST_CASE("a long body that is pushed along its side does not drift across") {
  const real angle = 20 * degree;
  const vec3 along(std::cos(angle), std::sin(angle), 0);
  scene s({.friction = 1.5});
  const auto h =
      s.floor().add(box{{2, 0.5, 0.1}}, {0, 0, 0.05}, 5 * along, rotation(vec3::UnitZ(), angle));
  s.run(0.2);
  const vec3 x = s.w[h].position() - vec3(0, 0, 0.05);
  check_absolute("rapier #137", "drift across its way, m", 0, vec3(x - along.dot(x) * along).norm(),
                 1e-6);
}

TEST_CASE("friction does not depend on the orientation of a box") {
  real least = 1e300, most = 0;
  for (const real angle : {0., 15., 30., 45.}) {
    scene s({.friction = 0.4});
    const auto h = s.floor().add(box{{1, 1, 0.2}}, {0, 0, 0.1}, {5, 0, 0},
                                 rotation(vec3::UnitZ(), angle * degree));
    s.run(0.2);
    const real before = s.w[h].velocity()[0];
    s.run(0.5);
    const real a = (before - s.w[h].velocity()[0]) / 0.5;
    least = std::min(least, a), most = std::max(most, a);
  }
  check_absolute("bullet3 #4539", "least deceleration, m/s^2", 0.4 * earth, least, 1e-4);
  check_absolute("bullet3 #4539", "largest deceleration, m/s^2", 0.4 * earth, most, 1e-4);
}

TEST_CASE("the contact forces on a resting box are minus its weight") {
  scene s({.density = 1, .friction = 0.6});
  const auto h = flat(s.floor(20 * degree), {1, 1, 1}, 20 * degree);
  s.run(2);
  check_absolute("bullet3 #3975", "error of the force over the weight", 0,
                 (contact_force(s.w, h) - vec3(0, 0, earth)).norm() / earth, 1e-6);
}

// Bodies at rest.

TEST_CASE("a heavy box stands on a light one") {
  for (const real ratio : {100., 1000.}) {
    scene s({.density = 1, .friction = 0.5});
    const auto heavy = s.w.material({.density = ratio, .friction = 0.5});
    (void)flat(s.floor(), {1, 1, 1});
    const auto h =
        s.w.add(body{.shape = box{{1, 1, 1}}, .position = {0, 0, 1.5}, .material = heavy});
    s.run(2);
    check_absolute("dart #3442", "height of the heavy box after 2 s, m", 1.5, s.w[h].position()[2],
                   1e-4);
  }
}

TEST_CASE("tightly packed cubes at rest do not jiggle") {
  scene s({.friction = 0.5});
  s.floor();
  std::vector<handle<box>> all;
  std::vector<vec3> at;
  for (int k = 0; k < 27; ++k) {
    at.push_back({real(k % 3), real(k / 3 % 3), 0.5 + k / 9});
    all.push_back(s.add(box{{1, 1, 1}}, at.back()));
  }
  s.run(5);
  real way = 0;
  for (std::size_t k = 0; k < 27; ++k) way = std::max(way, (s.w[all[k]].position() - at[k]).norm());
  check_absolute("jitterphysics #10", "largest way in 5 s, m", 0, way, 1e-4);
}

TEST_CASE("a cube on the ground does not rattle") {
  scene s({.density = 1000, .friction = 0.5}, earth, 1e-2);
  const auto h = flat(s.floor(), {0.1, 0.1, 0.1});
  const real fastest =
      s.most(2, [&] { return s.w[h].velocity().norm() + 0.1 * s.w[h].angular_velocity().norm(); });
  check_absolute("drake #22213", "largest speed in 2 s, m/s", 0, fastest, 1e-4);
}

TEST_CASE("a box that has landed flat does not turn slowly in place") {
  scene s({.friction = 0.5});
  const auto h = flat(s.floor(), {0.1, 0.06, 0.2}, 0, 0.001);
  s.run(10);
  check_absolute("drake #5441", "yaw after 10 s, rad", 0, yaw(s.w[h].orientation()), 1e-7);
}

TEST_CASE("balls at the same place get a contact, and part") {
  scene s({}, 0);
  const auto a = s.add(sphere{0.5}, {0, 0, 0}), b = s.add(sphere{0.5}, {0, 0, 0});
  s.run(10);
  check_absolute("reactphysics3d #32", "distance of the centres after 10 s, m", 1,
                 (s.w[a].position() - s.w[b].position()).norm(), 1e-6);
  check_absolute("reactphysics3d #32", "distance of their mean from the start, m", 0,
                 (s.w[a].position() + s.w[b].position()).norm() / 2, 1e-12);
}

TEST_CASE("two runs of the same scene have the same bits") {
  std::array<std::string, 2> digests;
  for (std::string& digest : digests) {
    scene s({.restitution = 0.7, .friction = 0.5});
    s.floor();
    for (int k = 0; k < 8; ++k)
      (void)s.add(sphere{0.5}, {k % 2 + 0.01 * k, real(k / 2 % 2), 10. + k / 4});
    s.run(5);
    digest = state_digest(s.w);
  }
  check_absolute("rapier #868", "runs whose digest differs", 0, digests[0] != digests[1], 0);
}
