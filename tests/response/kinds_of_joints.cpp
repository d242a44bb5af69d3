// The laws of all kinds of joints.
#include "joint_laws.hpp"

#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/cylindrical_joint.hpp>
#include <talus/constraint/fixed_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/point_on_plane.hpp>
#include <talus/constraint/rod.hpp>
#include <talus/constraint/slider.hpp>
#include <talus/constraint/strut.hpp>
#include <talus/constraint/universal_joint.hpp>
#include <talus/constraint/weld.hpp>

using namespace talus;
using laws::any_vector;

TEST_CASE("ball_joint obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<ball_joint>(
      [](random_stream& random) { return ball_joint{.at = any_vector(random, 2)}; });
}
TEST_CASE("fixed_joint obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<fixed_joint>(
      [](random_stream& random) { return fixed_joint{.at = any_vector(random, 2)}; });
}
TEST_CASE("weld obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<weld>(
      [](random_stream& random) { return weld{.at = any_vector(random, 2)}; });
}
TEST_CASE("hinge obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<hinge>([](random_stream& random) {
    return hinge{.at = any_vector(random, 2), .axis = any_vector(random, 1)};
  });
}
TEST_CASE("slider obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<slider>([](random_stream& random) {
    return slider{.at = any_vector(random, 2), .axis = any_vector(random, 1)};
  });
}
TEST_CASE("cylindrical_joint obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<cylindrical_joint>([](random_stream& random) {
    return cylindrical_joint{.at = any_vector(random, 2), .axis = any_vector(random, 1)};
  });
}
TEST_CASE("universal_joint obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<universal_joint>([](random_stream& random) {
    const vec3 axis = any_vector(random, 1);
    return universal_joint{.at = any_vector(random, 2),
                           .first_axis = axis,
                           .second_axis = axis.cross(any_vector(random, 1))};
  });
}
TEST_CASE("rod obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<rod>([](random_stream& random) {
    return rod{.from = any_vector(random, 2), .to = any_vector(random, 2)};
  });
}
TEST_CASE("strut obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<strut>([](random_stream& random) {
    return strut{.from = any_vector(random, 2), .to = any_vector(random, 2), .limits = {0, 0}};
  });
}
TEST_CASE("point_on_plane obeys the laws of joints") {
  laws::obeys_the_laws_of_joints<point_on_plane>([](random_stream& random) {
    return point_on_plane{.at = any_vector(random, 2), .normal = any_vector(random, 1)};
  });
}

TEST_CASE(
    "a row with bounds keeps them exactly for any target, and the other rows of its joint hold") {
  laws::for_random<hinge>([](laws::jointed_pair p, int a, int b, random_stream& random) {
    const hinge kind{
        .at = any_vector(random, 2),
        .axis = any_vector(random, 1),
        .motor = {.velocity = random.uniform(0, 1) < 0.5 ? 1e308 : -1e30, .largest_torque = 3},
        .friction = 1};
    auto c = laws::row_of(kind, p, a, b);
    c.apply(p.s, c.relax(p.s));
    const auto r = c.impulse_in_frame();
    CHECK(std::abs(r[c.rows - 2]) == 3 * 1e-2);
    CHECK(std::abs(r[c.rows - 1]) <= 1e-2);
    const auto u = c.relative_velocity(p.s);
    for (int k = 0; k < 5; ++k) CHECK(std::abs(u[k]) < 1e-12);
  });
}
