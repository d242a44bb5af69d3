// Difficult input for engines: bodies created in each other, coincident centres, parallel edges and
// faces, coefficients at their limits, long steps, thin plates, large ratios of size. All must end
// finite, bounded and correct, on one rank and on four, at the default settings.
// long
#include <doctest/doctest.h>

#include "../validation/record.hpp"
#include "ranks.hpp"

using namespace talus;
using namespace talus::hard;
using namespace talus::validation;

namespace {

constexpr real g = 9.81, dt = 1.0 / 240;
using mixed = scene<sphere, box, plane>;
using world_of_mixed = world<mixed>;

const cuts whole{.cells = {1, 1, 1}};
const cuts quarters{.cells = {2, 2, 1}};  // meeting at x = y = 0

quat about(const vec3& axis, real angle) { return rotation(axis, angle); }

/// Calls f(domains, label) for one rank and for four.
template <class F>
void on_one_and_four(F&& f) {
  f(whole, std::string(", 1 rank"));
  f(quarters, std::string(", 4 ranks"));
}
template <class World>
material_id on_floor(World& w, const material& m, real gravity = g) {
  const auto id = w.material(m);
  w.gravity({0, 0, -gravity});
  w.global([&](auto& s) { s.add(plane{}, id); });
  return id;
}
/// Largest residual momentum over the scale of the bodies' momentum at their fastest.
void check_sound(const std::string& name, const outcome& o, std::size_t bodies) {
  CHECK_MESSAGE(o.finite, name);
  CHECK_MESSAGE(o.bodies.size() == bodies, name);
}

}  // namespace

TEST_CASE("bodies created deep in each other part without an explosion") {
  on_one_and_four([](const cuts& domains, const std::string& ranks) {
    for (const real gravity : {0.0, g}) {
      // 27 boxes and 27 spheres, each overlapping its neighbours by half of its size.
      const auto o = run<mixed>(
          domains, dt, 240 * 4,
          [&](world_of_mixed& w) {
            const auto m = w.material({.restitution = 0.5, .friction = 0.5});
            w.gravity({0, 0, -gravity});
            if (gravity > 0) w.global([&](auto& s) { s.add(plane{}, m); });
            for (int k = 0; k < 54; ++k) {
              const vec3 at =
                  0.5 * vec3(k % 3 - 1, k / 3 % 3 - 1, 1 + k / 9 % 3) + vec3(0, 0, k / 27 * 2);
              if (k < 27)
                w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = at, .material = m});
              else
                w.add_if_local(body{.shape = sphere{0.5}, .position = at, .material = m});
            }
          },
          1);
      const std::string name =
          (gravity > 0 ? "deep overlap, on a floor" : "deep overlap, free") + ranks;
      check_sound(name, o, 54);
      // (On the floor the heap rises to less than 6, and falls.)
      check_error(name, "fastest point of a body at any time", o.fastest(),
                  gravity > 0 ? 1.5 * std::sqrt(2 * g * 6) : 1e-12);
      check_error(name, "overlap left, over the mean radius", o.overlap.max, 1e-3);
    }
  });
}

TEST_CASE(
    "a sphere and a box that touch walls, floors and each other in parallel feel only what "
    "presses") {
  on_one_and_four([](const cuts& domains, const std::string& ranks) {
    // A sphere whose diameter is the gap of two walls, one of planes and one of fixed boxes, and a
    // box flush with a wall and with another box that falls beside it: without normal forces, all
    // of them fall as if they were alone.
    const int steps = 200;
    const real fall = -g * dt * dt * steps * (steps + 1) / 2;
    const auto o = run<mixed>(domains, dt, steps, [&](world_of_mixed& w) {
      const auto m = w.material({.restitution = 0.5, .friction = 0.7});
      w.gravity({0, 0, -g});
      w.global([&](auto& s) {
        s.add(plane{.normal = {1, 0, 0}, .offset = -0.5}, m);
        s.add(plane{.normal = {-1, 0, 0}, .offset = -0.5}, m);
        s.add(box{{1, 4, 40}}, m, vec3(0, 12.5, 0));
      });
      w.add_if_local(body{.shape = sphere{0.5}, .position = {0, 0, 0}, .material = m});
      w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {0, 10, 0}, .material = m});
      w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {0, -4, 0}, .material = m});
      w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {0, -5, 0.3}, .material = m});
      w.add_if_local(body{.shape = box{{0.5, 1, 1}}, .position = {-0.25, -10, 0}, .material = m});
      w.add_if_local(body{.shape = box{{0.5, 1, 1}}, .position = {0.25, -11, 1}, .material = m});
    });
    const std::string name = "falling in a gap of exactly its size" + ranks;
    check_sound(name, o, 6);
    real error = 0;
    for (const way& b : o.bodies)
      error = std::max(error, (b.end.position - b.start.position - vec3(0, 0, fall)).norm());
    check_error(name, "from a free fall, lengths", error, 1e-9);
  });
}

TEST_CASE("coefficients at their limits: mu = 0, mu = 2, restitution 1") {
  on_one_and_four([](const cuts& domains, const std::string& ranks) {
    // A flat box on a plane of 60 degrees: tan = 1.73.
    for (const real mu : {0.0, 2.0}) {
      const real angle = pi / 3;
      const vec3 up{std::sin(angle), 0, std::cos(angle)},
          along{std::cos(angle), 0, -std::sin(angle)};
      const auto o = run<mixed>(domains, dt, 240, [&](world_of_mixed& w) {
        const auto m = w.material({.friction = mu});
        w.gravity({0, 0, -g});
        w.global([&](auto& s) { s.add(plane{.normal = up}, m); });
        w.add_if_local(body{.shape = box{{2, 2, 0.5}},
                            .position = 0.25 * up,
                            .material = m,
                            .orientation = about(vec3::UnitY(), angle)});
        w.add_if_local(
            body{.shape = sphere{0.5}, .position = 0.5 * up + vec3(0, 4, 0), .material = m});
      });
      const std::string name = "60 degrees, mu " + std::to_string(mu) + ranks;
      check_sound(name, o, 2);
      const real a = g * std::sin(angle);
      check_absolute(name, "speed of the box after 1 s", mu == 0 ? a : 0,
                     along.dot(o.bodies[0].velocity), 1e-9);
      check_absolute(name, "speed of the sphere after 1 s", mu == 0 ? a : a / 1.4,
                     along.dot(o.bodies[1].velocity), 1e-9);
    }
    // Spheres in a box of planes without loss: their energy does not grow. (If a sphere meets
    // several others in one step, some of it is lost.)
    const auto o = run<mixed>(
        domains, dt, 480,
        [&](world_of_mixed& w) {
          const auto m = w.material({.restitution = 1, .friction = 0});
          w.global([&](auto& s) {
            for (int axis = 0; axis < 3; ++axis)
              for (const real side : {-1.0, 1.0})
                s.add(plane{.normal = side * vec3::Unit(axis), .offset = -3}, m);
          });
          for (int k = 0; k < 27; ++k) {
            const vec3 at = 1.6 * vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
            const vec3 v{std::sin(3 * k + 1), std::sin(5 * k + 2), std::sin(7 * k + 3)};
            w.add_if_local(
                body{.shape = sphere{0.5}, .position = at, .material = m, .velocity = 2 * v});
          }
        },
        20);
    const std::string name = "restitution 1, mu 0" + ranks;
    check_sound(name, o, 27);
    check_absolute(name, "kinetic energy over the first", 1,
                   o.after.kinetic_energy / o.before.kinetic_energy, 0.05);
    check_error(name, "energy gained at any time", o.highest_energy / o.before.kinetic_energy - 1,
                1e-9);
  });
}

TEST_CASE("a step ten times too long: stacks stand, and what falls stays above the floor") {
  on_one_and_four([](const cuts& domains, const std::string& ranks) {
    const auto o = run<mixed>(
        domains, 10 * dt, 24 * 10,
        [&](world_of_mixed& w) {
          on_floor(w, {.restitution = 0.3, .friction = 0.5});
          for (int k = 0; k < 5; ++k)
            w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {0, 0, k + 0.5}});
          for (int k = 0; k < 27; ++k)
            w.add_if_local(body{.shape = sphere{0.4},
                                .position = vec3(4, 0, 2) + 1.0 * vec3(k % 3 - 1 + 0.01 * (k % 5),
                                                                       k / 3 % 3 - 1, k / 9)});
          w.add_if_local(body{.shape = box{{1, 0.8, 0.6}},
                              .position = {-3, 0, 20},
                              .orientation = about(vec3(1, 2, 3).normalized(), 1)});
        },
        20);
    const std::string name = "dt = 1/24" + ranks;
    check_sound(name, o, 33);
    real drift = 0, lowest = 1;
    for (std::size_t k = 0; k < 5; ++k)
      drift = std::max(drift, (o.bodies[k].end.position - o.bodies[k].start.position).norm());
    for (const way& b : o.bodies) lowest = std::min(lowest, b.end.position[2]);
    check_error(name, "drift of the stack in 10 s", drift, 2e-2);
    check_at_least(name, "lowest centre", 0.29, lowest);
    check_error(name, "fastest point at any time over sqrt(2 g h)",
                o.fastest() / std::sqrt(2 * g * 20), 1.5);
    check_error(name, "overlap at the end, over the mean radius", o.overlap.max, 5e-3);
    check_error(name, "energy gained at any time, over the first",
                o.highest_energy / o.before.potential_energy - 1, 1e-3);
  });
}

TEST_CASE("plates and needles of 1,000 : 1 come to rest and lie flat, in stacks too") {
  on_one_and_four([](const cuts& domains, const std::string& ranks) {
    const vec3 plate{1, 1, 1e-3}, needle{1, 1e-3, 1e-3};
    const auto o = run<mixed>(
        domains, dt, 240 * 4,
        [&](world_of_mixed& w) {
          on_floor(w, {.friction = 0.5});
          for (int k = 0; k < 10; ++k)
            w.add_if_local(body{.shape = box{plate},
                                .position = {0.01 * (k % 3), 0, (k + 0.5) * plate[2]},
                                .orientation = about(vec3::UnitZ(), 0.1 * k)});
          w.add_if_local(body{.shape = box{plate},
                              .position = {3, 0, 0.3},
                              .orientation = about(vec3::UnitY(), 0.3)});
          w.add_if_local(body{.shape = box{needle}, .position = {0, 3, 0.0005}});
          w.add_if_local(body{.shape = box{needle},
                              .position = {0, -3, 0.4},
                              .orientation = about(vec3(1, 2, 0.5).normalized(), 0.7)});
          w.add_if_local(body{.shape = box{needle}, .position = {0, 0.0003, 0.2}});
        },
        20);
    const std::string name = "1,000 : 1" + ranks;
    check_sound(name, o, 14);
    real drift = 0, tilt = 0, high = 0;
    for (std::size_t k = 0; k < 14; ++k) {
      const way& b = o.bodies[k];
      if (k < 10) drift = std::max(drift, (b.end.position - b.start.position).norm());
      const vec3 flat = b.end.orientation * (k < 11 ? vec3(0, 0, 1) : vec3(1, 0, 0));
      tilt = std::max(tilt, k < 11 ? std::hypot(flat[0], flat[1]) : std::abs(flat[2]));
      if (k < 13) high = std::max(high, b.end.position[2] - (k < 10 ? k + 0.5 : 0.5) * plate[2]);
    }
    check_error(name, "drift of the stack of ten plates", drift, 1e-2);
    check_error(name, "largest tilt at the end", tilt, 1e-2);
    check_error(name, "height at rest above where it should be, lengths", high, 1e-4);
    check_error(name, "fastest point at any time over sqrt(2 g h)",
                o.fastest() / std::sqrt(2 * g * 0.4), 3);
    check_error(name, "kinetic energy at the end over m g h",
                o.after.kinetic_energy / (o.mass() * g * 0.4), 1e-6);
  });
}

TEST_CASE("size ratio 1 : 100: small bodies on, beside and under large ones") {
  on_one_and_four([](const cuts& domains, const std::string& ranks) {
    const auto o = run<mixed>(
        domains, dt, 240 * 3,
        [&](world_of_mixed& w) {
          on_floor(w, {.restitution = 0.2, .friction = 0.5});
          w.add_if_local(body{.shape = sphere{50}, .position = {70, 0, 50}});
          w.add_if_local(body{.shape = box{{100, 100, 100}}, .position = {-60, 0, 50}});
          for (int k = 0; k < 27; ++k)
            w.add_if_local(body{.shape = box{{1, 1, 1}},
                                .position = {-60.0 + k / 3 % 3, 0.0 + k / 9, 100.5 + k % 3}});
          for (int k = 0; k < 30; ++k)
            w.add_if_local(body{.shape = sphere{0.5},
                                .position = {70 + 1.1 * (k % 6 - 2.5), 1.1 * (k / 6 - 2), 101.0}});
        },
        20);
    const std::string name = "size ratio 1 : 100" + ranks;
    check_sound(name, o, 59);
    real sunk = 0, moved = 0, drift = 0;
    for (std::size_t k = 29; k < 59; ++k) {
      const way& b = o.bodies[k];
      const real from_centre = (b.end.position - o.bodies[0].end.position).norm();
      sunk = std::max({sunk, 50.5 - from_centre, 0.5 - b.end.position[2]});
    }
    for (std::size_t k = 0; k < 2; ++k) moved = std::max(moved, o.bodies[k].furthest);
    for (std::size_t k = 2; k < 29; ++k) drift = std::max(drift, o.bodies[k].furthest);
    check_error(name, "small spheres sunk into large ones, over their radius",
                std::max(0.0, sunk) / 0.5, 1e-2);
    check_error(name, "small boxes on the large one moved, over their size", drift, 1e-2);
    check_error(name, "large bodies moved, over their size", moved / 100, 1e-3);
    check_error(name, "fastest small sphere over sqrt(2 g h)", o.fastest() / std::sqrt(2 * g * 101),
                1.5);
  });
}
