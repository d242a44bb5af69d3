// Motors, limits, springs and friction of joints.
// timeout: 300
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "machines.hpp"

using namespace machines;

TEST_CASE("a velocity motor turns at its speed, or with its largest torque") {
  in_world([](auto& w, material_id stuff) {
    w.gravity({0, 0, 0});
    const auto h = add_brick(w, stuff, {0, 0, 0});
    auto pin = w.join(world_frame, h, hinge{.motor = {.velocity = 2, .largest_torque = 0.01}});
    const real inertia = mass * brick.inertia()[2], steps = 2 / (1e-3 * 0.01 / inertia);
    CHECK(steps > 100);
    for (int k = 0; k < 100; ++k) w.step(1e-3);
    CHECK(w[h].angular_velocity()[2] == doctest::Approx(0.1 * 0.01 / inertia).epsilon(1e-10));
    CHECK((pin.torque() - vec3(0, 0, -0.01)).norm() < 1e-14);
    for (int k = 0; k < 4000; ++k) w.step(1e-3);
    CHECK(w[h].angular_velocity()[2] == doctest::Approx(2).epsilon(1e-12));
    CHECK(pin.angle() > 2 * pi);  // over several turns
    pin.set_motor(
        torque_motor{.largest_torque = 0.01, .position = 1, .stiffness = 1, .damping = 0.1});
    for (int k = 0; k < 20000; ++k) w.step(1e-3);
    CHECK(pin.angle() == doctest::Approx(1).epsilon(1e-6));
    CHECK(measure_energy(w).worst < 1e-11);
  });
}

TEST_CASE("a motor whose velocity is out of reach applies its largest torque, for any target") {
  const auto spins = []<class Scenario>(Scenario*, real target, real ratio) {
    in_world<Scenario>([&](auto& w, material_id stuff) {
      w.gravity({0, 0, 0});
      const auto h = add_brick(w, stuff, {0, 0, 0});
      const auto pin =
          w.join(world_frame, h, hinge{.motor = {.velocity = target, .largest_torque = 0.01}});
      real inertia = mass * brick.inertia()[2];
      if (ratio != 0) {
        const auto other = add_brick(w, stuff, {0, 0, 3});
        (void)w.join(world_frame, other, hinge{.at = {0, 0, 3}});
        (void)w.join(h, other, gear{.ratio = ratio});
        inertia *= 1 + ratio * ratio;
      }
      for (int k = 0; k < 100; ++k) w.step(1e-2);
      const real spin = std::copysign(0.01 / inertia, target);
      CHECK(w[h].angular_velocity()[2] / spin ==
            doctest::Approx(1).epsilon(ratio == 0 ? 1e-12 : 1e-6));
      CHECK(std::abs(pin.torque()[2]) <= 0.01 * (1 + 1e-12));
      CHECK(measure_joints(w).gap < 1e-12);
    });
  };
  for (const real target : {1e3, -1e9, 1e12, 1e30, -1e300, 1.7e308})
    for (const real ratio : {0., -100.}) {
      CAPTURE(target);
      CAPTURE(ratio);
      spins(static_cast<first_order*>(nullptr), target, ratio);
      spins(static_cast<second_order*>(nullptr), target, ratio);
    }
}

TEST_CASE("friction beyond the largest torque of a motor holds, with all of that torque") {
  in_world([](auto& w, material_id stuff) {
    w.gravity({0, 0, 0});
    const auto h = add_brick(w, stuff, {0, 0, 0}), k = add_brick(w, stuff, {3, 0, 0});
    const auto held = w.join(
        world_frame, h, hinge{.motor = {.velocity = 2, .largest_torque = 50}, .friction = 100});
    const auto turns = w.join(
        world_frame, k,
        hinge{.at = {3, 0, 0}, .motor = {.velocity = 2, .largest_torque = 100}, .friction = 50});
    for (int n = 0; n < 20; ++n) w.step(1e-3);
    CHECK(std::abs(w[h].angular_velocity()[2]) < 1e-12);
    CHECK(w[k].angular_velocity()[2] == doctest::Approx(2).epsilon(1e-12));
    CHECK(held.torque().norm() < 1e-9);  // both together
    CHECK(turns.torque().norm() < 1e-9);
  });
}

TEST_CASE("a drive that takes a joint from limit to limit within a step opens no joint") {
  in_world([](auto& w, material_id stuff) {
    for (int n = 0; n < 12; ++n) {
      const vec3 at(0, 3 * n, 0);
      const box beam{.size = {0.8, 0.4, 0.4}};
      const auto h = *w.add_if_local(body{.shape = beam, .position = at, .material = stuff});
      const real target = std::pow(10.0, n / 4) * (n % 2 == 0 ? 0.9 : -0.8);
      (void)w.join(world_frame, h,
                   hinge{.at = at + vec3(0.5 - 0.1 * n, 0.1, 0.02 * n),
                         .axis = {0.1 * n, 1, 0.3},
                         .limits = {-0.34, 0.26, 1},
                         .motor = {.largest_torque = no_limit,
                                   .position = target,
                                   .stiffness = 1.8e7,
                                   .damping = 140}});
    }
    for (int k = 0; k < 60; ++k) {
      w.step(1. / 60);
      const joint_errors errors = measure_joints(w);
      CHECK(errors.gap < 1e-12);
      CHECK(errors.angle < 0.02);  // of the limits, by the step
    }
    CHECK(detail::state_of(w).joints.opening.step == 0);
  });
}

TEST_CASE("limits stop a hinge and a slider, with their restitution") {
  in_world([](auto& w, material_id stuff) {
    const auto door = add_brick(w, stuff, {0.5, 0, 0}), block = add_brick(w, stuff, {5, 0, 0});
    const auto pin = w.join(world_frame, door, hinge{.axis = {0, 1, 0}, .limits = {-0.1, 0.5}});
    const auto rail = w.join(
        world_frame, block, slider{.at = {5, 0, 0}, .limits = {.lower = -0.5, .restitution = 0.8}});
    real highest = -1;
    int bounces = 0;
    for (int k = 0; k < 3000; ++k) {
      const real before = w[block].velocity()[2];
      w.step(1e-3);
      const real now = w[block].velocity()[2];
      if (before < -0.5 && now > 0 && bounces++ == 0)
        CHECK(now == doctest::Approx(0.8 * std::sqrt(2 * g * 0.5)).epsilon(0.01));
      if (bounces > 0) highest = std::max(highest, w[block].position()[2]);
    }
    CHECK(bounces > 0);
    CHECK(highest == doctest::Approx(-0.5 + 0.64 * 0.5).epsilon(0.02));
    CHECK(pin.angle() == doctest::Approx(0.5).epsilon(1e-9));
    CHECK(rail.travel() == doctest::Approx(-0.5).epsilon(1e-4));
    CHECK((pin.torque() - vec3(0, mass * g * 0.5 * std::cos(0.5), 0)).norm() < 1e-8);
  });
}

TEST_CASE("a limit beyond a whole turn stops a hinge there, and nowhere else") {
  in_world([](auto& w, material_id stuff) {
    w.gravity({0, 0, 0});
    const auto h = add_brick(w, stuff, {0, 0, 0});
    const auto pin = w.join(
        world_frame, h, hinge{.limits = {-1, 9}, .motor = {.velocity = 5, .largest_torque = 1}});
    real last = 0, jump = 0;
    for (int k = 0; k < 3000; ++k) {
      w.step(1e-3);
      jump = std::max(jump, std::abs(pin.angle() - last)), last = pin.angle();
    }
    CHECK(pin.angle() == doctest::Approx(9).epsilon(1e-9));
    CHECK(jump < 0.006);
  });
}

TEST_CASE("the friction of a hinge holds up to its torque, and then brakes with it") {
  in_world([](auto& w, material_id stuff) {
    const real moment = mass * g * 0.5;  // of the weight, about the hinge
    const auto a = add_brick(w, stuff, {0.5, 0, 0}), b = add_brick(w, stuff, {0.5, 3, 0});
    const auto stuck = w.join(world_frame, a, hinge{.axis = {0, 1, 0}, .friction = 1.01 * moment});
    const auto slips =
        w.join(world_frame, b, hinge{.at = {0, 3, 0}, .axis = {0, 1, 0}, .friction = 0.5 * moment});
    for (int k = 0; k < 300; ++k) w.step(1e-3);
    CHECK(std::abs(stuck.angle()) < 1e-14);
    CHECK(slips.angle() > 0.3);
    CHECK((stuck.torque() - vec3(0, moment, 0)).norm() < 1e-10 * moment);
    CHECK(std::abs(slips.torque()[1]) == doctest::Approx(0.5 * moment).epsilon(1e-9));
    CHECK(measure_energy(w).worst < 1e-11);
  });
}

TEST_CASE("a position motor settles where its stiffness bears the load") {
  in_world([](auto& w, material_id stuff) {
    const auto h = add_brick(w, stuff, {0, 0, 0});
    const real stiffness = 200, damping = 10;
    const auto lift = w.join(world_frame, h,
                             slider{.motor = {.largest_force = 100,
                                              .position = 0.3,
                                              .stiffness = stiffness,
                                              .damping = damping}});
    for (int k = 0; k < 5000; ++k) w.step(1e-3);
    CHECK(lift.travel() == doctest::Approx(0.3 - mass * g / stiffness).epsilon(1e-9));
    CHECK((lift.force() - vec3(0, 0, -mass * g)).norm() < 1e-9 * mass * g);
  });
}

TEST_CASE("a spring oscillates with its period, a stiff one is stable, and friction holds") {
  in_world<second_order>([](auto& w, material_id stuff) {
    const auto h = add_brick(w, stuff, {0, 0, 0});
    const real stiffness = 4;
    const auto rail = w.join(world_frame, h, slider{.spring = {.stiffness = stiffness}});
    const real period = 2 * pi * std::sqrt(mass / stiffness), deep = 2 * mass * g / stiffness;
    const int steps = 1000;
    for (int k = 0; k < steps; ++k) w.step(period / 2 / steps);
    CHECK(w[h].position()[2] == doctest::Approx(-deep).epsilon(1e-5));
    for (int k = 0; k < steps; ++k) w.step(period / 2 / steps);
    CHECK(std::abs(w[h].position()[2]) < 1e-5 * deep);
    CHECK(std::abs(rail.travel()) < 1e-3 * deep);
  });
  in_world([](auto& w, material_id stuff) {
    const auto a = add_brick(w, stuff, {0, 0, 0}), b = add_brick(w, stuff, {3, 0, 0}),
               c = add_brick(w, stuff, {6, 0, 0});
    (void)w.join(world_frame, a, slider{.spring = {.stiffness = 1e9, .damping = 1e5}});
    (void)w.join(world_frame, b, slider{.at = {3, 0, 0}, .friction = 1.01 * mass * g});
    (void)w.join(world_frame, c, slider{.at = {6, 0, 0}, .friction = 0.5 * mass * g});
    for (int k = 0; k < 500; ++k) w.step(1e-3);
    CHECK(std::abs(w[a].position()[2]) < 1e-6);
    CHECK(std::abs(w[b].position()[2]) < 1e-14);
    CHECK(w[c].velocity()[2] == doctest::Approx(-0.5 * g * 0.5).epsilon(1e-9));
  });
}
