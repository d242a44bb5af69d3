// Pyramids, walls and towers of many rows at 60 steps per second and the default settings: they
// stand from the first step on, because the bodies are balanced from the top down.
#include <doctest/doctest.h>

#include "stacks.hpp"

using namespace talus;
using namespace talus::hard;

namespace {

constexpr real dt = 1.0 / 60;

/// At rest, and exactly where they started.
void check_rests(const std::string& name, const outcome& o) {
  CHECK(o.finite);
  check_error(name, "furthest from the start at any time", o.furthest(), 1e-6);
  check_error(name, "fastest at any time", o.fastest(), 1e-5);
  check_error(name, "deepest overlap at any time, over the mean radius", o.deepest, 1e-6);
}

}  // namespace

TEST_CASE("a pyramid of 30 rows stands") {
  check_rests("pyramid of 30", run<blocks>(whole, dt, 60 * 4, [](auto& w) { pyramid(w, 30); }));
}

TEST_CASE("small pyramids stand anywhere, turned, at any friction and time step") {
  constexpr std::uint64_t seed = 5;
  random_stream random(seed, 1);
  CAPTURE(seed);
  for (const int rows : {5, 10})
    for (const real gap : {0.0, 0.01})
      for (const real friction : {0.3, 0.5})
        for (const real step : {1.0 / 60, 1.0 / 240})
          for (const real far : {1.0, 100.0}) {
            const vec3 middle = far * random.uniform(vec3(-1, -1, 0), vec3(1, 1, 0));
            const quat turn = rotation(vec3(0, 0, 1), random.uniform() * pi);
            const auto o = run<blocks>(whole, step, 60, [&](auto& w) {
              floor_at(w, {}, friction);
              for (int row = 0; row < rows; ++row)
                for (int k = 0; k < rows - row; ++k)
                  w.add(body{.shape = box{{1, 1, 1}},
                             .position = middle + vec3(0, 0, row + 0.5) +
                                         turn * vec3((1 + gap) * (k + 0.5 * row), 0, 0),
                             .orientation = turn});
            });
            CAPTURE(rows);
            CAPTURE(gap);
            CAPTURE(friction);
            CAPTURE(step);
            CAPTURE(far);
            CHECK(o.furthest() < 1e-9);
          }
}

TEST_CASE("a pyramid of 40 rows whose boxes are out of line stands") {
  const auto o = run<blocks>(whole, dt, 60 * 4, [](auto& w) {
    floor_at(w, {}, 0.6);
    random_stream random(3, 1);
    for (int row = 0; row < 40; ++row)
      for (int k = 0; k < 40 - row; ++k)
        w.add(body{.shape = box{{1, 1, 1}},
                   .position = vec3(k + 0.5 * row - 20, 0, row + 0.5) +
                               0.003 * random.uniform(vec3(-1, -1, 0), vec3(1, 1, 0))});
  });
  // The sides of the boxes overlap by up to 6 mm at the start; that is corrected.
  check_error("pyramid of 40 out of line", "furthest from the start", o.furthest(), 6e-3);
}

TEST_CASE("a pyramid of 40 rows with gaps of 2 mm closes them and stands") {
  for (const real side : {0.0, 0.01}) {  // between the boxes of a row
    const auto o = run<blocks>(whole, dt, 60 * 5, [&](auto& w) {
      floor_at(w, {}, 0.6);
      for (int row = 0; row < 40; ++row)
        for (int k = 0; k < 40 - row; ++k)
          w.add(body{
              .shape = box{{1, 1, 1}},
              .position = {(1 + side) * (k + 0.5 * row - 20), 0, row + 0.5 + 0.002 * (row + 1)}});
    });
    check_error("pyramid of 40 with gaps", "furthest from the start", o.furthest() - 0.08, 1e-3);
  }
}

TEST_CASE("a wall of 30 rows stands") {
  check_rests("wall of 30", run<blocks>(whole, dt, 60 * 2, [](auto& w) { wall(w, 30, 20); }));
}

TEST_CASE("a tower of 60 boxes stands") {
  const auto o = run<blocks>(whole, dt, 60 * 5, [](auto& w) { stack(w, 60); });
  check_error("tower of 60", "furthest from the start at any time", o.furthest(), 1e-3);
}

TEST_CASE("a heavy box stands on a pyramid of 30 rows") {
  const auto o = run<blocks>(whole, dt, 60 * 4, [](auto& w) {
    pyramid(w, 30);
    const auto lead = w.material({.density = 100, .friction = 0.6});
    w.add(body{.shape = box{{1, 1, 1}}, .position = {-0.5, 0, 30.5}, .material = lead});
  });
  check_error("heavy box on a pyramid", "furthest from the start at any time", o.furthest(), 1e-3);
}

TEST_CASE("a pyramid on a moving platform moves with it") {
  // Bodies rest on each other at the velocity of what is below.
  constexpr real v = 3;
  const auto o = run<blocks>(whole, dt, 60, [](auto& w) {
    const auto smooth = w.material({}), rough = w.material({.friction = 0.6});
    w.material_pair(smooth, rough, {.friction = 0, .dynamic_friction = 0});
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{.normal = {0, 0, 1}, .offset = 0}, smooth); });
    w.add(body{.shape = box{{60, 4, 1}},
               .position = {0, 0, 0.5},
               .material = rough,
               .velocity = {v, 0, 0}});
    for (int row = 0; row < 25; ++row)
      for (int k = 0; k < 25 - row; ++k)
        w.add(body{.shape = box{{1, 1, 1}},
                   .position = {k + 0.5 * row - 12.5, 0, row + 1.5},
                   .material = rough,
                   .velocity = {v, 0, 0}});
  });
  for (const way& b : o.bodies) {
    CHECK((b.end.position - b.start.position - vec3(v, 0, 0)).norm() < 1e-5);
    CHECK((b.velocity - vec3(v, 0, 0)).norm() < 1e-5);
  }
}
