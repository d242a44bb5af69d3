// With the midpoint, bodies are followed to their impacts, and fly on with their true velocities.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <talus/core/random.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using followed =
    scenario<bodies<sphere, box, plane>, integrator<moreau_midpoint>, transport<serial>,
             features<continuous_collision, damping, driven, energy_ledger, momentum_balance>>;
constexpr real g = 9.81;

struct course {
  serial::link link;
  world<followed> w{link};

  explicit course(real restitution, real gravity = 0) {
    w.material({.restitution = restitution, .friction = 0});
    w.gravity({0, 0, -gravity});
  }
  template <class Shape>
  handle<Shape> global(const Shape& shape, const vec3& at = {0, 0, 0}) {
    handle<Shape> h;
    w.global([&](auto& s) { h = s.add(shape, material_id{}, at); });
    return h;
  }
  handle<sphere> ball(const vec3& at, const vec3& v, real radius = 1) {
    return w.add(body{.shape = sphere{radius}, .position = at, .velocity = v});
  }
  [[nodiscard]] bool closes() {
    return measure_energy(w).worst < 1e-12 && measure_momentum(w).error() < 1e-11;
  }
};

/// The height to which a ball rises at last.
real apex(const vec3& at, const vec3& v) { return at[2] + v[2] * v[2] / (2 * g); }

}  // namespace

TEST_CASE("a ball that bounces without loss keeps its energy to round-off, however fast") {
  for (const real dt : {1.0 / 240, 1.0 / 60})
    for (const real speed : {0, 10, 100}) {
      CAPTURE(dt);
      CAPTURE(speed);
      course c(1, g);
      c.global(plane{});
      const auto h = c.ball({0, 0, 3}, {0.3 * speed, 0, -speed}, 0.5);
      const auto energy = [&] {
        return 0.5 * c.w[h].velocity().squaredNorm() + g * c.w[h].position()[2];
      };
      const real first = energy();
      real worst = 0, lowest = 1;
      for (int k = 0; k < 4000; ++k) {
        c.w.step(dt);
        worst = std::max(worst, std::abs(energy() / first - 1));
        lowest = std::min(lowest, c.w[h].position()[2]);
      }
      CHECK(worst < 1e-12);
      CHECK(lowest >= 0.5);
      CHECK(c.closes());
    }
}

TEST_CASE("a ball that falls rises to e^2 of its height to 1e-6, and damping takes the rest") {
  for (const real dt : {1.0 / 240, 1.0 / 60})
    for (const real e : {0.0, 0.5, 0.9}) {
      CAPTURE(dt);
      CAPTURE(e);
      course c(e, g);
      c.global(plane{});
      const auto h = c.ball({0, 0, 21}, {0, 0, 0});
      real lowest = 21;
      for (int k = 0; k < 600 && !(e > 0 && c.w[h].velocity()[2] > 0); ++k) {
        c.w.step(dt);
        lowest = std::min(lowest, c.w[h].position()[2]);
      }
      for (int k = 0; e == 0 && k < 500; ++k) c.w.step(dt);
      CHECK(std::abs((apex(c.w[h].position(), c.w[h].velocity()) - 1) / 20 - e * e) < 1e-6);
      CHECK(lowest > 1 - 0.25 * g * dt * dt);
      CHECK(c.closes());
    }
  course c(1, g);
  c.w.damping(0.5);
  c.global(plane{});
  const auto h = c.ball({0, 0, 3}, {0, 0, -50}, 0.5);
  real last = 1e9;
  for (int k = 0; k < 500; ++k) {
    c.w.step(1.0 / 60);
    const real now = 0.5 * c.w[h].velocity().squaredNorm() + g * (c.w[h].position()[2] - 0.5);
    CHECK(now < last + 1e-12);
    last = now;
  }
  CHECK(last < 100);
  CHECK(c.closes());
}

TEST_CASE("with the midpoint a bullet of any speed rebounds from a thin wall with -e v") {
  constexpr real dt = 1.0 / 240;
  for (int k = 0; k < 40; ++k)
    for (const real e : {0.0, 0.5, 1.0}) {
      const real speed = 0.7 * std::pow(1.4, k);
      CAPTURE(speed);
      CAPTURE(e);
      course c(e);
      c.global(box{{0.01, 1e7, 1e7}});
      const auto h = c.ball({-1.2 - std::fmod(0.37 * k, 1.0) * 3 * speed * dt, 0, 0},
                            {speed, 0.1 * speed, 0}, 1);
      real furthest = -1e9;
      for (int n = 0; n < 90; ++n) {
        c.w.step(dt);
        furthest = std::max(furthest, c.w[h].position()[0]);
      }
      CHECK(furthest < -1.005 + 2e-6);
      // Without rebound it closes the gap that counts as a touch.
      CHECK(std::abs(c.w[h].velocity()[0] / speed + e) < 1e-6 + 3e-4 / speed);
      CHECK(c.closes());
    }
}

TEST_CASE("with the midpoint a driven wall strikes a ball where that is, with its velocity") {
  constexpr real dt = 1.0 / 240;
  for (const real wall : {-40 / dt, 40 / dt, 90 / dt}) {
    CAPTURE(wall);
    course c(1);
    const auto h = c.global(box{{0.01, 50, 50}});
    c.w.drive(h, [=](real) { return rigid_velocity{.velocity = {wall, 0, 0}}; });
    const auto bullet = c.ball({-130, 0, 0}, {100 / dt, 0, 0});
    for (int k = 0; k < 20; ++k) {
      c.w.step(dt);
      CHECK(c.w[bullet].position()[0] + 1.005 < c.w[h].position()[0] + 1e-6);
    }
    CHECK(c.w[bullet].velocity()[0] * dt == doctest::Approx(2 * wall * dt - 100).epsilon(1e-9));
  }
  for (const real e : {0.0, 1.0}) {  // and carries it along
    CAPTURE(e);
    course c(e);
    const auto h = c.global(box{{0.01, 50, 50}});
    const real speed = 20 / dt;
    c.w.drive(h, [=](real) { return rigid_velocity{.velocity = {speed, 0, 0}}; });
    const auto rests = c.ball({11, 0.2, 0}, {0, 0, 0});
    for (int k = 0; k < 60; ++k) {
      c.w.step(dt);
      CHECK(c.w[rests].position()[0] - 1.005 > c.w[h].position()[0] - 1e-6);
    }
    CHECK(c.w[rests].velocity()[0] == doctest::Approx((1 + e) * speed).epsilon(1e-6));
  }
}

TEST_CASE("with the midpoint followed bodies have the same bits on any ranks") {
  using alike =
      scenario<bodies<sphere, box, plane>, integrator<moreau_midpoint>, solver<reproducible>,
               transport<threads>, decomposition<grid<dynamic, dynamic>>,
               features<continuous_collision, damping>>;
  for (const real kept : {1.0, 0.6}) {
    std::string first;
    for (const int ranks : {1, 2, 4}) {
      CAPTURE(kept);
      CAPTURE(ranks);
      std::string digest;
      threads::launch({.ranks = ranks}, [&](threads::link& link) {
        world<alike> w(link);
        w.decompose({.lower = {-2, -2}, .upper = {2, 2}}, {.distance = 8});
        w.gravity({0, 0, -g});
        w.damping(kept);
        const auto stuff = w.material({.restitution = 0.3, .friction = 0.5});
        w.global([&](auto& scope) { scope.add(plane{}, stuff); });
        random_stream random(3);
        for (int k = 0; k < 48; ++k) {
          const vec3 at = 0.8 * vec3(k % 4 - 1.5, k / 4 % 4 - 1.5, k / 16 + 0.8) +
                          random.uniform(vec3(-.1, -.1, -.1), vec3(.1, .1, .1));
          const vec3 v = random.uniform(vec3(-20, -20, -30), vec3(20, 20, 0));
          const quat turn = random.rotation();
          if (k % 2 == 0)
            w.add_if_local(
                body{.shape = sphere{0.25}, .position = at, .material = stuff, .velocity = v});
          else
            w.add_if_local(body{.shape = box{{0.5, 0.4, 0.3}},
                                .position = at,
                                .material = stuff,
                                .velocity = v,
                                .orientation = turn});
        }
        for (int k = 0; k < 120; ++k) w.step(1.0 / 240);
        const std::string of_all = state_digest(w);
        if (link.rank() == 0) digest = of_all;
      });
      if (first.empty()) first = digest;
      CHECK(digest == first);
    }
  }
}
