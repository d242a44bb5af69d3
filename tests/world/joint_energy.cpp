// No energy from nothing: rebounds of limits and ropes, alone and with other joints; contacts.
// Motors that contradict each other, and errors that are no numbers. The ledger of such joints.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/rod.hpp>
#include <talus/constraint/slider.hpp>
#include <talus/core/random.hpp>
#include <talus/observe/energy.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/state/joints.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using machine = scenario<bodies<sphere, box, plane>, joints<hinge, rod, rope, slider>,
                         transport<threads>, features<energy_ledger, driven>>;

/// Calls f(world, a material of density 1) on one rank, without gravity.
template <class F>
void in_world(F&& f) {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<machine> w(link);
    w.gravity({0, 0, 0});
    f(w, w.material({.density = 1}));
  });
}
/// Calls make(direction, coefficient of restitution) for joints with the world, at a distance of 2
/// from a sphere that is pushed away from the first of them. Returns its velocity after a step.
template <class F>
vec3 velocity_after_impact(F&& make) {
  vec3 after{0, 0, 0};
  in_world([&](auto& w, material_id stuff) {
    const auto ball = *w.add_if_local(body{.shape = sphere{0.1}, .material = stuff});
    make([&](const vec3& direction, const auto& kind) {
      auto joint = kind;
      joint.from = 2.0 * direction, joint.to = vec3(0, 0, 0);
      w.join(world_frame, ball, joint);
    });
    w[ball].set_velocity({-1, 0, 0});
    w.step(1e-3);
    CHECK(measure_energy(w).worst < 1e-12);
    after = w[ball].velocity();
  });
  return after;
}
const vec3 oblique(0.5, std::sqrt(0.75), 0);

/// A door that turns at 1 rad/s meets a limit of its hinge in the first step. Returns the part of
/// its kinetic energy that is left.
real left_by_limit(real dt, real restitution) {
  real part = 0;
  in_world([&](auto& w, material_id stuff) {
    const auto door = *w.add_if_local(body{.shape = box{{1, 0.2, 0.4}},
                                           .position = {0.5, 0, 0},
                                           .material = stuff,
                                           .velocity = {0, 0.5, 0},
                                           .angular_velocity = {0, 0, 1}});
    w.join(world_frame, door, hinge{.limits = {.upper = 2.5 * dt, .restitution = restitution}});
    const real before = measure_energy(w).kinetic;
    for (int k = 0; k < 5; ++k) {
      w.step(dt);
      CHECK(measure_energy(w).kinetic < (1 + 1e-14) * before);
    }
    CHECK(w[door].angular_velocity()[2] < 0);
    part = measure_energy(w).kinetic / before;
  });
  return part;
}

}  // namespace

TEST_CASE("a rope rebounds with its coefficient, and beside a rod that is pulled with less") {
  const vec3 alone =
      velocity_after_impact([](auto&& add) { add(vec3(1, 0, 0), rope{.restitution = 0.8}); });
  CHECK((alone - vec3(0.8, 0, 0)).norm() < 1e-14);
  // With 0.8 the sphere leaves at 0.8 / sin(60 degrees) = 0.92; with 1 it would gain a third of its
  // energy.
  for (const real e : {0.8, 1.0}) {
    CAPTURE(e);
    const vec3 v = velocity_after_impact(
        [&](auto&& add) { add(vec3(1, 0, 0), rope{.restitution = e}), add(oblique, rod{}); });
    CHECK(std::abs(v.dot(oblique)) < 1e-14);
    CHECK(v[0] > 0);
    CHECK(v[0] <= doctest::Approx(e));
    CHECK(v.norm() < 1 + 1e-14);
    CHECK(v.norm() == doctest::Approx(e == 1 ? 1 : 0.8 / std::sqrt(0.75)).epsilon(1e-12));
  }
}

TEST_CASE(
    "a limit of restitution 1 keeps the energy, but for a part of second order in dt in each "
    "step") {
  const real coarse = 1 - left_by_limit(1e-2, 1), fine = 1 - left_by_limit(5e-3, 1);
  MESSAGE("energy lost: ", coarse, " and ", fine, " with half the step");
  CHECK(coarse >= -1e-14);
  CHECK(coarse < 1e-3);
  CHECK(fine == doctest::Approx(coarse / 4).epsilon(0.02));
  CHECK(left_by_limit(1e-3, 0.5) == doctest::Approx(0.25).epsilon(1e-4));
}

TEST_CASE(
    "of motors that contradict each other the weaker one yields, with a weak spring far away") {
  for (const real rest : {0.0, 1e10}) {
    CAPTURE(rest);
    in_world([&](auto& w, material_id stuff) {
      const auto add = [&](real x) {
        return *w.add_if_local(
            body{.shape = box{{1, 1, 1}}, .position = {x, 0, 0}, .material = stuff});
      };
      const auto wheel = add(0), carried = add(3);
      const auto weak =
          w.join(world_frame, wheel, hinge{.motor = {.velocity = 1, .largest_torque = 1e5}});
      w.join(world_frame, wheel, hinge{.motor = {.velocity = 2, .largest_torque = 5e5}});
      w.join(wheel, carried, slider{.at = {3, 0, 0}, .spring = {.stiffness = 1e-14, .rest = rest}});
      for (int k = 0; k < 3; ++k) w.step(1e-3);
      CHECK(w[wheel].angular_velocity()[2] == doctest::Approx(2).epsilon(1e-9));
      CHECK(weak.torque().norm() == doctest::Approx(1e5).epsilon(1e-9));
    });
  }
}

TEST_CASE("the ledger closes where a motor and a spring work against each other") {
  in_world([](auto& w, material_id stuff) {
    const auto door = *w.add_if_local(body{.shape = box{{1, 0.2, 0.4}},
                                           .position = {0.5, 0, 0},
                                           .material = stuff,
                                           .velocity = {0, 0.5, 0},
                                           .angular_velocity = {0, 0, 1}});
    w.join(world_frame, door,
           hinge{.motor = {.largest_torque = 1e9, .position = 1, .stiffness = 1e3},
                 .spring = {.stiffness = 1e3, .damping = 50, .rest = -1}});
    for (int k = 0; k < 400; ++k) w.step(1e-2);
    const energy_balance e = measure_energy(w);
    CHECK(e.kinetic < 1e-6);
    MESSAGE("the ledger leaves ", e.worst);
    CHECK(e.worst < 1e-12);
  });
}

TEST_CASE("the ledger closes where a rod is torn apart") {
  in_world([](auto& w, material_id stuff) {
    const auto ball = *w.add_if_local(body{
        .shape = sphere{0.1}, .position = {1, 0, 0}, .material = stuff, .velocity = {0, 1, 0}});
    w.join(world_frame, ball, rod{.from = {0, 0, 0}, .to = {1, 0, 0}});
    for (int k = 0; k < 5; ++k) w.step(1e-2);
    w[ball].translate({1e9, 1e9, 0});
    w.step(1e-2);
    MESSAGE("the ledger leaves ", measure_energy(w).error());
    CHECK(measure_energy(w).error() < 1e-12);
  });
}

TEST_CASE("a driven body that pulls a mechanism beyond its reach throws nothing") {
  real fastest = 0;
  std::uint64_t worst = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
    in_world([&](auto& w, material_id stuff) {
      random_stream random(seed);
      const vec3 at(0.3, 0.1 * random.in_ball()[1], 0.1 * random.in_ball()[2]);
      handle<sphere> puller{};
      w.global([&](auto& scope) { puller = scope.add(sphere{0.02}, stuff, at + vec3(0.1, 0, 0)); });
      w.drive(puller, gliding{{1, 0, 0}});
      const auto arm = *w.add_if_local(body{
          .shape = box{{0.2, 0.05, 0.05}}, .position = at + vec3(0, 0, 0.05), .material = stuff});
      w.join(puller, arm, hinge{.at = at + vec3(0.1, 0, 0), .axis = {0, 1, 0}});
      w.join(world_frame, arm, rope{.from = {0, 0, 0}, .to = at, .length = 0.35});
      for (int k = 0; k < 200; ++k) {
        w.step(5e-3);
        const auto body = w[arm];
        const real speed = body.velocity().norm() + 0.1 * body.angular_velocity().norm();
        if (speed > fastest) fastest = speed, worst = seed;
      }
    });
  MESSAGE("fastest ", fastest, " with seed ", worst);
  CHECK(fastest < 500);
}

TEST_CASE("a scenario that can drive bodies, but drives none, gains no energy from contacts") {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<machine> w(link);
    w.gravity({0, 0, -9.81});
    const auto stuff = w.material({.density = 1, .restitution = 0.5, .friction = 0.7});
    w.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, 1}}, stuff); });
    w.solver().iterations = 2;
    random_stream random(7);
    for (int k = 0; k < 30; ++k)
      w.add_if_local(body{.shape = box{{0.2, 0.15, 0.1}},
                          .position = {0.21 * (k % 3), 0.21 * (k / 3 % 2), 0.3 + 0.21 * (k / 6)},
                          .material = stuff,
                          .angular_velocity = 5 * random.in_ball(),
                          .orientation = random.rotation()});
    real gain = 0;
    for (int k = 0; k < 300; ++k) {
      w.step(5e-3);
      const energy_balance e = measure_energy(w);
      gain = std::max(gain, std::min(-e.step.friction - e.step.impact,
                                     e.step.scheme - e.step.friction - e.step.impact) /
                                e.scale);
    }
    MESSAGE("largest gain in a step ", gain);
    CHECK(gain < 1e-12);
  });
}

TEST_CASE("an error that is no number is the largest") {
  constexpr real none = std::numeric_limits<real>::quiet_NaN();
  std::array<detail::joint_line, 3> lines{};
  for (auto& x : lines) x.use = detail::line_use::holds, x.force = {1, 0, 0}, x.error = 0.1;
  CHECK(detail::opening_of(lines, 2).part == doctest::Approx(0.05));
  for (const std::size_t k : {0u, 1u, 2u}) {
    auto with = lines;
    with[k].error = none;
    CHECK(detail::opening_of(with, 2).part > 1e300);
    with[k].force = {0, 0, 0};
    CHECK(detail::opening_of(with, 2).part > 1e300);
  }
}
