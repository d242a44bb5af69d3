// Faults that were reported of other engines, with joints, fast bodies and soft contacts:
// docs/validation/faults_elsewhere.md.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/force.hpp>
#include <talus/shape/union_of.hpp>
#include <vector>

#include "../world/machines.hpp"
#include "elsewhere.hpp"

using namespace talus;
using namespace talus::validation;
using machines::add_brick;
using machines::brick;
using machines::energy_of;
using machines::in_world;
using machines::second_order;

namespace {

using couple = union_of<box>;
using fast = elsewhere<scenario<bodies<sphere, couple, box, plane>, features<continuous_collision>,
                                transport<serial>>>;
template <class Law>
using soft =
    elsewhere<scenario<bodies<sphere, plane>, Law, integrator<velocity_verlet>, transport<serial>>>;
using hertz = soft<soft_contact<hertz_mindlin, coulomb_friction>>;
using linear = soft<soft_contact<linear_spring_dashpot, coulomb_friction>>;

/// The height after a fall from rest, and the place after a throw, by one integrator.
template <class Scenario>
real height_after_fall(real weight, real dt, int steps) {
  real z = 0;
  in_world<Scenario>([&](auto& w, material_id stuff) {
    w.gravity({0, 0, -weight});
    const auto h = add_brick(w, stuff, {0, 0, 0});
    for (int k = 0; k < steps; ++k) w.step(dt);
    z = w[h].position()[2];
  });
  return z;
}

}  // namespace

// Free motion. The default integrator, semi-implicit Euler, shares these three faults; the value of
// moreau_midpoint is the exact one.

TEST_CASE("a body falls by g t^2 / 2 with moreau_midpoint, and by g t dt / 2 more by default") {
  const real dt = 1.0 / 60;
  check_absolute("rapier #525", "height after 60 steps with moreau_midpoint, m", -0.5 * earth,
                 height_after_fall<second_order>(earth, dt, 60), 1e-12);
  check_absolute("rapier #525", "height after 60 steps by default, m", -0.5 * earth * (1 + dt),
                 height_after_fall<machines::first_order>(earth, dt, 60), 1e-12);
}

TEST_CASE("a position advances with the mean velocity of the step with moreau_midpoint") {
  in_world<second_order>([](auto& w, material_id stuff) {
    const auto h = add_brick(w, stuff, {0, 0, 0});
    w[h].set_velocity({3, 0, 4});
    for (int k = 0; k < 60; ++k) w.step(1.0 / 60);
    check_absolute("bullet3 #1446", "distance from the parabola after 1 s, m", 0,
                   (w[h].position() - vec3(3, 0, 4 - 0.5 * earth)).norm(), 1e-12);
  });
}

TEST_CASE("a force of one step moves a body by F t^2 / (2 m) with moreau_midpoint") {
  check_absolute("gazebo-classic #743", "way with moreau_midpoint, m", 0.0005,
                 -height_after_fall<second_order>(1000, 1e-3, 1), 1e-12);
  check_absolute("gazebo-classic #743", "way by default, m", 0.001,
                 -height_after_fall<machines::first_order>(1000, 1e-3, 1), 1e-12);
}

// Joints.

TEST_CASE("limits of hinges hold a cantilever of bodies against gravity") {
  in_world([](auto& w, material_id stuff) {
    std::vector<handle<box>> chain;
    for (int k = 0; k < 6; ++k) {
      chain.push_back(add_brick(w, stuff, {0.6 * k, 0, 0}));
      const hinge kind{
          .at = {0.6 * k - 0.3, 0, 0}, .axis = {0, 1, 0}, .limits = {-10 * degree, 10 * degree}};
      if (k == 0)
        (void)w.join(world_frame, chain[0], kind);
      else
        (void)w.join(chain[static_cast<std::size_t>(k) - 1], chain.back(), kind);
    }
    for (int k = 0; k < 4000; ++k) w.step(1e-3);
    const vec3 axis = rotated(w[chain.back()].orientation(), vec3::UnitX());
    check_absolute("avian #553", "angle of the last body, degrees", 60,
                   std::atan2(-axis[2], axis[0]) / degree, 1e-3);
  });
}

TEST_CASE("a hinge whose limits are equal holds that angle") {
  in_world([](auto& w, material_id stuff) {
    const auto h = add_brick(w, stuff, {0.5, 0, 0});
    const auto pin =
        w.join(world_frame, h, hinge{.axis = {0, 1, 0}, .limits = {-60 * degree, -60 * degree}});
    for (int k = 0; k < 4000; ++k) w.step(1e-3);
    check_absolute("defold #8438", "angle, degrees", -60, pin.angle() / degree, 1e-6);
  });
}

TEST_CASE("a spring without damper loses no energy with moreau_midpoint") {
  const auto kept = []<class Scenario>(Scenario*) {
    real left = 0;
    in_world<Scenario>([&](auto& w, material_id stuff) {
      w.gravity({0, 0, 0});
      const auto h = add_brick(w, stuff, {0, 0, 0});
      const real inertia = machines::mass * brick.inertia()[2];
      const auto pin = w.join(world_frame, h, hinge{.spring = {.stiffness = 4 * inertia}});
      w[h].set_angular_velocity({0, 0, 2});  // an amplitude of 1 rad, and a period of pi s
      real most = 0;
      for (int k = 0; k < 17000; ++k) {
        w.step(2e-3);
        if (k > 15200) most = std::max(most, std::abs(pin.angle()));
      }
      left = most;
    });
    return left;
  };
  check_absolute("dart #846", "amplitude after 10 periods with moreau_midpoint, rad", 1,
                 kept(static_cast<second_order*>(nullptr)), 1e-3);
  // By default each step of h divides the amplitude by sqrt(1 + (omega h)^2).
  check_absolute("dart #846", "amplitude after 10 periods by default, rad",
                 std::pow(1 + 16e-6, -10 * pi / 2e-3 / 2),
                 kept(static_cast<machines::first_order*>(nullptr)), 5e-3);
}

TEST_CASE("motors inside a free mechanism do not change its momentum") {
  const auto turns = []<class Scenario>(Scenario*, const char* how, real exact) {
    in_world<Scenario>([&](auto& w, material_id stuff) {
      w.gravity({0, 0, 0});
      std::vector<handle<box>> chain;
      for (int k = 0; k < 4; ++k) {
        chain.push_back(add_brick(w, stuff, {0.6 * k, 0, 0}));
        if (k > 0)
          (void)w.join(chain[static_cast<std::size_t>(k) - 1], chain.back(),
                       hinge{.at = {0.6 * k - 0.3, 0, 0},
                             .axis = {0, real(k % 2), real(1 - k % 2)},
                             .motor = {.velocity = 2, .largest_torque = 0.05}});
      }
      for (int k = 0; k < 2000; ++k) w.step(1e-3);
      const motion m = measure_motion(w);
      check_absolute("bullet3 #2698", std::string("momentum after 2 s, kg m/s, ") + how, 0,
                     m.momentum.norm(), 1e-12);
      check_absolute("bullet3 #2698", std::string("angular momentum after 2 s, kg m^2/s, ") + how,
                     0, m.angular_momentum.norm(), exact);
    });
  };
  turns(static_cast<second_order*>(nullptr), "with moreau_midpoint", 1e-5);
  turns(static_cast<machines::first_order*>(nullptr), "by default", 1e-5);
}

TEST_CASE("a heavy body hangs on light ones") {
  in_world([](auto& w, material_id stuff) {
    const auto lead = w.material({.density = 1000});
    handle<box> last;
    for (int k = 0; k < 8; ++k) {
      const auto h = *w.add_if_local(body{
          .shape = brick, .position = {0, 0, -0.2 * k - 0.1}, .material = k == 7 ? lead : stuff});
      const ball_joint kind{.at = {0, 0, -0.2 * k}};
      if (k == 0)
        (void)w.join(world_frame, h, kind);
      else
        (void)w.join(last, h, kind);
      last = h;
    }
    w[last].set_velocity({1, 0, 0});
    double gap = 0;
    for (int k = 0; k < 2000; ++k) {
      w.step(1e-3);
      gap = std::max(gap, measure_joints(w).gap);
    }
    check_absolute("experiments #4", "largest gap of a joint in 2 s, m", 0, gap, 1e-9);
  });
}

TEST_CASE("a body with another one fixed to it spins as one body") {
  in_world<second_order>([](auto& w, material_id stuff) {
    w.gravity({0, 0, 0});
    const auto a = add_brick(w, stuff, {0, 0, 0}), b = add_brick(w, stuff, {0, 0, 0.2});
    (void)w.join(a, b, fixed_joint{});
    const vec3 spin(30, 0.3, 0);
    w[a].set_angular_velocity(spin), w[b].set_angular_velocity(spin);
    w[a].set_velocity(spin.cross(vec3(0, 0, -0.1))), w[b].set_velocity(spin.cross(vec3(0, 0, 0.1)));
    w.step(1e-3);
    const real before = energy_of(w);
    for (int k = 0; k < 5000; ++k) w.step(1e-3);
    check_absolute("mujoco #3553", "energy after 5 s over that at the start", 1,
                   energy_of(w) / before, 1e-3);
  });
}

// Fast bodies.

TEST_CASE("a fast ball does not pass a thin wall") {
  fast s({.restitution = 0}, 0, 1.0 / 60);
  (void)s.wall(box{{0.1, 4, 4}}, {0, 0, 0});
  const auto h = s.add(sphere{0.2}, {-5, 0.1, 0.2}, {500, 0, 0});
  s.run(1);
  check_absolute("bullet3 #1912", "place of the ball, m", -0.25, s.w[h].position()[0], 1e-3);
}

TEST_CASE("a fast ball passes its momentum to the body that it hits") {
  fast s({.density = 1, .restitution = 0}, 0, 1.0 / 60);
  const auto target = s.add(box{{0.5, 0.5, 0.5}}, {0, 0, 0});
  const auto h = s.add(sphere{0.11}, {-5, 0, 0}, {100, 0, 0});
  const real m = s.w[h].mass(), v = 100 * m / (m + s.w[target].mass());
  s.run(0.5);
  check_absolute("cannon.js #202", "velocity of the target, m/s", v, s.w[target].velocity()[0],
                 1e-6);
}

TEST_CASE("a fast body of two boxes does not pass a thin wall either") {
  fast s({.restitution = 0}, 0, 1.0 / 60);
  (void)s.wall(box{{0.1, 4, 4}}, {0, 0, 0});
  const couple pair(
      std::vector<couple::part>{{.shape = box{{0.2, 0.2, 0.2}}, .at = {{0, -0.2, 0}}},
                                {.shape = box{{0.2, 0.2, 0.2}}, .at = {{0, 0.2, 0}}}});
  const pose at = placed(pair, {{-5, 0, 0}, {1, 0, 0, 0}});
  const auto h = s.add(pair, at.position, {500, 0, 0}, at.orientation);
  s.run(1);
  check_absolute("godot #39095", "place of the body, m", -0.15, s.w[h].position()[0], 1e-3);
}

TEST_CASE("two fast bodies that cross each other's path collide") {
  fast s({.restitution = 1}, 0, 1.0 / 60);
  const auto a = s.add(sphere{0.2}, {-5, 0, 0}, {300, 0, 0});
  const auto b = s.add(sphere{0.2}, {5, 0, 0}, {-300, 0, 0});
  s.run(0.5);
  check_absolute("godot #9071", "velocity of the first one, m/s", -300, s.w[a].velocity()[0], 1e-6);
  check_absolute("godot #9071", "velocity of the second one, m/s", 300, s.w[b].velocity()[0], 1e-6);
}

// Soft contacts.

TEST_CASE("friction adds no energy to a grazing impact on a wall") {
  real worst = 0;
  for (int angle = 5; angle < 90; angle += 3) {
    linear s({.density = 2500, .restitution = 0.9, .friction = 0.5, .stiffness = 1e6}, 0, 1e-5);
    const real a = angle * degree;
    const auto h = s.floor().add(sphere{0.05}, {0, 0, 0.0501}, {std::sin(a), 0, -std::cos(a)});
    const real before = s.energy();
    while (!(s.w[h].velocity()[2] > 0 && s.w[h].position()[2] > 0.0501)) s.w.step(s.dt);
    worst = std::max(worst, s.energy() / before);
  }
  check_absolute("lammps #5007", "energy after the impact over that before, at most 1, largest", 1,
                 std::max<real>(worst, 1), 0);
}

TEST_CASE("a ball on a wall of another stiffness sinks in by Hertz's law for both") {
  hertz s({.density = 1, .youngs_modulus = 400, .poisson_ratio = 0.2}, 0, 1e-3);
  const auto wall = s.w.material({.youngs_modulus = 600, .poisson_ratio = 0.2});
  s.w.global([&](auto& scope) { scope.add(plane{}, wall); });
  const real d = 1e-3, modulus = 1 / ((1 - 0.04) / 400 + (1 - 0.04) / 600);
  const auto h = s.add(sphere{0.05}, {0, 0, 0.05 - d});
  check_absolute("lammps #4141", "effective modulus, Pa", modulus,
                 contact_force(s.w, h)[2] * 0.75 / (std::sqrt(0.05 * d) * d), 1e-9);
}

TEST_CASE("a soft contact returns the given part of the speed") {
  for (const real e : {0.3, 0.5, 0.9}) {
    linear s({.density = 2500, .restitution = e, .stiffness = 1e6}, 0, 1e-6);
    const auto h = s.floor().add(sphere{0.05}, {0, 0, 0.05}, {0, 0, -1});
    while (!(s.w[h].velocity()[2] > 0 && s.w[h].position()[2] > 0.05)) s.w.step(s.dt);
    check_absolute("chrono #221", fmt::format("coefficient, given {}", e), e, s.w[h].velocity()[2],
                   1e-3);
  }
}

TEST_CASE("a soft elastic ball returns to the height from which it fell") {
  hertz s({.density = 2500, .restitution = 1, .youngs_modulus = 1e8}, earth, 1e-5);
  const auto h = s.floor().add(sphere{0.05}, {0, 0, 0.55});
  s.run(0.35);
  check_absolute("Physijs #195", "apex after the first bounce, m", 0.55,
                 s.most(0.5, [&] { return s.w[h].position()[2]; }), 1e-4);
}

TEST_CASE("to read contact forces does not change a run") {
  const auto digest = [](bool reads) {
    hertz s({.density = 2500, .restitution = 0.5, .friction = 0.5, .youngs_modulus = 1e7}, earth,
            1e-4);
    const auto h = s.floor().add(sphere{0.05}, {0, 0, 0.05}, {1, 0, 0});
    (void)s.add(sphere{0.05}, {0.06, 0, 0.13});
    vec3 sum(0, 0, 0);
    for (int k = 0; k < 2000; ++k) {
      s.w.step(s.dt);
      if (reads) sum += contact_force(s.w, h);
    }
    CHECK((sum != vec3(0, 0, 0)) == reads);
    return state_digest(s.w);
  };
  check_absolute("lammps #1631", "runs whose digest differs", 0, digest(true) != digest(false), 0);
}
