#pragma once
/// \file
/// Closed forms of single bodies and chains of spheres with hard contacts: rolling, inclines,
/// rebounds, oblique impacts, Newton's cradle, the free asymmetric top.
#include <algorithm>
#include <cmath>
#include <string>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/plane.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "validation.hpp"

namespace validation {

namespace closed_form_cases {

using hard = talus::scenario<talus::bodies<talus::sphere, talus::box, talus::plane>,
                             talus::transport<talus::serial>>;
using world = talus::world<hard>;
inline constexpr double gravity = 9.81, dt = 1.0 / 240;

/// A plane through the origin that falls by `angle` along x.
inline void add_floor(world& w, double friction, double restitution = 0, double angle = 0) {
  w.material({.restitution = restitution, .friction = friction});
  w.gravity({0, 0, -gravity});
  w.global([&](auto& scope) {
    scope.add(talus::plane{.normal = {std::sin(angle), 0, std::cos(angle)}}, talus::material_id{});
  });
}

inline void sliding_to_rolling(report& out) {
  talus::serial::link link;
  world w(link);
  const double speed = 5, friction = 0.3, radius = 0.5;
  add_floor(w, friction);
  const auto ball = w.add(talus::body{
      .shape = talus::sphere{radius}, .position = {0, 0, radius}, .velocity = {speed, 0, 0}});
  double rolls = 0;
  for (int k = 1; k <= 240; ++k) {
    w.step(dt);
    if (w[ball].velocity()[0] - radius * w[ball].angular_velocity()[1] > 1e-9) rolls = k * dt;
  }
  const std::string source = "rigid body with Coulomb friction: 5/7 v, 2 v / (7 mu g)";
  out.push_back({"closed_forms/sliding to rolling", "final speed", "m/s", 5.0 / 7 * speed,
                 w[ball].velocity()[0], 1e-6, source});
  out.push_back({"closed_forms/sliding to rolling", "time of sliding", "s",
                 2 * speed / (7 * friction * gravity), rolls, dt, source});
}

/// Acceleration along an incline of a body that starts at rest.
template <class Shape>
double down_the_incline(const Shape& shape, double height, double friction, double angle) {
  talus::serial::link link;
  world w(link);
  add_floor(w, friction, 0, angle);
  const auto b =
      w.add(talus::body{.shape = shape,
                        .position = {height * std::sin(angle), 0, height * std::cos(angle)},
                        .orientation = talus::rotation({0, 1, 0}, angle)});
  for (int k = 0; k < 120; ++k) w.step(dt);
  const talus::vec3 before = w[b].velocity();
  for (int k = 0; k < 120; ++k) w.step(dt);
  return (w[b].velocity() - before).norm() / (120 * dt);
}

inline void inclines(report& out) {
  const double angle = talus::pi / 6, sine = std::sin(angle), cosine = std::cos(angle);
  const auto add = [&](const std::string& what, double expected, double found, double tolerance,
                       const std::string& source) {
    out.push_back({"closed_forms/incline of 30 degrees/" + what, "acceleration", "m/s^2", expected,
                   found, tolerance, source});
  };
  const talus::box block{{1, 1, 0.5}};
  add("box, friction 0.4", gravity * (sine - 0.4 * cosine),
      down_the_incline(block, 0.25, 0.4, angle), 1e-6, "Coulomb friction: g (sin - mu cos)");
  add("box, friction 0.6", 0, down_the_incline(block, 0.25, 0.6, angle), 1e-9,
      "Coulomb friction: at rest");
  add("sphere, friction 0.3", 5.0 / 7 * gravity * sine,
      down_the_incline(talus::sphere{0.5}, 0.5, 0.3, angle), 1e-6, "rolling: 5/7 g sin");
  add("sphere, friction 0.1", gravity * (sine - 0.1 * cosine),
      down_the_incline(talus::sphere{0.5}, 0.5, 0.1, angle), 1e-6, "sliding: g (sin - mu cos)");
}

inline void oblique_impacts(report& out, const effort& how) {
  const double e = 0.5, friction = 0.3, radius = 0.5, speed = 2;
  const double step = how.quick ? 30 : 10;
  for (double angle = 15; angle < 90; angle += step) {
    talus::serial::link link;
    world w(link);
    w.material({.restitution = e, .friction = friction});
    w.global([&](auto& scope) { scope.add(talus::plane{}, talus::material_id{}); });
    const double slip = speed * std::tan(angle * talus::pi / 180);
    const auto ball = w.add(talus::body{.shape = talus::sphere{radius},
                                        .position = {0, 0, radius + 0.01},
                                        .velocity = {slip, 0, -speed}});
    for (int k = 0; k < 20; ++k) w.step(dt);
    const bool slides = slip >= 3.5 * friction * (1 + e) * speed;
    out.push_back({"closed_forms/oblique impact/" + std::to_string(std::lround(angle)) + " degrees",
                   "tangential velocity", "m/s",
                   slides ? slip - friction * (1 + e) * speed : 5.0 / 7 * slip,
                   w[ball].velocity()[0], 1e-9, "impulse of a rigid sphere with Coulomb friction"});
  }
}

inline void cradle(report& out) {
  const double e = 0.9, radius = 0.5;
  talus::serial::link link;
  world w(link);
  w.material({.restitution = e});
  std::vector<talus::handle<talus::sphere>> balls;
  for (int k = 0; k < 5; ++k)
    balls.push_back(w.add(talus::body{.shape = talus::sphere{radius},
                                      .position = {1.1 * k, 0, 0},
                                      .velocity = {k == 0 ? 1.0 : 0, 0, 0}}));
  for (int k = 0; k < 400; ++k) w.step(dt);
  double momentum = 0;
  for (const auto& b : balls) momentum += w[b].velocity()[0];
  out.push_back({"closed_forms/cradle of five spheres", "speed of the last one", "m/s",
                 std::pow((1 + e) / 2, 4), w[balls.back()].velocity()[0], 1e-9,
                 "collisions one by one: ((1 + e) / 2)^(n - 1)"});
  out.push_back({"closed_forms/cradle of five spheres", "momentum over mass", "m/s", 1, momentum,
                 1e-12, "conservation"});
}

inline void bouncing_ball(report& out) {
  const double e = 0.8, radius = 0.5, step = 1.0 / 2000;
  talus::serial::link link;
  world w(link);
  add_floor(w, 0, e);
  const auto ball =
      w.add(talus::body{.shape = talus::sphere{radius}, .position = {0, 0, radius + 1}});
  double apex = 0;
  bool rebounded = false;
  for (int k = 0; k < 2000; ++k) {
    w.step(step);
    const double v = w[ball].velocity()[2];
    rebounded = rebounded || v > 0;
    if (rebounded) apex = std::max(apex, w[ball].position()[2] - radius);
    if (rebounded && v < 0) break;
  }
  out.push_back({"closed_forms/bouncing ball", "first apex", "m", e * e, apex, 0.01,
                 "rebound with restitution: h e^2"});
}

/// The asymmetric top without torque: the conserved quantities over 60 s, and its period.
inline void top(report& out, const effort& how) {
  talus::serial::link link;
  world w(link);
  w.material({});
  const talus::box shape{{1, 2, 0.3}};
  const talus::vec3 inertia = 0.6 * shape.inertia();
  const auto b =
      w.add(talus::body{.shape = shape, .position = {0, 0, 0}, .angular_velocity = {5, 5e-3, 0}});
  const auto own = [&] {
    return talus::vec3(w[b].orientation().conjugate() * w[b].angular_velocity());
  };
  const auto energy = [&](const talus::vec3& at) { return inertia.dot(at.cwiseProduct(at)); };
  const double before = energy(own());
  double worst = 0, time = 0;
  std::vector<double> flips;  // times at which the rotation about x changes its sign
  const double until = how.quick ? 30 : 60;
  double previous = own()[0];
  while (time < until) {
    w.step(dt);
    time += dt;
    const talus::vec3 now = own();
    worst = std::max(worst, std::abs(energy(now) / before - 1));
    if (now[0] * previous < 0) flips.push_back(time - dt * now[0] / (now[0] - previous));
    previous = now[0];
  }
  const std::string source = "Euler's equations in Jacobi's elliptic functions";
  out.push_back({"closed_forms/free asymmetric top", "period", "s", 9.298477344,
                 flips.size() > 2 ? flips[2] - flips[0] : 0, 9.3e-3, source});
  out.push_back({"closed_forms/free asymmetric top", "relative error of the energy", "1", 0, worst,
                 1e-6, source});
}

}  // namespace closed_form_cases

/// Rigid bodies with hard contacts.
inline void closed_forms(report& out, const effort& how) {
  using namespace closed_form_cases;
  sliding_to_rolling(out);
  inclines(out);
  oblique_impacts(out, how);
  cradle(out);
  bouncing_ball(out);
  top(out, how);
}

}  // namespace validation
