// Joints of all kinds in a world: closed forms of statics and of motion, limits, motors, springs,
// friction, chains, and mechanisms of the IFToMM library of benchmark problems.
// timeout: 300
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/cylindrical_joint.hpp>
#include <talus/constraint/fixed_joint.hpp>
#include <talus/constraint/gear.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/point_on_plane.hpp>
#include <talus/constraint/rod.hpp>
#include <talus/constraint/slider.hpp>
#include <talus/constraint/strut.hpp>
#include <talus/constraint/universal_joint.hpp>
#include <talus/constraint/weld.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/joints.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/each_joint.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

constexpr real g = 9.81;

template <class... Policies>
using machine = scenario<bodies<sphere, box>,
                         joints<ball_joint, fixed_joint, hinge, slider, cylindrical_joint,
                                universal_joint, rod, rope, point_on_plane, weld, gear, strut>,
                         transport<threads>, features<energy_ledger>, Policies...>;
using first_order = machine<>;
using second_order = machine<integrator<moreau_midpoint>>;

/// Calls f(world, a material of density 1) on one rank.
template <class Scenario = first_order, class F>
void in_world(F&& f) {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<Scenario> w(link);
    w.gravity({0, 0, -g});
    const auto stuff = w.material({.density = 1});
    f(w, stuff);
  });
}
const box brick{.size = {0.6, 0.4, 0.2}};
constexpr real mass = 0.6 * 0.4 * 0.2;

template <class World>
handle<box> add_brick(World& w, material_id stuff, const vec3& at) {
  return *w.add_if_local(body{.shape = brick, .position = at, .material = stuff});
}
template <class World>
real energy_of(World& w) {
  const auto e = measure_energy(w);
  return e.kinetic + e.potential;
}

}  // namespace

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

TEST_CASE("redundant joints share their load by the least norm") {
  // Two spheres circle about each other: the load of the joint between them lies along the arm.
  const auto loads = [](bool twice, bool first) {
    std::array<std::vector<vec3>, 2> found;
    in_world([&](auto& w, material_id stuff) {
      w.gravity({0, 0, 0});
      const auto ball = [&](const vec3& at) {
        return *w.add_if_local(body{.shape = sphere{0.3}, .position = at, .material = stuff});
      };
      const auto a = ball({-0.5, 0, 0}), b = ball({0.5, 0, 0});
      const point_on_plane plane{.normal = {1, 0, 0}};
      if (twice && first) (void)w.join(a, b, plane);
      const auto pin = w.join(a, b, ball_joint{});
      if (twice && !first) (void)w.join(a, b, plane);
      w[a].set_velocity({0, -2, 0}), w[b].set_velocity({0, 2, 0});
      for (const auto h : {a, b}) w[h].set_angular_velocity({0, 0, 4});
      for (int k = 0; k < 100; ++k) {
        w.step(1e-2);
        found[0].push_back(pin.force());
        if (twice)
          for_each_joint(w, [&](const joint_in_world& x) {
            if (std::string_view(x.name) == point_on_plane::name) found[1].push_back(x.force);
          });
      }
      CHECK(measure_joints(w).gap < 1e-13);
    });
    return found;
  };
  const auto whole = loads(false, false)[0];
  for (const bool first : {true, false}) {
    const auto [on_pin, on_plane] = loads(true, first);
    REQUIRE(on_plane.size() == whole.size());
    for (std::size_t k = 0; k < whole.size(); ++k) {
      const real size = whole[k].norm();
      CHECK((on_pin[k] + on_plane[k] - whole[k]).norm() <= 1e-3 * size);
      CHECK(on_pin[k].norm() <= size);
      CHECK(on_plane[k].norm() <= size);
    }
    // As long as the normal is that of a row of the ball joint, too.
    CHECK((on_pin[1] - 0.5 * whole[1]).norm() < 0.01 * whole[1].norm());
    CHECK((on_plane[1] - 0.5 * whole[1]).norm() < 0.01 * whole[1].norm());
  }
}

TEST_CASE("joints that contradict each other share the opening, and the worst is noted") {
  in_world([](auto& w, material_id stuff) {
    const auto fixed = [&](const vec3& at) {
      return *w.add_if_local(
          body{.shape = sphere{0.2}, .position = at, .material = stuff, .fixed = true});
    };
    const auto left = fixed({-0.8, 0, 0}), right = fixed({0.8, 0, 0}), below = fixed({-2, 0, -3});
    const auto beam = add_brick(w, stuff, {0, 0, 0});
    (void)w.join(left, beam, ball_joint{.at = {-0.5, 0, 0}});
    (void)w.join(right, beam, ball_joint{.at = {0.5, 0, 0}});
    const auto loose = add_brick(w, stuff, {-2, 0, -5}), other = add_brick(w, stuff, {2, 0, -5});
    (void)w.join(below, loose, rod{.from = {-2, 0, -3}, .to = {-2, 0, -5}});
    (void)w.join(loose, other, gear{.ratio = 3});  // nothing holds its axes
    w[loose].set_angular_velocity({3, 2, 1}), w[other].set_angular_velocity({-1, 2, 3});
    for (int k = 1; k <= 100; ++k) {
      w[right].translate({0.01, 0, 0});
      w.step(1e-2);
      CHECK(measure_joints(w).gap == doctest::Approx(0.005 * k).epsilon(1e-3));
      CHECK(std::abs(w[beam].velocity()[0]) < 1);
      CHECK(w[loose].angular_velocity().norm() < 20);
      CHECK(w[other].angular_velocity().norm() < 20);
    }
    const detail::joint_opening& worst = detail::state_of(w).joints.opening;
    CHECK(worst.step == 100);
    CHECK(worst.gap == doctest::Approx(0.5).epsilon(1e-3));
    CHECK((worst.key.b == beam.id && (worst.key.a == left.id || worst.key.a == right.id)));
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

TEST_CASE("a chain of 300 links with a last one of a million masses stays connected") {
  in_world([](auto& w, material_id stuff) {
    const auto heavy = w.material({.density = 1e6});
    const int links = 300;
    std::vector<handle<sphere>> chain;
    std::optional<joint_handle<first_order, ball_joint>> top;
    for (int k = 0; k < links; ++k) {
      const auto h = *w.add_if_local(body{.shape = sphere{0.4},
                                          .position = {0, 0, -k - 0.5},
                                          .material = k + 1 == links ? heavy : stuff});
      const ball_joint pin{.at = {0, 0, -real(k)}};
      if (k == 0) top = w.join(world_frame, h, pin);
      if (k > 0) (void)w.join(chain.back(), h, pin);
      chain.push_back(h);
    }
    // The tension makes a link swing by sqrt(T / (m l)) = 3100 a second, which steps must resolve.
    w[chain[0]].set_velocity({0.1, 0, 0});
    real gap = 0;
    for (int step = 0; step < 200; ++step) {
      w.step(1e-4);
      vec3 end(0, 0, 0);
      for (const auto& h : chain) {
        const auto b = w[h];
        gap =
            std::max(gap, (b.position() + rotated(b.orientation(), vec3(0, 0, 0.5)) - end).norm());
        end = b.position() + rotated(b.orientation(), vec3(0, 0, -0.5));
      }
    }
    CHECK(gap < 1e-10);
    const real weight = sphere{0.4}.volume() * (1e6 + links - 1) * g;
    CHECK(top->force()[2] == doctest::Approx(-weight).epsilon(1e-5));
  });
}

TEST_CASE("a chain of 10 keeps its joints to round-off over 10,000 steps") {
  in_world([](auto& w, material_id stuff) {
    std::vector<handle<box>> chain;
    const box link{.size = {1, 0.1, 0.2}};
    for (int k = 0; k < 10; ++k) {
      const auto h =
          *w.add_if_local(body{.shape = link, .position = {k + 0.5, 0, 0}, .material = stuff});
      const ball_joint pin{.at = {real(k), 0, 0}};
      if (k == 0) (void)w.join(world_frame, h, pin);
      if (k > 0) (void)w.join(chain.back(), h, pin);
      chain.push_back(h);
    }
    real gap = 0;
    for (int step = 0; step < 10000; ++step) {
      w.step(1e-3);
      vec3 end(0, 0, 0);
      for (const auto& h : chain) {
        const auto b = w[h];
        gap =
            std::max(gap, (b.position() + rotated(b.orientation(), vec3(-0.5, 0, 0)) - end).norm());
        end = b.position() + rotated(b.orientation(), vec3(0.5, 0, 0));
      }
    }
    CHECK(gap < 1e-12);
    CHECK(w[chain[9]].position()[2] < -3);
    CHECK(measure_energy(w).worst < 1e-12);
  });
}

TEST_CASE("A01: a pendulum keeps its energy and its length") {
  in_world<second_order>([](auto& w, material_id) {
    const sphere ball{0.1};
    const auto one = w.material({.density = 1 / ball.volume()});
    const auto h = *w.add_if_local(body{.shape = ball, .position = {-1, 0, 0}, .material = one});
    (void)w.join(world_frame, h, rod{.from = {0, 0, 0}, .to = {-1, 0, 0}});
    const real energy = energy_of(w);
    real drift = 0, gap = 0;
    for (int k = 0; k < 10000; ++k) {
      w.step(1e-3);
      drift = std::max(drift, std::abs(energy_of(w) - energy));
      gap = std::max(gap, std::abs(w[h].position().norm() - 1));
    }
    CHECK(drift < 1e-10);
    CHECK(gap < 1e-13);
  });
}

namespace {

/// The upper left corner of n parallelograms in a row, of rods of 1 kg and 1 m, after `time`, by
/// the classical Runge-Kutta method: at the angle x from the vertical
/// ((n + 1) / 3 + n) x'' = ((n + 1) / 2 + n) g sin(x).
vec3 corner_of_four_bars(int windows, real time) {
  const int n = 100000;
  const real h = time / n;
  real x = 0, v = 1;
  const real pull = (real(windows + 1) / 2 + windows) / (real(windows + 1) / 3 + windows);
  const auto f = [&](real y) { return pull * g * std::sin(y); };
  for (int k = 0; k < n; ++k) {
    const real a1 = f(x), v2 = v + h / 2 * a1, a2 = f(x + h / 2 * v), v3 = v + h / 2 * a2,
               a3 = f(x + h / 2 * v2), v4 = v + h * a3, a4 = f(x + h * v3);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return {std::sin(x), 0, std::cos(x)};
}

}  // namespace

TEST_CASE("A02: a four-bar mechanism passes its singular positions") {
  in_world<second_order>([](auto& w, material_id) {
    const real t = 0.01;
    const auto one = w.material({.density = 1 / (t * t)});
    const auto add = [&](const vec3& size, const vec3& at, const vec3& v, const vec3& spin) {
      return *w.add_if_local(body{.shape = box{.size = size},
                                  .position = at,
                                  .material = one,
                                  .velocity = v,
                                  .angular_velocity = spin});
    };
    // The right rod lies in a plane of its own, so that it does not touch the left one.
    const auto left = add({t, t, 1}, {0, 0, 0.5}, {0.5, 0, 0}, {0, 1, 0});
    const auto right = add({t, t, 1}, {1, 3 * t, 0.5}, {0.5, 0, 0}, {0, 1, 0});
    const auto across = add({1, t, t}, {0.5, 0, 1}, {1, 0, 0}, {0, 0, 0});
    const vec3 y(0, 1, 0);
    (void)w.join(world_frame, left, hinge{.at = {0, 0, 0}, .axis = y});
    (void)w.join(world_frame, right, hinge{.at = {1, 3 * t, 0}, .axis = y});
    (void)w.join(left, across, hinge{.at = {0, 0, 1}, .axis = y});
    (void)w.join(right, across, hinge{.at = {1, 3 * t, 1}, .axis = y});
    const real energy = energy_of(w);
    real drift = 0;
    for (int k = 0; k < 10000; ++k) {
      w.step(1e-3);
      drift = std::max(drift, std::abs(energy_of(w) - energy));
    }
    const auto b = w[left];
    const vec3 corner = b.position() + rotated(b.orientation(), vec3(0, 0, 0.5));
    CHECK(drift < 1e-6);
    CHECK((corner - corner_of_four_bars(1, 10)).norm() < 2e-4);
  });
}

TEST_CASE("A02: two coupled four-bar mechanisms keep their energy in singular positions") {
  in_world<second_order>([](auto& w, material_id) {
    const real t = 0.001;
    const int windows = 2, steps = 4000;
    const auto one = w.material({.density = 1 / (t * t)});
    const vec3 y(0, 1, 0);
    std::vector<handle<box>> up;
    for (int k = 0; k <= windows; ++k) {  // each rod lies in a plane of its own
      up.push_back(*w.add_if_local(body{.shape = box{.size = {t, t, 1}},
                                        .position = {real(k), 6 * t * k, 0.5},
                                        .material = one,
                                        .velocity = {0.5, 0, 0},
                                        .angular_velocity = y}));
      (void)w.join(world_frame, up.back(), hinge{.at = {real(k), 6 * t * k, 0}, .axis = y});
    }
    for (int k = 0; k < windows; ++k) {
      const auto across = *w.add_if_local(body{.shape = box{.size = {1, t, t}},
                                               .position = {k + 0.5, 6 * t * k + 3 * t, 1},
                                               .material = one,
                                               .velocity = {1, 0, 0}});
      const auto left = up[static_cast<std::size_t>(k)],
                 right = up[static_cast<std::size_t>(k) + 1];
      (void)w.join(left, across, hinge{.at = {real(k), 6 * t * k, 1}, .axis = y});
      (void)w.join(across, right, hinge{.at = {real(k + 1), 6 * t * k, 1}, .axis = y});
    }
    const real energy = energy_of(w);
    real drift = 0;
    for (int k = 0; k < steps; ++k) {
      w.step(1e-3);
      drift = std::max(drift, std::abs(energy_of(w) - energy));
    }
    const auto b = w[up[0]];
    const vec3 corner = b.position() + rotated(b.orientation(), vec3(0, 0, 0.5));
    vec3 exact = corner_of_four_bars(windows, steps * 1e-3);
    exact[1] = corner[1];
    CHECK(drift < 1e-9);
    CHECK((corner - exact).norm() < 1e-4);
  });
}

TEST_CASE("A04: Bricard's mechanism, which is overconstrained, moves and keeps its energy") {
  in_world<second_order>([](auto& w, material_id) {
    const real t = 0.02;
    const auto one = w.material({.density = 1 / (t * t)});
    const vec3 corner[] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, -1}, {0, -1, -1}, {0, 0, -1}};
    const vec3 axis[] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    std::vector<handle<box>> rods;
    std::vector<vec3> start, end;  // of each rod, in its frame
    for (int k = 0; k < 5; ++k) {
      const vec3 along = corner[k + 1] - corner[k], at = 0.5 * (corner[k] + corner[k + 1]);
      vec3 size(t, t, t);
      for (int i = 0; i < 3; ++i) size[i] = std::max(t, std::abs(along[i]));
      rods.push_back(
          *w.add_if_local(body{.shape = box{.size = size}, .position = at, .material = one}));
      start.push_back(corner[k] - at), end.push_back(corner[k + 1] - at);
    }
    (void)w.join(world_frame, rods[0], hinge{.at = corner[0], .axis = axis[0]});
    for (std::size_t k = 1; k < 5; ++k)
      (void)w.join(rods[k - 1], rods[k], hinge{.at = corner[k], .axis = axis[k]});
    (void)w.join(rods[4], world_frame, hinge{.at = corner[5], .axis = axis[5]});
    const real energy = energy_of(w);
    real drift = 0, gap = 0, way = 0;
    for (int step = 0; step < 10000; ++step) {
      w.step(1e-3);
      drift = std::max(drift, std::abs(energy_of(w) - energy));
      vec3 last = corner[0];
      for (std::size_t k = 0; k < 5; ++k) {
        const auto b = w[rods[k]];
        gap = std::max(gap, (b.position() + rotated(b.orientation(), start[k]) - last).norm());
        last = b.position() + rotated(b.orientation(), end[k]);
      }
      gap = std::max(gap, (last - corner[5]).norm());
      way = std::max(way, (w[rods[2]].position() - vec3(1, -1, -0.5)).norm());
    }
    CHECK(gap < 1e-13);
    CHECK(drift < 1e-6);
    CHECK(way > 1.5);
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
