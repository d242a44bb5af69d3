// The torque of contacts on a body: against statics, against the change of angular momentum, and
// the same on any ranks, across periodic sides too.
#include <doctest/doctest.h>

#include <cmath>
#include <map>
#include <mutex>
#include <talus/observe/force.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "../scenes/solids.hpp"

using namespace talus;

namespace {

using cells = grid<dynamic, dynamic>;
using scene = scenes::solids;
using soft_scene =
    scenario<bodies<sphere, plane>,
             soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>,
             decomposition<cells>>;

constexpr real g = 10;

real distance(const vec3& a, const vec3& b) { return (a - b).norm(); }

}  // namespace

TEST_CASE("a plank on two supports: torques are those of statics, and equal their reaction") {
  for (const int ranks : {1, 4})
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      CAPTURE(ranks);
      world<scene> w(link, cells{.lower = {-4, -4}, .upper = {4, 4}});
      w.gravity({0, 0, -g});
      w.material({.density = 1, .friction = 0.5});
      handle<box> left, right;
      handle<plane> ground;
      w.global([&](auto& scope) {
        ground = scope.add(plane{}, {});
        left = scope.add(body{.shape = box{{0.5, 2, 1}}, .position = {-1.75, 0, 0.5}});
        right = scope.add(body{.shape = box{{0.5, 2, 1}}, .position = {2.75, 0, 0.5}});
      });
      // From -2 to 3, its centre at 0.5, a weight of 50 on its right part at 2.
      w.add_if_local(body{.shape = box{{5, 1, 1}}, .position = {0.5, 0, 1.5}});
      w.add_if_local(body{.shape = box{{1, 1, 5}}, .position = {2, 0, 4.5}});
      const handle<box> plank{detail::id_of_attempt(3)}, load{detail::id_of_attempt(4)};
      for (int k = 0; k < 200; ++k) w.step(0.005);
      const vec3 about(-1, 0.5, 0.2);
      const vec3 weight(0, 0, -50);
      const vec3 on_plank = contact_torque(w, plank, about),
                 on_load = contact_torque(w, load, about);
      const vec3 by_load = vec3(vec3(2, 0, 4.5) - about).cross(weight);
      const vec3 by_plank = vec3(vec3(0.5, 0, 1.5) - about).cross(weight);
      CHECK(distance(on_load, -by_load) < 1e-2);
      CHECK(distance(on_plank, -by_plank) < 1e-2);
      CHECK(contact_torque(w, load, {2, 0, 4.5}).norm() < 1e-2);
      // The force of the supports equals the weight of the bodies above.
      const vec3 on_supports = contact_torque(w, left, about) + contact_torque(w, right, about);
      CHECK(distance(on_supports, -(on_plank + on_load)) < 1e-9);
      CHECK(distance(on_supports, by_load + by_plank) < 2e-2);
      CHECK(contact_torque(w, ground, about).norm() == 0);
    });
}

TEST_CASE("contact_torque times dt is the change of angular momentum in an impact") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<scene> w(link, cells{.lower = {-4, -4}, .upper = {4, 4}});
    w.material({.restitution = 0.3, .friction = 0.4});
    handle<plane> ground;
    w.global([&](auto& scope) { ground = scope.add(plane{}, {}); });
    const auto crate = w.add(body{.shape = box{{1, 1, 1}},
                                  .position = {0.3, -0.2, 0.9},
                                  .velocity = {1, 0.5, -3},
                                  .angular_velocity = {0.4, 0, 0.2},
                                  .orientation = rotation({1, 0.4, 0.2}, 0.6)});
    const real dt = 1e-5;
    const real inertia = w[crate].inertia()[0];  // a cube: the same about all axes
    vec3 before = w[crate].angular_velocity();
    CHECK(contact_torque(w, crate, {0, 0, 0}).norm() == 0);  // before the first step
    int k = 0;
    while (k++ < 50000 && contact_force(w, crate).norm() == 0) {
      before = w[crate].angular_velocity();
      w.step(dt);
    }
    const vec3 gain = inertia * (w[crate].angular_velocity() - before);
    const vec3 torque = contact_torque(w, crate, w[crate].position());
    CHECK(gain.norm() > 0.1);
    CHECK(distance(torque * dt, gain) < 1e-3 * gain.norm());
    // About another point, the moment of the force is added; the ground has the opposite of all.
    const vec3 about(2, 1, -3);
    const vec3 moved = torque + vec3(w[crate].position() - about).cross(contact_force(w, crate));
    CHECK(distance(contact_torque(w, crate, about), moved) < 1e-9 * moved.norm());
    CHECK(distance(contact_torque(w, ground, about), -moved) < 1e-9 * moved.norm());
  });
}

TEST_CASE("soft contacts: the torque is what turns the body, rolling friction included") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<soft_scene> w(link, cells{.lower = {-4, -4}, .upper = {4, 4}});
    w.gravity({0, 0, -g});
    w.material({.restitution = 0.5, .friction = 0.5, .stiffness = 1e5, .rolling_friction = 0.1});
    handle<plane> ground;
    w.global([&](auto& scope) { ground = scope.add(plane{}, {}); });
    const auto a = w.add(
        body{.shape = sphere{0.5}, .position = {0, 0, 0.4999}, .angular_velocity = {3, 4, 1}});
    const auto b = w.add(
        body{.shape = sphere{0.4}, .position = {0.7, 0.3, 0.9}, .angular_velocity = {0, 4, -2}});
    w.add(body{.shape = sphere{0.3}, .position = {-3, 0, 0.3}});
    const real dt = 1e-6;
    for (int k = 0; k < 200; ++k) w.step(dt);
    vec3 forces(0, 0, 0), torques(0, 0, 0);
    for (const auto h : {a, b}) {
      const vec3 x = w[h].position(), w0 = w[h].angular_velocity();
      const vec3 torque = contact_torque(w, h, x);
      forces += contact_force(w, h), torques += contact_torque(w, h, {1, 2, 3});
      w.step(dt);
      const vec3 gain = w[h].inertia()[0] * (w[h].angular_velocity() - w0) / dt;
      INFO(torque[0], " ", torque[1], " ", torque[2]);
      CHECK(torque.norm() > 1e-2);
      CHECK(distance(torque, gain) < 1e-2 * gain.norm());
    }
    const handle<sphere> still{detail::id_of_rank(0, 2)};
    const vec3 rest = contact_torque(w, still, {1, 2, 3});
    CHECK(distance(contact_torque(w, ground, {1, 2, 3}), -(torques + rest)) <
          0.05 * torques.norm());
  });
}

TEST_CASE("a pile has the same contact torques on one rank and on four") {
  std::map<system_id, vec3> alone;
  for (const int ranks : {1, 4}) {
    std::mutex one;
    std::map<system_id, vec3> found;
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<scene> w(link, cells{.lower = {-2, -2}, .upper = {2, 2}});
      w.gravity({0, 0, -g});
      w.material({.friction = 0.4});
      w.solver().iterations = 200;
      handle<plane> ground;
      w.global([&](auto& scope) { ground = scope.add(plane{}, {}); });
      std::vector<handle<box>> all;
      for (int k = 0; k < 18; ++k) {
        w.add_if_local(body{.shape = box{{0.9, 0.9, 0.9}},
                            .position = {-0.95 + 0.95 * (k % 3), -0.95 + 0.95 * (k / 3 % 3),
                                         0.451 + 0.902 * (k / 9)},
                            .velocity = {0.3 * (k % 2), 0, 0}});
        all.push_back({detail::id_of_attempt(1 + static_cast<std::uint64_t>(k))});
      }
      for (int k = 0; k < 20; ++k) w.step(0.005);
      for (const auto h : all) {
        const vec3 t = contact_torque(w, h, {0.1, 0.2, 0.3});
        const std::lock_guard lock(one);
        found[h.id] = t;
      }
      const vec3 t = contact_torque(w, ground, {0.1, 0.2, 0.3});
      const std::lock_guard lock(one);
      found[ground.id] = t;
    });
    if (ranks == 1) alone = found;
    vec3 sum(0, 0, 0);
    for (const auto& [id, t] : found) {
      sum += t;
      CHECK(distance(t, alone.at(id)) < 0.02 * (1 + alone.at(id).norm()));
    }
    CHECK(sum.norm() < 1e-9);  // each contact once, with its reaction
  }
}

TEST_CASE("across a periodic side a body has the torque that it has in the middle of the box") {
  using around = periodic<cells, along::x>;
  using periodic_scene = scenario<bodies<box, plane>, decomposition<around>>;
  for (const int ranks : {1, 2}) {
    std::vector<vec3> torques;
    for (const real at : {0., 3.9}) {
      threads::launch({.ranks = ranks}, [&](threads::link& link) {
        world<periodic_scene> w(link, around{{.lower = {-4, -4}, .upper = {4, 4}}});
        w.gravity({0, 0, -g});
        w.material({.friction = 0.5});
        w.global([&](auto& scope) { scope.add(plane{}, {}); });
        const auto wrapped = [](real x) { return x >= 4 ? x - 8 : x; };
        w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {at, 0.5, 0.5}});
        w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {wrapped(at + 0.3), 0.5, 1.5}});
        const handle<box> lower{detail::id_of_attempt(1)}, upper{detail::id_of_attempt(2)};
        for (int k = 0; k < 100; ++k) w.step(0.005);
        const vec3 t = contact_torque(w, lower, {at, 0.5, 0});
        const vec3 u = contact_torque(w, upper, {wrapped(at + 0.3), 0.5, 0});
        if (w.rank() == 0) torques.push_back(t), torques.push_back(u);
      });
    }
    REQUIRE(torques.size() == 4);
    CHECK(torques[0].norm() < 1e-2);  // half of the weight above on each side, and the ground
    CHECK(distance(torques[0], torques[2]) < 1e-2);
    CHECK(distance(torques[1], torques[3]) < 1e-2);
  }
}
