// Flush fixed bodies are one surface for soft contacts: spheres rest, slide and roll on them, and
// boxes stand on them, as on one body.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <talus/observe/force.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "../flush_scene.hpp"

using namespace talus;

namespace {

using pair_of_spheres = union_of<sphere>;
using soft_scene =
    scenario<bodies<sphere, box, capsule, cylinder, pair_of_spheres, triangle_mesh>,
             soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>,
             transport<serial>>;

const std::vector<std::function<void(world<soft_scene>&)>>& soft_floors() {
  static const std::vector<std::function<void(world<soft_scene>&)>> all{
      [](auto& w) {
        put_box(w, {2, 2, 0.2}, {0, 0, -0.1});
      },
      [](auto& w) {
        put_box(w, {1, 2, 0.2}, {-0.5, 0, -0.1}), put_box(w, {1, 2, 0.3}, {0.5, 0, -0.15});
      },
      [](auto& w) {
        put_box(w, {1.2, 2, 0.2}, {-0.5, 0, -0.1}), put_box(w, {1.2, 2, 0.3}, {0.5, 0, -0.15});
      },
      [](auto& w) {
        put_box(w, {2, 2, 0.2}, {0, 0, -0.1}, true);
      },
      [](auto& w) {
        put_box(w, {1, 2, 0.2}, {-0.5, 0, -0.1}, true), put_box(w, {1, 2, 0.3}, {0.5, 0, -0.15});
      },
      [](auto& w) { put_rectangle(w, -1, 0), put_rectangle(w, 0, 1); },
      [](auto& w) {
        put_box(w, {1, 2, 0.2}, {-0.5, 0, -0.1}), put_rectangle(w, 0, 1);
      },
      [](auto& w) {
        put_rectangle(w, -1, 0), put_box(w, {1, 2, 0.2}, {0.5, 0, -0.1});
      },
  };
  return all;
}

constexpr real R = 0.03, g = 9.81, stiffness = 1e5;
const material resisting{.density = 1000,
                         .restitution = 0.5,
                         .friction = 0.5,
                         .stiffness = stiffness,
                         .rolling_friction = 0.1};
/// A sphere in equilibrium on its spring that starts at x with a velocity.
struct soft_course {
  real x = 0, height = 0, speed = 0, spin = 0;  ///< largest change; of x, less the motion
};
soft_course go(const std::function<void(world<soft_scene>&)>& floor, real x, real speed,
               real friction, int steps) {
  serial::link link;
  world<soft_scene> w(link);
  w.gravity({0, 0, -g});
  w.material({.density = 1000, .restitution = 0.5, .friction = friction, .stiffness = stiffness});
  floor(w);
  const real mass = 1000 * 4 * pi / 3 * R * R * R, height = R - mass * g / stiffness, dt = 1e-4;
  const vec3 v(speed, 0, 0), spin(0, friction > 0 ? speed / R : 0, 0);
  const auto ball = w.add(body{
      .shape = sphere{R}, .position = {x, 0.013, height}, .velocity = v, .angular_velocity = spin});
  soft_course c;
  for (int k = 1; k <= steps; ++k) {
    w.step(dt);
    const auto& b = w[ball];
    c.x = std::max(c.x, std::abs(b.position()[0] - x - k * dt * speed));
    c.height = std::max(c.height, std::abs(b.position()[2] - height));
    c.speed = std::max(c.speed, (b.velocity() - v).norm());
    c.spin = std::max(c.spin, (b.angular_velocity() - spin).norm());
  }
  return c;
}

}  // namespace

TEST_CASE("a sphere of soft contacts rests near and on seams as on one body") {
  for (std::size_t k = 0; k < soft_floors().size(); ++k)
    for (const real x : {0.0, 0.003, -0.003, 1e-9, 1e-12, 0.02}) {
      CAPTURE(k);
      CAPTURE(x);
      const soft_course c = go(soft_floors()[k], x, 0, 0, 3000);
      CHECK(c.x < 1e-6 * R);
      CHECK(c.height < 1e-6 * R);
    }
}

TEST_CASE("a sphere of soft contacts slides and rolls over seams at its speed") {
  for (std::size_t k = 0; k < soft_floors().size(); ++k)
    for (const real speed : {0.02, -2.0})
      for (const real friction : {0.0, 0.5}) {
        CAPTURE(k);
        CAPTURE(speed);
        CAPTURE(friction);
        const int steps = 1000;
        const soft_course c =
            go(soft_floors()[k], -speed * steps / 2 * 1e-4 + 1e-5, speed, friction, steps);
        CHECK(c.speed < 1e-6 * std::abs(speed));
        CHECK(c.height < 1e-6 * R);
        CHECK(c.spin * R < 1e-6 * std::abs(speed));
      }
}

TEST_CASE("bodies that resist rolling roll over seams as on one body") {
  const quat lying = rotation({1, 0, 0}, pi / 2);
  const auto roll = [&](const auto& floor, const auto& shape, real turn) {
    serial::link link;
    world<soft_scene> w(link);
    w.gravity({0, 0, -g});
    w.material(resisting);
    floor(w);
    const quat q = rotation({0, 0, 1}, turn);
    const vec3 v = q * vec3(1, 0, 0), spin = q * vec3(0, 1 / R, 0);
    const auto h = w.add(body{.shape = shape,
                              .position = vec3(-0.05, 0.002, R),
                              .velocity = v,
                              .angular_velocity = spin,
                              .orientation = q * lying});
    for (int k = 0; k < 1500; ++k) w.step(1e-4);
    return std::pair(vec3(w[h].position()), vec3(w[h].angular_velocity()));
  };
  const auto all = [&](const auto& shape, real turn) {
    const auto [there, spin] = roll(soft_floors()[0], shape, turn);
    CHECK(there[0] > 0.02);
    for (std::size_t k = 1; k < soft_floors().size(); ++k) {
      CAPTURE(k);
      CAPTURE(turn);
      const auto [at, turns] = roll(soft_floors()[k], shape, turn);
      CHECK((at - there).norm() < 1e-6 * R);
      CHECK((turns - spin).norm() * R < 1e-6);
    }
  };
  all(sphere{R}, 0), all(sphere{R}, 0.7);
  all(cylinder{R, 0.1}, 0), all(cylinder{R, 0.1}, 0.1), all(cylinder{R, 0.1}, -0.4);
  all(capsule{R, 0.1}, 0), all(capsule{R, 0.1}, 0.1);
  all(pair_of_spheres({{.shape = sphere{R}, .at = {{0, 0, 0.02}}},
                       {.shape = sphere{R}, .at = {{0, 0, -0.02}}}}),
      0);
}

TEST_CASE("bodies that come down leaning bounce on seams as on one body") {
  struct fall {
    real turn, lean, speed, spin, friction;
  };
  const auto drop = [&](const auto& floor, const auto& shape, const fall& f, real half) {
    serial::link link;
    world<soft_scene> w(link);
    w.gravity({0, 0, -g});
    w.material({.density = 1000,
                .restitution = 0.3,
                .friction = f.friction,
                .stiffness = real(0.5) * 1e6 * 1000 * pi * R * R * 2 * half});
    floor(w);
    const quat q = rotation({0, 0, 1}, f.turn);
    const auto h = w.add(body{.shape = shape,
                              .position = {-0.075 * f.speed, 0.013, 1.02 * R + f.lean * half},
                              .velocity = q * vec3(f.speed, 0, 0),
                              .angular_velocity = q * vec3(0, f.spin * f.speed / R, 0),
                              .orientation = q * rotation({1, 0, 0}, pi / 2 - f.lean)});
    for (int k = 0; k < 1500; ++k) w.step(1e-4);
    return vec3(w[h].position());
  };
  auto floors = soft_floors();
  floors.push_back([](auto& w) { put_rectangle(w, -1, 1); });
  const auto all = [&](const auto& shape, real half) {
    for (const fall& f :
         {fall{0.97, 0.1, 1.9, 1, 0}, fall{0.5, 0.2, 0.8, 1, 0.7}, fall{-1.2, 0.05, 0.9, 1.5, 0.7},
          fall{1.1, 0.1, 0.1, 1, 0.8}, fall{0.04, 0.2, 0.5, -0.5, 0.4}}) {
      CAPTURE(f.turn);
      const vec3 there = drop(floors[0], shape, f, half);
      for (std::size_t k = 1; k < floors.size(); ++k) {
        CAPTURE(k);
        CHECK((drop(floors[k], shape, f, half) - there).norm() < 1e-6 * R);
      }
    }
  };
  all(capsule{R, 2.6 * R}, 1.3 * R);
  all(cylinder{R, 3 * R}, 1.5 * R);
}

TEST_CASE("a sphere that stays keeps its springs while a seam passes below it") {
  using belt_scene =
      scenario<bodies<sphere, box>,
               soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>,
               transport<serial>, features<driven>>;
  const auto roll = [](int tiles, bool moves) {
    serial::link link;
    world<belt_scene> w(link);
    w.gravity({0, 0, -g});
    w.material(resisting);
    for (int k = 0; k < tiles; ++k) {
      handle<box> tile;
      w.global([&](auto& scope) {
        tile = scope.add(body<box>{.shape = box{{2.0 / tiles, 2, 0.2}},
                                   .position = {(2 * k + 1.0) / tiles - 1, 0, -0.1}});
      });
      if (moves) w.drive(tile, gliding{{0.3, 0, 0}});
    }
    const real v = moves ? 0 : 0.5, spin = (v - (moves ? 0.3 : 0)) / R;
    const auto h = w.add(body{.shape = sphere{R},
                              .position = {moves ? 0.003 : -0.02, 0.002, R - 1e-5},
                              .velocity = {v, 0, 0},
                              .angular_velocity = {0, spin, 0}});
    // Steps that are shorter than the last one, too.
    for (int k = 0; k < (moves ? 300 : 1000); ++k) w.step(moves || k % 2 == 1 ? 1e-4 : 2e-5);
    return std::pair(vec3(w[h].position()), vec3(w[h].angular_velocity()));
  };
  for (const bool moves : {true, false}) {
    CAPTURE(moves);
    const auto [there, spin] = roll(1, moves);
    const auto [at, turns] = roll(2, moves);
    CHECK((at - there).norm() < 1e-9 * R);
    CHECK((turns - spin).norm() < 1e-9 * spin.norm());
  }
}

TEST_CASE("a box of soft contacts stands on flush bodies as on one body") {
  auto floors = soft_floors();
  floors.push_back([](auto& w) {
    for (const real x : {-0.5, 0.5})
      for (const real y : {-0.5, 0.5}) put_box(w, {1, 1, 0.2}, {x, y, -0.1});
  });
  floors.push_back([](auto& w) {
    for (int k = -10; k < 10; ++k) put_box(w, {0.02, 2, 0.2}, {0.02 * k + 0.01, 0, -0.1});
  });
  const auto stand = [](const auto& floor, const vec3& at, real turn, int steps) {
    serial::link link;
    world<soft_scene> w(link);
    w.gravity({0, 0, -g});
    w.material({.density = 1000, .restitution = 0.1, .friction = 0.5, .stiffness = stiffness});
    floor(w);
    const auto h = w.add(body{.shape = box{{0.1, 0.06, 0.04}},
                              .position = at + vec3(0, 0, 0.02 - 4e-6),
                              .orientation = rotation({0, 0, 1}, turn)});
    w.synchronize();
    const vec3 force = contact_force(w, h);
    for (int k = 0; k < steps; ++k) w.step(2e-5);
    return std::pair(force, vec3(w[h].position() - at));
  };
  for (const vec3& at :
       {vec3(0, 0, 0), vec3(0.05, 0.03, 0), vec3(0.013, 0, 0), vec3(0.049999, 1e-9, 0)})
    for (const real turn : {0.0, 0.3}) {
      CAPTURE(at[0]);
      CAPTURE(turn);
      const auto [right, rest] = stand(floors[0], at, turn, 1000);
      for (std::size_t k = 1; k < floors.size(); ++k) {
        CAPTURE(k);
        const auto [force, place] = stand(floors[k], at, turn, 1000);
        CHECK((force - right).norm() < 1e-6 * right.norm());
        CHECK((place - rest).norm() < 1e-9);
      }
    }
}
