// Joints of all kinds in a world: closed forms of statics and of motion, and what is refused.
// timeout: 300
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "machines.hpp"

using namespace machines;

TEST_CASE("a joint to the world bears the weight and its moment") {
  // The joint is left of the brick by 0.5: its force on the world is the weight, downward.
  const auto bears = [](const auto& kind, bool torque) {
    in_world([&](auto& w, material_id stuff) {
      const auto h = add_brick(w, stuff, {0.5, 0, 0});
      const auto joint = w.join(world_frame, h, kind);
      for (int k = 0; k < 50; ++k) w.step(1e-3);
      CHECK((joint.force() - vec3(0, 0, -mass * g)).norm() < 1e-10 * mass * g);
      const vec3 moment = torque ? vec3(0, 0.5 * mass * g, 0) : vec3(0, 0, 0);
      CHECK((joint.torque() - moment).norm() < 1e-10 * mass * g);
      CHECK((w[h].position() - vec3(0.5, 0, 0)).norm() < 1e-12);
    });
  };
  bears(fixed_joint{}, true);
  bears(hinge{.axis = {0, 0, 1}}, true);
  bears(hinge{.axis = {1, 0, 0}}, true);
  bears(slider{.axis = {1, 0, 0}}, true);
  bears(cylindrical_joint{.axis = {1, 0, 0}}, true);
  bears(universal_joint{.first_axis = {0, 0, 1}, .second_axis = {1, 0, 0}}, true);
  bears(ball_joint{.at = {0.5, 0, 0.3}}, false);
  bears(rod{.from = {0.5, 0, 1}, .to = {0.5, 0, 0.1}}, false);
  bears(rope{.from = {0.5, 0, 1}, .to = {0.5, 0, 0.1}}, false);
  bears(point_on_plane{.at = {0.5, 0, 0.2}, .normal = {0, 0, 3}}, false);
  bears(strut{.from = {0.5, 0, 1}, .to = {0.5, 0, 0.1}, .limits = {0, 0}}, false);
}

TEST_CASE(
    "a tumbling pair keeps its joint to round-off, its momentum and, by midpoints, its energy") {
  const auto tumbles = [](const auto& kind) {
    in_world<second_order>([&](auto& w, material_id stuff) {
      w.gravity({0, 0, 0});
      const auto a = add_brick(w, stuff, {-0.4, 0, 0}), b = add_brick(w, stuff, {0.4, 0.1, 0.3});
      (void)w.join(a, b, kind);
      w[a].set_velocity({0.1, 0.2, 0.1}), w[a].set_angular_velocity({1, 0.5, -0.7});
      w.step(1e-3);  // makes the velocities fit
      const real energy = energy_of(w);
      const motion before = measure_motion(w);
      for (int k = 0; k < 1000; ++k) w.step(1e-3);
      const motion after = measure_motion(w);
      CHECK((after.momentum - before.momentum).norm() < 1e-14);
      CHECK((after.angular_momentum - before.angular_momentum).norm() < 1e-11);
      CHECK(std::abs(energy_of(w) - energy) < 1e-8 * energy);
      CHECK(measure_energy(w).worst < 1e-10);
      CHECK(measure_energy(w).total.work == 0);
      const joint_errors errors = measure_joints(w);
      CHECK(errors.joints == 1);
      CHECK(errors.gap < 1e-12);
      CHECK(errors.angle < 1e-12);
    });
  };
  tumbles(fixed_joint{});
  tumbles(hinge{.axis = {1, 2, 3}});
  tumbles(slider{.axis = {1, 2, 3}});
  tumbles(cylindrical_joint{.axis = {1, 2, 3}});
  tumbles(universal_joint{.first_axis = {0, 0, 1}, .second_axis = {1, 0, 0}});
  tumbles(ball_joint{});
  tumbles(rod{.from = {-0.2, 0, 0}, .to = {0.3, 0.1, 0.3}});
  tumbles(point_on_plane{});
}

TEST_CASE("a machine moves the same after a rigid motion of its scene") {
  const auto place_of_b = [](const pose& at, const auto& kind_at) {
    vec3 place;
    in_world([&](auto& w, material_id stuff) {
      w.gravity(rotated(at.orientation, {0, 0, -g}));
      const auto add = [&](const vec3& where) {
        return *w.add_if_local(body{.shape = brick,
                                    .position = at.to_world(where),
                                    .material = stuff,
                                    .orientation = at.orientation});
      };
      const auto a = add({-0.4, 0, 0}), b = add({0.4, 0.1, 0.3});
      (void)w.join(world_frame, a, ball_joint{.at = at.to_world({-0.7, 0.1, 0})});
      (void)w.join(a, b, kind_at(at));
      for (int k = 0; k < 300; ++k) w.step(1e-3);
      place = at.to_body(w[b].position());
    });
    return place;
  };
  const pose moved{{3, -2, 5}, quat(0.5, -0.1, 0.7, 0.3).normalized()};
  const auto same = [&](const auto& kind_at) {
    const vec3 here = place_of_b({}, kind_at), there = place_of_b(moved, kind_at);
    CHECK((here - vec3(0.4, 0.1, 0.3)).norm() > 0.05);
    CHECK((here - there).norm() < 1e-11);
  };
  const vec3 axis(1, 2, 3), from(-0.2, 0, 0), to(0.3, 0.1, 0.3);
  same([&](const pose& p) { return ball_joint{.at = p.to_world(from)}; });
  same([&](const pose& p) { return fixed_joint{.at = p.to_world(from)}; });
  same([&](const pose& p) { return weld{.at = p.to_world(from)}; });
  same([&](const pose& p) {
    return hinge{.at = p.to_world(from),
                 .axis = rotated(p.orientation, axis),
                 .limits = {-0.1, 0.1},
                 .friction = 0.01};
  });
  same([&](const pose& p) {
    return slider{.at = p.to_world(from),
                  .axis = rotated(p.orientation, axis),
                  .motor = {.velocity = 0.1, .largest_force = 0.2},
                  .spring = {.stiffness = 1, .damping = 0.1}};
  });
  same([&](const pose& p) {
    return cylindrical_joint{.at = p.to_world(from), .axis = rotated(p.orientation, axis)};
  });
  same([&](const pose& p) {
    return universal_joint{.at = p.to_world(from),
                           .first_axis = rotated(p.orientation, {0, 0, 1}),
                           .second_axis = rotated(p.orientation, {1, 0, 0})};
  });
  same([&](const pose& p) { return rod{.from = p.to_world(from), .to = p.to_world(to)}; });
  same([&](const pose& p) {
    return rope{.from = p.to_world(from), .to = p.to_world(to), .length = 0.7};
  });
  same([&](const pose& p) {
    return point_on_plane{.at = p.to_world(from), .normal = rotated(p.orientation, axis)};
  });
  same([&](const pose& p) {
    return strut{
        .from = p.to_world(from), .to = p.to_world(to), .spring = {.stiffness = 2, .damping = 0.1}};
  });
}

TEST_CASE("a strut is a spring between two points, a damper, and a cylinder that lifts") {
  in_world<second_order>([](auto& w, material_id stuff) {
    w.gravity({0, 0, 0});
    const auto a = add_brick(w, stuff, {0, 0, 0}), b = add_brick(w, stuff, {2, 0, 0});
    const real stiffness = 4;
    const auto coil = w.join(
        a, b,
        strut{.from = {0, 0, 0}, .to = {2, 0, 0}, .spring = {.stiffness = stiffness, .rest = 0.5}});
    // The reduced mass is half of that of a brick; at first the spring pushes by 0.5 too short.
    const real period = 2 * pi * std::sqrt(mass / 2 / stiffness);
    const int steps = 1000;
    for (int k = 0; k < steps; ++k) w.step(period / 2 / steps);
    CHECK(w[b].position()[0] - w[a].position()[0] == doctest::Approx(3).epsilon(1e-6));
    CHECK(coil.force()[0] == doctest::Approx(stiffness * 0.5).epsilon(1e-4));
    for (int k = 0; k < steps; ++k) w.step(period / 2 / steps);
    CHECK(w[b].position()[0] - w[a].position()[0] == doctest::Approx(2).epsilon(1e-6));
    CHECK((w[a].position() + w[b].position() - vec3(2, 0, 0)).norm() < 1e-13);
    CHECK(measure_energy(w).worst < 1e-11);
  });
  in_world([](auto& w, material_id stuff) {
    const auto a = add_brick(w, stuff, {0, 0, 0}), b = add_brick(w, stuff, {3, 0, 0});
    const real damping = 2;
    (void)w.join(world_frame, a,
                 strut{.from = {0, 0, 5}, .to = {0, 0, 0}, .spring = {.damping = damping}});
    auto jack = w.join(world_frame, b,
                       strut{.from = {3, 0, -5},
                             .to = {3, 0, 0},
                             .limits = {.upper = 0.4},
                             .motor = {.velocity = 1, .largest_force = 2 * mass * g}});
    for (int k = 0; k < 200; ++k) w.step(1e-3);
    CHECK(w[b].position()[2] == doctest::Approx(0.2 - 1 / g / 2).epsilon(1e-2));
    CHECK((jack.force() - vec3(0, 0, -mass * g)).norm() < 1e-9 * mass * g);
    for (int k = 0; k < 800; ++k) w.step(1e-3);
    CHECK(w[b].position()[2] == doctest::Approx(0.4).epsilon(1e-9));
    CHECK(jack.travel() == doctest::Approx(0.4).epsilon(1e-9));
    CHECK(w[a].velocity()[2] == doctest::Approx(-mass * g / damping).epsilon(1e-9));
    jack.set_motor(force_motor{});
    for (int k = 0; k < 100; ++k) w.step(1e-3);
    CHECK(w[b].velocity()[2] == doctest::Approx(-0.1 * g).epsilon(1e-9));
    CHECK(measure_energy(w).worst < 1e-9);
  });
}

TEST_CASE("a weld bears what it can, and breaks above that") {
  in_world([](auto& w, material_id stuff) {
    const auto a = add_brick(w, stuff, {0, 0, 0}), b = add_brick(w, stuff, {3, 0, 0}),
               c = add_brick(w, stuff, {6.5, 0, 0});
    const auto strong = w.join(world_frame, a, weld{.largest_force = 1.01 * mass * g});
    const auto weak =
        w.join(world_frame, b, weld{.at = {3, 0, 0}, .largest_force = 0.99 * mass * g});
    const auto bent =
        w.join(world_frame, c, weld{.at = {6, 0, 0}, .largest_torque = 0.49 * mass * g});
    CHECK(weak.known());
    for (int k = 0; k < 101; ++k) w.step(1e-3);
    CHECK(strong.known());
    CHECK_FALSE(weak.known());
    CHECK_FALSE(bent.known());
    CHECK(w[a].position()[2] == doctest::Approx(0));
    for (const auto& h : {b, c})  // it breaks after the first step
      CHECK(w[h].velocity()[2] == doctest::Approx(-0.1 * g).epsilon(1e-9));
  });
}

TEST_CASE("a pair of gears turns at its ratio, over any number of turns, and balances torques") {
  in_world([](auto& w, material_id stuff) {
    w.gravity({0, 0, 0});
    const auto a = add_brick(w, stuff, {0, 0, 0}), b = add_brick(w, stuff, {3, 0, 0});
    const auto first = w.join(world_frame, a, hinge{});
    const auto second = w.join(world_frame, b, hinge{.at = {3, 0, 0}});
    const real ratio = -2.5, inertia = mass * brick.inertia()[2], torque = 0.02;
    auto driver = first;
    driver.set_motor(torque_motor{.velocity = 100, .largest_torque = torque});
    const auto pair = w.join(a, b, gear{.ratio = ratio});
    real off = 0;
    for (int k = 0; k < 5000; ++k) {
      w.step(1e-3);
      off = std::max(off, std::abs(second.angle() - ratio * first.angle()));
    }
    CHECK(first.angle() > 4 * pi);
    CHECK(off < 1e-10);
    // The motor accelerates both: I (1 + ratio^2).
    const real rate = torque / (inertia * (1 + ratio * ratio)) * 5;
    CHECK(w[a].angular_velocity()[2] == doctest::Approx(rate).epsilon(1e-9));
    CHECK(std::abs(pair.torque()[2]) ==
          doctest::Approx(torque * ratio * ratio / (1 + ratio * ratio)).epsilon(1e-9));
    CHECK(measure_energy(w).worst < 1e-9);
  });
}

TEST_CASE("a rope is slack, and then bears the weight") {
  in_world([](auto& w, material_id stuff) {
    const auto h = add_brick(w, stuff, {0, 0, 0});
    const auto line =
        w.join(world_frame, h, rope{.from = {0, 0, 1}, .to = {0, 0, 0}, .length = 1.2});
    for (int k = 0; k < 150; ++k) w.step(1e-3);
    CHECK(line.force() == vec3(0, 0, 0));
    CHECK(w[h].velocity()[2] == doctest::Approx(-0.15 * g));
    for (int k = 0; k < 500; ++k) w.step(1e-3);
    CHECK(w[h].position()[2] == doctest::Approx(-0.2).epsilon(1e-10));
    CHECK((line.force() - vec3(0, 0, -mass * g)).norm() < 1e-10);
  });
}

TEST_CASE("wrong joints are refused in words") {
  in_world([](auto& w, material_id stuff) {
    const auto a = add_brick(w, stuff, {0, 0, 0}), b = add_brick(w, stuff, {1, 0, 0});
    const auto refused = [&](const auto& kind, const char* words) {
      CHECK_THROWS_WITH_AS((void)w.join(a, b, kind), doctest::Contains(words),
                           std::invalid_argument);
    };
    refused(hinge{.axis = {0, 0, 0}}, "the axis of a hinge must have a length above 0");
    refused(hinge{.limits = {1, -1}}, "the lower limit of a hinge must not be above the upper one");
    refused(slider{.friction = -1}, "the friction of a slider must be finite and not negative");
    refused(hinge{.motor = {.velocity = 1, .largest_torque = -1}}, "must not be negative");
    refused(hinge{.spring = {.stiffness = std::nan("")}}, "stiffness and damping of the spring");
    refused(universal_joint{.second_axis = {1, 0, 1}}, "must be perpendicular");
    refused(rod{.from = {1, 2, 3}, .to = {1, 2, 3}}, "the points of a rod must be different");
    refused(rope{.from = {0, 0, 0}, .to = {0, 0, 2}, .length = 1}, "does not reach from");
    refused(strut{.from = {1, 2, 3}, .to = {1, 2, 3}}, "the points of a strut must be different");
    refused(strut{.friction = -1}, "the friction of a strut must be finite and not negative");
    refused(weld{.largest_force = 0}, "the largest force and torque of a weld must be above 0");
    refused(gear{.ratio = 0}, "the ratio of a gear must be finite and not 0");
    CHECK_THROWS_WITH_AS((void)w.join(world_frame, world_frame, ball_joint{}),
                         doctest::Contains("as both bodies"), std::invalid_argument);
    const auto rock = *w.add_if_local(
        body{.shape = brick, .position = {9, 0, 0}, .material = stuff, .fixed = true});
    CHECK_THROWS_WITH_AS((void)w.join(world_frame, rock, ball_joint{}),
                         doctest::Contains("two bodies that cannot move"), std::invalid_argument);
    auto pin = w.join(a, b, hinge{});
    CHECK_THROWS_WITH_AS(pin.set_motor(torque_motor{.largest_torque = -2}),
                         doctest::Contains("must not be negative"), std::invalid_argument);
  });
}
