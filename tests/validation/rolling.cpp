// Euler's disk, a gyroscope on its tip and a ball on a turntable against their closed forms: with
// integrator<moreau_midpoint> errors are of second order in dt, with the default of first order.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/digest.hpp>
#include <talus/observe/monitors.hpp>
#include <talus/observe/motion.hpp>
#include <vector>

#include "record.hpp"
#include "track.hpp"

using namespace talus;
using namespace talus::validation;

namespace {

template <class Integrator>
using rolling =
    scenario<bodies<sphere, box, cylinder, convex_polyhedron, plane>, transport<threads>,
             decomposition<grid<dynamic, dynamic>>, integrator<Integrator>,
             solver<nonlinear_gauss_seidel>, features<driven, energy_ledger>>;

constexpr real g = 9.81, degree = pi / 180;
const vec3 up{0, 0, 1};

/// Errors after some time: of the energy (relative, the largest), of an angle (relative), of the
/// tilt (degrees, the largest), of the position (relative, the largest).
struct errors {
  real energy = 0, angle = 0, tilt = 0, place = 0;
};

template <class World>
void floor_of(World& w, real friction) {
  w.material({.friction = friction});
  w.gravity({0, 0, -g});
  w.global([&](auto& s) { s.add(plane{}, material_id{}); });
}

/// Follows the axis of a body around the vertical.
class axis_of_top {
 public:
  explicit axis_of_top(const vec3& start) : last_(flat(start)) {}
  void follow(const vec3& axis) {
    const vec3 now = flat(axis);
    angle_ += std::atan2(last_.cross(now)[2], last_.dot(now));
    last_ = now;
  }
  [[nodiscard]] real angle() const { return angle_; }

 private:
  static vec3 flat(const vec3& v) { return vec3(v[0], v[1], 0) / std::hypot(v[0], v[1]); }
  vec3 last_;
  real angle_ = 0;
};

/// A cylinder rolls on its rim around its centre, which stays: the steady motion of Euler's disk.
template <class Integrator>
errors disk(real dt, real time, int ranks) {
  const real tilt = 20 * degree;
  const cylinder shape{.radius = 0.5, .length = 0.05};
  const vec3 moments = shape.inertia(), x = vec3::UnitX();
  const vec3 down = std::cos(tilt) * x - std::sin(tilt) * up,
             axis = std::sin(tilt) * x + std::cos(tilt) * up,
             arm = shape.radius * down - (shape.length / 2) * axis;
  // It rotates about the arm: at rate 1 about the vertical, and also about its axis.
  const vec3 w = up + (1 / (std::sin(tilt) * arm[2] / arm[0] - std::cos(tilt))) * axis;
  const vec3 l = moments[0] * (w - w.dot(axis) * axis) + moments[2] * w.dot(axis) * axis;
  const real rate = std::sqrt(-g * arm[0] / l[0]);
  const auto way = follow<rolling<Integrator>>(
      ranks, dt, static_cast<std::size_t>(std::lround(time / dt)), [&](auto& world) {
        floor_of(world, 1);
        world.add_if_local(body{.shape = shape,
                                .position = {0, 0, -arm[2]},
                                .angular_velocity = vec3(rate * w),
                                .orientation = rotation(vec3::UnitY(), tilt)});
      })[0];
  const auto energy = [&](const moment& m) {
    const vec3 own = m.orientation.conjugate() * m.angular_velocity;
    return 0.5 * m.velocity.squaredNorm() + 0.5 * moments.dot(own.cwiseProduct(own)) +
           g * m.position[2];
  };
  errors e;
  axis_of_top top(axis);
  for (const moment& m : way) {
    const vec3 now = m.orientation * up;
    top.follow(now);
    e.energy = std::max(e.energy, std::abs(energy(m) / energy(way[0]) - 1));
    e.tilt = std::max(e.tilt, std::abs(std::acos(now[2]) - tilt) / degree);
  }
  e.angle = std::abs(top.angle() / (rate * time) - 1);
  return e;
}

/// A disk of twelve sides with a tip, which stands on the floor and sticks: Lagrange's top, in slow
/// steady precession.
template <class Integrator>
errors gyroscope(real dt, real time, int ranks) {
  const real tilt = 30 * degree, spin = 40;
  std::vector<vec3> corners{{0, 0, 0}};
  for (int k = 0; k < 24; ++k)
    corners.push_back({0.5 * std::cos(pi * (k / 2) / 6), 0.5 * std::sin(pi * (k / 2) / 6),
                       k % 2 == 0 ? 0.4 : 0.5});
  const convex_polyhedron shape(corners);
  const vec3 moments = shape.inertia();
  const vec3 tip = shape.frame().orientation.conjugate() * vec3(-shape.frame().position);
  const real length = tip.norm();
  const vec3 own_axis = -tip / length;
  const real about_axis = own_axis.dot(moments.cwiseProduct(own_axis)),
             across = (moments.sum() - about_axis) / 2 + length * length;
  const vec3 axis{std::sin(tilt), 0, std::cos(tilt)};
  const real c = std::cos(tilt), l = about_axis * spin;
  const real rate = (l - std::sqrt(l * l - 4 * across * c * g * length)) / (2 * across * c);
  const vec3 w = rate * up + (spin - rate * c) * axis;
  const quat start = rotation(own_axis.cross(axis), std::acos(own_axis.dot(axis)));
  const auto way = follow<rolling<Integrator>>(
      ranks, dt, static_cast<std::size_t>(std::lround(time / dt)), [&](auto& world) {
        floor_of(world, 2);
        world.add_if_local(body{.shape = shape,
                                .position = vec3(length * axis),
                                .velocity = w.cross(vec3(length * axis)),
                                .angular_velocity = w,
                                .orientation = start});
      })[0];
  const auto energy = [&](const moment& m) {
    const vec3 own = m.orientation.conjugate() * m.angular_velocity;
    return 0.5 * m.velocity.squaredNorm() + 0.5 * moments.dot(own.cwiseProduct(own)) +
           g * m.position[2];
  };
  errors e;
  axis_of_top top(axis);
  for (const moment& m : way) {
    const vec3 now = m.orientation * own_axis;
    top.follow(now);
    e.energy = std::max(e.energy, std::abs(energy(m) / energy(way[0]) - 1));
    e.tilt = std::max(e.tilt, std::abs(std::acos(now[2]) - tilt) / degree);
  }
  e.angle = std::abs(top.angle() / (rate * time) - 1);
  return e;
}

/// A ball that rolls on a turntable moves on a circle, at two sevenths of the table's rate.
template <class Integrator>
errors turntable(real dt, real time, int ranks) {
  const real rate = 2, radius = 0.5, q = rate * 2 / 7;
  const vec3 from{1, 0, radius}, v{0, 0.5, 0};
  const vec3 slip = rate * up.cross(vec3(from[0], from[1], 0)) - v;
  const auto way = follow<rolling<Integrator>>(
      ranks, dt, static_cast<std::size_t>(std::lround(time / dt)), [&](auto& world) {
        world.material({.friction = 1});
        world.gravity({0, 0, -g});
        handle<plane> table;
        world.global([&](auto& s) { table = s.add(plane{}, material_id{}); });
        world.drive(table, turning{.speed = rate});
        world.add_if_local(body{.shape = sphere{radius},
                                .position = from,
                                .velocity = v,
                                .angular_velocity = vec3(-up.cross(slip) / radius)});
      })[0];
  errors e;
  for (std::size_t k = 0; k < way.size(); ++k) {
    const real turn = q * dt * static_cast<real>(k);
    const vec3 there = from + (std::sin(turn) * v + (1 - std::cos(turn)) * up.cross(v)) / q;
    e.place = std::max(e.place, (way[k].position - there).norm() * q / v.norm());
  }
  return e;
}

real order(real coarse, real fine) { return std::log2(coarse / fine); }

}  // namespace

TEST_CASE("Euler's disk keeps its energy and its tilt to second order in dt with the midpoint") {
  for (const int ranks : {1, 4}) {
    const std::string test = fmt::format("Euler's disk, midpoint, {} rank(s)", ranks);
    const errors fine = disk<moreau_midpoint>(1. / 480, 2, ranks);
    check_error(test, "energy in 2 s, dt = 1/480", fine.energy, 5e-5);
    check_error(test, "precession", fine.angle, 1e-4);
    check_error(test, "tilt (degrees)", fine.tilt, 0.01);
    if (ranks > 1) continue;
    const errors coarse = disk<moreau_midpoint>(1. / 240, 2, ranks);
    check_error(test, "energy in 2 s, dt = 1/240", coarse.energy, 2e-4);
    check_at_least(test, "order of the energy", 1.8, order(coarse.energy, fine.energy));
  }
  // The default scheme is of first order; the other one improves on that.
  const errors coarse = disk<semi_implicit_euler>(1. / 240, 2, 1),
               fine = disk<semi_implicit_euler>(1. / 480, 2, 1);
  MESSAGE("semi-implicit Euler: energy ", coarse.energy, ", at half the step ", fine.energy);
  CHECK(order(coarse.energy, fine.energy) < 1.2);
}

TEST_CASE("a gyroscope on its tip precesses at the right rate and tilt to second order in dt") {
  for (const int ranks : {1, 4}) {
    const std::string test = fmt::format("gyroscope on its tip, midpoint, {} rank(s)", ranks);
    const errors fine = gyroscope<moreau_midpoint>(1. / 480, 2, ranks);
    check_error(test, "energy in 2 s, dt = 1/480", fine.energy, 1e-6);
    check_error(test, "precession", fine.angle, 2e-4);
    check_error(test, "tilt (degrees)", fine.tilt, 0.006);
    if (ranks > 1) continue;
    const errors coarse = gyroscope<moreau_midpoint>(1. / 240, 2, ranks);
    check_error(test, "precession, dt = 1/240", coarse.angle, 8e-4);
    check_error(test, "tilt (degrees), dt = 1/240", coarse.tilt, 0.024);
    check_at_least(test, "order of the precession", 1.8, order(coarse.angle, fine.angle));
    check_at_least(test, "order of the tilt", 1.8, order(coarse.tilt, fine.tilt));
  }
}

TEST_CASE("a ball on a turntable goes round its circle to second order in dt with the midpoint") {
  for (const int ranks : {1, 4}) {
    const std::string test = fmt::format("ball on a turntable, midpoint, {} rank(s)", ranks);
    const errors fine = turntable<moreau_midpoint>(1. / 240, 20, ranks);
    check_error(test, "place in 20 s over the radius, dt = 1/240", fine.place, 3e-5);
    if (ranks > 1) continue;
    const errors coarse = turntable<moreau_midpoint>(1. / 120, 20, ranks);
    check_at_least(test, "order of the place", 1.8, order(coarse.place, fine.place));
  }
}

TEST_CASE("with the midpoint a ball that bounces, at restitution 1, keeps its height") {
  const auto way = follow<rolling<moreau_midpoint>>(1, 1. / 240, 2400, [](auto& w) {
    w.material({.restitution = 1});
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{}, material_id{}); });
    w.add_if_local(body{.shape = sphere{0.5}, .position = {0.1, 0.1, 1.5}});
  })[0];
  real highest = 0;  // of the last two seconds, after 10 bounces and more
  for (std::size_t k = 1920; k < way.size(); ++k) highest = std::max(highest, way[k].position[2]);
  check_error("bouncing ball, midpoint", "height after 8 s", highest - 1.5, 1e-3);
  const auto dead = follow<rolling<moreau_midpoint>>(1, 1. / 240, 480, [](auto& w) {
    w.material({.friction = 0.5});
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{}, material_id{}); });
    w.add_if_local(body{.shape = box{{1, 0.8, 0.6}},
                        .position = {0.1, 0.1, 1.5},
                        .angular_velocity = {1, 2, 0.5},
                        .orientation = rotation({1, 2, 3}, 0.5)});
  })[0];
  CHECK(dead.back().velocity.norm() < 1e-6);
  CHECK(dead.back().angular_velocity.norm() < 1e-6);
}

TEST_CASE("with the midpoint a heap comes to rest on 1 and 4 ranks, and its ledger closes") {
  // Spheres roll on in most heaps that have them, with either integrator, for nothing resists.
  struct heap {
    bool spheres;
    int ranks;
  };
  for (const auto [spheres, ranks] : {heap{false, 1}, heap{false, 4}, heap{true, 4}}) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<rolling<moreau_midpoint>> w(link);
      w.material({.restitution = 0.2, .friction = 0.5});
      w.gravity({0, 0, -g});
      w.global([&](auto& s) {
        s.add(plane{}, material_id{});
        for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
          s.add(plane{.normal = n, .offset = -1.7}, material_id{});
      });
      random_stream random(13);
      for (int k = 0; k < 27; ++k) {
        const vec3 at = vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 + 0.6) +
                        random.uniform(vec3(-.05, -.05, 0), vec3(.05, .05, 0));
        if (spheres && k % 2 == 0)
          w.add_if_local(body{.shape = sphere{0.45}, .position = at});
        else
          w.add_if_local(body{
              .shape = box{{0.6, 0.5, 0.4}}, .position = at, .orientation = random.rotation()});
      }
      for (int k = 0; k < 1920; ++k) w.step(1. / 240);
      const auto energy = measure_energy(w);
      const auto motion = measure_motion(w);
      if (link.rank() != 0) return;
      const std::string test = fmt::format("heap of 27 bodies{}, midpoint, {} rank(s)",
                                           spheres ? ", 14 of them spheres" : "", ranks);
      check_error(test, "energy that the ledger leaves open", energy.worst, 1e-11);
      check_error(test, "energy that the time stepping adds, over all",
                  energy.total.scheme / energy.initial, 1e-9);
      if (!spheres) check_error(test, "largest speed after 8 s", motion.max_speed, 1e-6);
    });
  }
}
