// Painleve's rod against its closed form; the floor bears the weight of resting bodies; boxes on
// inclines across ranks; extreme coefficients. On 1 rank, and on 4 that meet in the scene.
// long
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <vector>

#include "record.hpp"
#include "track.hpp"

using namespace talus;
using namespace talus::validation;

namespace {

using solids = scenario<bodies<sphere, box, capsule, plane>, transport<threads>,
                        decomposition<grid<dynamic, dynamic>>, features<momentum_balance>>;

constexpr real g = 9.81, dt = 1.0 / 240, degree = pi / 180;

std::string on(const std::string& test, int ranks) {
  return fmt::format("{}, {} rank{}", test, ranks, ranks == 1 ? "" : "s");
}

/// A thin rod that leans by `angle` from the floor, its leading tip on the floor at the origin,
/// moving towards +x: friction presses the tip into the floor.
struct rod {
  real angle;
  capsule shape{.radius = 0.001, .length = 2};

  /// The axis of the capsule, z, is rotated to point forwards and down.
  [[nodiscard]] quat orientation() const { return rotation(vec3::UnitY(), pi / 2 + angle); }
  /// From the centre of mass to the contact point.
  [[nodiscard]] vec3 arm() const {
    return orientation() * vec3(0, 0, shape.length / 2) - shape.radius * vec3::UnitZ();
  }
  [[nodiscard]] real inertia() const { return shape.inertia()[0]; }
  // Velocity of the tip for unit impulses there, times the mass.
  [[nodiscard]] real nn() const { return 1 + arm()[0] * arm()[0] / inertia(); }
  [[nodiscard]] real tt() const { return 1 + arm()[2] * arm()[2] / inertia(); }
  [[nodiscard]] real nt() const { return -arm()[0] * arm()[2] / inertia(); }
  /// The friction beyond which a sliding tip has no solution: (1 + 3 cos^2) / (3 sin cos) if thin.
  [[nodiscard]] real critical() const { return nn() / nt(); }
};

}  // namespace

TEST_CASE(
    "Painleve's rod: slides below the critical friction, stops at once above, never blows up") {
  for (const auto& [degrees, thin] :
       {std::pair(63.4349, 4. / 3), std::pair(45., 5. / 3), std::pair(55., 1.409659)}) {
    const rod r{degrees * degree};
    const std::string name = fmt::format("Painleve's rod at {} degrees", degrees);
    check_relative(name, "critical friction, thin rod", thin, r.critical(), 2e-3);
    for (const real part : {0.5, 0.9, 0.99, 1.01, 1.1, 2.0})
      for (const int ranks : {1, 4}) {
        if (ranks > 1 && part != 0.9 && part != 1.1) continue;
        const real mu = part * r.critical(), v0 = 3;
        std::vector<vec3> ground;
        real energy = 0, gain = 0, fastest = 0, sunk = 0;
        const auto way = follow<solids>(
            ranks, dt, 240,
            [&](auto& w) {
              w.material({.friction = mu});
              w.gravity({0, 0, -g});
              w.solver().iterations = 20;
              w.global([&](auto& s) { s.add(plane{}, material_id{}); });
              w.add_if_local(body{.shape = r.shape,
                                  .position = -r.arm(),
                                  .velocity = {v0, 0, 0},
                                  .orientation = r.orientation()});
            },
            [&](auto& w) {
              if (w.steps() > 1 && w.steps() % 4 != 0) return;
              const auto motion = measure_motion(w);
              const auto account = measure_momentum(w);
              if (w.rank() != 0) return;
              ground.push_back(account.ground / account.mass);
              const real now = (motion.kinetic_energy + motion.potential_energy) / motion.mass;
              if (energy == 0) energy = 0.5 * v0 * v0 - g * r.arm()[2];
              gain = std::max(gain, now - energy);
              fastest = std::max(fastest, motion.max_speed);
            })[0];
        const std::string test = on(fmt::format("{}, mu = {:.2f} critical", name, part), ranks);
        // The first step: gravity and the initial velocity act, then the impulse at the tip.
        const vec3 p = ground.at(0);
        const moment& first = way[1];
        const vec3 tip = first.velocity + first.angular_velocity.cross(r.arm());
        const real n = g * dt / (r.nn() - mu * r.nt());
        if (n > 0 && v0 + (r.nt() - mu * r.tt()) * n > 0) {
          // It continues to slide, with an impulse by which the tip neither rises nor sinks.
          CHECK(part < 1);
          check_relative(test, "normal impulse of the first step", n, p[2], 1e-6);
          check_relative(test, "tangential impulse of the first step", -mu * n, p[0], 1e-6);
          CHECK(tip[0] > 0);
        } else {
          // No sliding impulse keeps the tip from sinking, or not before the end of the step: it
          // stops, by an impulse without collision.
          CHECK(part > 0.98);
          const real det = r.nn() * r.tt() - r.nt() * r.nt();
          const real stop = (r.tt() * g * dt + r.nt() * v0) / det,
                     t = -(r.nt() * g * dt + r.nn() * v0) / det;
          check_relative(test, "normal impulse that stops the tip", stop, p[2], 1e-6);
          check_relative(test, "tangential impulse that stops the tip", t, p[0], 1e-6);
          check_error(test, "speed of the tip after it (m/s)", tip.norm(), 1e-6);
        }
        // The law holds: in the cone, no approach, no pull.
        check_error(test, "friction beyond its cone", std::max(0., -p[0] / p[2] / mu - 1), 1e-9);
        bool finite = true;
        for (const moment& m : way) {
          finite = finite && m.position.allFinite() && m.velocity.allFinite() &&
                   m.angular_velocity.allFinite();
          for (const real end : {-1., 1.})
            sunk = std::max(sunk, -pose{m.position, m.orientation}.to_world({0, 0, end})[2]);
        }
        check_holds(test, "finite for 1 s", true, finite);
        check_error(test, "energy gained, over m g l", gain / g, 1e-3);
        check_error(test, "an end below the floor (m)", std::max(0., sunk), 2e-3);
        CHECK(fastest < 3 * v0);
      }
  }
}

TEST_CASE("the floor bears the weight of what rests on it, to 1e-6") {
  struct scene {
    const char* name;
    void (*add)(world<solids>&);
    real time;
    int iterations;
  };
  constexpr auto pit = [](world<solids>& w) {
    w.global([&](auto& s) {
      for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
        s.add(plane{.normal = n, .offset = -2}, material_id{});
    });
  };
  const std::vector<scene> scenes{
      {"a sphere",
       [](world<solids>& w) {
         w.add_if_local(body{.shape = sphere{0.5}, .position = {0, 0.1, 0.5}});
       },
       1, 10},
      {"a box across four domains",
       [](world<solids>& w) {
         w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {0, 0, 0.5}});
       },
       1, 10},
      {"a stack of five boxes",
       [](world<solids>& w) {
         for (int k = 0; k < 5; ++k)
           w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {0.02 * k - 0.04, 0, k + 0.5}});
       },
       2, 30},
      {"a pyramid of spheres in a pit",
       [](world<solids>& w) {
         for (int k = 0; k < 16; ++k)
           w.add_if_local(body{.shape = sphere{0.5},
                               .position = {1. * (k % 4) - 1.5, 1. * (k / 4) - 1.5, 0.5}});
         for (int k = 0; k < 9; ++k)
           w.add_if_local(
               body{.shape = sphere{0.5},
                    .position = {1. * (k % 3) - 1, 1. * (k / 3) - 1, 0.5 + std::sqrt(0.5)}});
       },
       4, 20},
      {"a plate on four spheres on four boxes, and a sphere on it",
       [](world<solids>& w) {
         for (int k = 0; k < 4; ++k) {
           const real x = 2. * (k % 2) - 1, y = 2. * (k / 2) - 1;
           w.add_if_local(body{.shape = box{{0.8, 0.7, 0.6}}, .position = {x, y, 0.3}});
           w.add_if_local(body{.shape = sphere{0.4}, .position = {x, y, 1}});
         }
         w.add_if_local(body{.shape = box{{3, 3, 0.4}}, .position = {0, 0, 1.6}});
         w.add_if_local(body{.shape = sphere{0.5}, .position = {0.1, 0, 2.3}});
       },
       3, 30}};
  for (const scene& s : scenes)
    for (const int ranks : {1, 4}) {
      // The last steps one by one: the force of a single step, not a mean.
      real worst = 0, speed = 0;
      threads::launch({.ranks = ranks}, [&](threads::link& link) {
        world<solids> w(link);
        w.material({.friction = 0.5});
        w.gravity({0, 0, -g});
        w.solver().iterations = s.iterations;
        w.global([&](auto& scope) { scope.add(plane{}, material_id{}); });
        if (s.time > 3) pit(w);
        s.add(w);
        const auto steps = static_cast<int>(s.time / dt);
        for (int k = 0; k < steps; ++k) {
          w.step(dt);
          if (k + 24 < steps) continue;
          const auto account = measure_momentum(w);
          const auto motion = measure_motion(w);
          if (link.rank() != 0) continue;
          worst = std::max(worst, std::abs(account.borne_weight() - 1));
          speed = motion.max_speed;
        }
      });
      MESSAGE("largest speed ", speed);
      check_error(on(std::string("weight on the floor: ") + s.name, ranks),
                  "|force / weight - 1|, worst of 24 steps", worst, 1e-6);
    }
}

TEST_CASE("a box slides and sticks on an incline that crosses the domains of four ranks") {
  const real angle = 30 * degree;
  const vec3 along{std::cos(angle), 0, -std::sin(angle)}, up{std::sin(angle), 0, std::cos(angle)};
  const auto run = [&](real mu, real start, real time) {
    return follow<solids>(4, dt, static_cast<std::size_t>(time / dt), [&](auto& w) {
      w.material({.friction = mu});
      w.gravity({0, 0, -g});
      w.global([&](auto& s) { s.add(plane{.normal = up}, material_id{}); });
      w.add_if_local(body{.shape = box{{1, 1, 1}},
                          .position = 0.5 * up + start * along,
                          .orientation = rotation(vec3::UnitY(), angle)});
    })[0];
  };
  const auto slides = run(0.4, -4, 3);
  const real a = along.dot(slides.back().velocity - slides[240].velocity) / 2;
  check_absolute("box on 30 degrees, 4 ranks", "acceleration, mu = 0.4", 1.506716316, a, 1e-9);
  CHECK(slides[0].position[0] * slides.back().position[0] < 0);
  const auto sticks = run(0.6, 0, 10.5);
  check_error("box on 30 degrees, 4 ranks", "creep in 10 s (m), mu = 0.6",
              (sticks.back().position - sticks[120].position).norm(), 1e-9);
}

TEST_CASE(
    "boxes and spheres with restitution 1, without friction and with mu = 2, gain no energy") {
  for (const int ranks : {1, 4})
    for (const real e : {0.0, 1.0})
      for (const real mu : {0.0, 2.0}) {
        real gain = 0, start = 0, least = 0;
        bool finite = true;
        threads::launch({.ranks = ranks}, [&](threads::link& link) {
          world<solids> w(link);
          w.material({.restitution = e, .friction = mu});
          w.gravity({0, 0, -g});
          w.global([&](auto& s) {
            s.add(plane{}, material_id{});
            for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
              s.add(plane{.normal = n, .offset = -2}, material_id{});
          });
          random_stream random(7);
          for (int k = 0; k < 16; ++k) {
            const vec3 at{1.8 * (k % 2) - 0.9, 1.8 * (k / 2 % 2) - 0.85, 1.3 * (k / 4) + 1},
                v = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 2));
            if (k % 2 == 0)
              w.add_if_local(body{.shape = sphere{0.5}, .position = at, .velocity = v});
            else
              w.add_if_local(body{.shape = box{{0.9, 0.7, 0.5}},
                                  .position = at,
                                  .velocity = v,
                                  .angular_velocity = 2 * v,
                                  .orientation = rotation({1, 2, 3}, 0.4 * k)});
          }
          for (int k = 0; k < 360; ++k) {
            if (k % 4 != 0) {
              w.step(dt);
              continue;
            }
            const auto m = measure_motion(w);
            const real energy = m.kinetic_energy + m.potential_energy;
            if (link.rank() == 0) {
              if (k == 0) start = energy;
              gain = std::max(gain, energy / start - 1);
              finite = finite && std::isfinite(energy);
            }
            w.step(dt);
          }
          real lowest = 10;
          w.for_each_local([&](const auto& b) {
            lowest = std::min(lowest, b.position()[2]);
            for (int axis = 0; axis < 2; ++axis)
              lowest = std::min(lowest, 2 - std::abs(b.position()[axis]));
          });
          link.reduce(reduction::min, std::span(&lowest, 1));
          if (link.rank() == 0) least = lowest;
        });
        const std::string test =
            on(fmt::format("8 boxes and 8 spheres, e = {}, mu = {}", e, mu), ranks);
        check_error(test, "energy gained in 1.5 s, over that at the start", gain, 0.02);
        check_holds(test, "all finite and inside", true, finite && least > 0.2);
      }
}
