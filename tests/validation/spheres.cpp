// Spheres on planes and against each other, against closed forms: rolling, inclines, bouncing,
// cradles, oblique impacts. On 1 rank, and on 4 whose domains meet in the middle of each scene.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "../scenes/spheres.hpp"
#include "record.hpp"
#include "track.hpp"

using namespace talus;
using namespace talus::validation;

namespace {

using balls = scenes::spheres;

constexpr real g = 9.81, dt = 1.0 / 240, degree = pi / 180;

std::string on(const char* test, int ranks) {
  return fmt::format("{}, {} rank{}", test, ranks, ranks == 1 ? "" : "s");
}
/// A plane through the origin that falls by `angle` along +x; its material is the first one.
template <class World>
void floor(World& w, real angle = 0) {
  w.global([&](auto& s) {
    s.add(plane{.normal = {std::sin(angle), 0, std::cos(angle)}}, material_id{});
  });
}
std::size_t steps_of(real time, real step) {
  return static_cast<std::size_t>(std::lround(time / step));
}

}  // namespace

TEST_CASE("a sliding sphere rolls with 5/7 of its speed after 2 v0 / (7 mu g)") {
  const real v0 = 5, mu = 0.3, radius = 0.5;
  const real slip_time = 2 * v0 / (7 * mu * g), slip_way = 12 * v0 * v0 / (49 * mu * g);
  struct measured {
    real speed, time, way, late_way, height;
  };
  const auto run = [&](int ranks, real step) {
    const auto way = follow<balls>(ranks, step, steps_of(1, step), [&](auto& w) {
      w.material({.friction = mu});
      w.gravity({0, 0, -g});
      floor(w);
      w.add_if_local(
          body{.shape = sphere{radius}, .position = {-1.2, 0.1, radius}, .velocity = {v0, 0, 0}});
    })[0];
    measured m{way.back().velocity[0], 0, 0, way.back().position[0] + 1.2, 0};
    for (std::size_t k = 1; k < way.size(); ++k) {
      const real slip = way[k].velocity[0] - radius * way[k].angular_velocity[1];
      if (slip > 1e-9) {
        m.time = static_cast<real>(k) * step;
        m.way = way[k].position[0] + 1.2;
      }
      m.height = std::max(m.height, std::abs(way[k].position[2] - radius));
    }
    return m;
  };
  for (const int ranks : {1, 4}) {
    const std::string test = on("sliding to rolling sphere", ranks);
    const measured m = run(ranks, dt);
    check_absolute(test, "final speed v_f (m/s)", 5. / 7 * v0, m.speed, 1e-6);
    check_absolute(test, "slip time t* (s)", slip_time, m.time, dt);
    check_absolute(test, "slip way s* (m)", slip_way, m.way, v0 * dt);
    check_error(test, "height", m.height, 1e-9);
  }
  // The distance after 1 s, for any phase of the step in which the slip ends.
  const real expected = slip_way + 5. / 7 * v0 * (1 - slip_time);
  const real coarse = std::abs(run(1, dt).late_way - expected),
             fine = std::abs(run(1, dt / 16).late_way - expected);
  check_at_least("sliding to rolling sphere", "order of the way in dt", 0.9,
                 std::log2(coarse / fine) / 4);
}

TEST_CASE("a sphere rolls down an incline with 5/7 g sin, or slides with g (sin - mu cos)") {
  const real angle = 30 * degree, radius = 0.5, critical = 2. / 7 * std::tan(angle);
  check_absolute("sphere on an incline of 30 degrees", "critical friction", 0.164957220, critical,
                 1e-9);
  const std::vector<real> frictions{0.0,  0.05, 0.16, 0.999 * critical, 1.001 * critical,
                                    0.17, 0.3,  1.0};
  const vec3 along{std::cos(angle), 0, -std::sin(angle)};
  const auto run = [&](int ranks, real step) {
    return follow<balls>(ranks, step, steps_of(2, step), [&](auto& w) {
      const auto ground = w.material({});
      w.gravity({0, 0, -g});
      floor(w, angle);
      for (std::size_t k = 0; k < frictions.size(); ++k) {
        const auto m = w.material({});
        w.material_pair(ground, m, {.friction = frictions[k], .dynamic_friction = frictions[k]});
        w.add_if_local(body{.shape = sphere{radius},
                            .position = radius * vec3(std::sin(angle), 0, std::cos(angle)) -
                                        2. * along + vec3(0, 3. * static_cast<real>(k) - 10, 0),
                            .material = m});
      }
    });
  };
  for (const int ranks : {1, 4}) {
    const auto all = run(ranks, dt);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const real mu = frictions[k];
      const bool rolls = mu >= critical;
      const moment& end = all[k].back();
      const std::string test = on("sphere on an incline of 30 degrees", ranks);
      check_absolute(
          test, fmt::format("acceleration, mu = {:.4f}", mu),
          rolls ? 5. / 7 * g * std::sin(angle) : g * (std::sin(angle) - mu * std::cos(angle)),
          along.dot(end.velocity) / 2, 1e-6);
      const real slip = along.dot(end.velocity) - radius * end.angular_velocity[1];
      check_holds(test, fmt::format("rolls, mu = {:.4f}", mu), rolls, std::abs(slip) < 1e-9);
    }
  }
  const auto error = [&](real step) {
    const auto way = run(1, step)[6];
    return std::abs(along.dot(way.back().position - way[0].position) - 10. / 7 * g / 2);
  };
  check_at_least("sphere on an incline of 30 degrees", "order of the way in dt", 0.95,
                 std::log2(error(dt) / error(dt / 4)) / 2);
}

TEST_CASE("a bouncing ball returns to h e^(2k), and rests after sqrt(2h/g)(1+e)/(1-e)") {
  // Over several heights, so that the phase of the steps averages out; the first one is 1.
  constexpr int heights = 16;
  const auto height = [](int n) { return 1 + 0.01 * n; };
  struct measured {
    real time = 0, first_time = 0, apex = 0, rest = 0, gain = 0;
    int apexes = 0;
  };
  const auto run = [&](int ranks, real e, real step) {
    const real longest = 1.2 * std::sqrt(2 * height(heights) / g) * (1 + e) / (1 - e);
    const auto all = follow<balls>(ranks, step, steps_of(longest, step), [&](auto& w) {
      w.material({.restitution = e});
      w.gravity({0, 0, -g});
      floor(w);
      for (int n = 0; n < heights; ++n)
        w.add_if_local(body{.shape = sphere{0.5},
                            .position = {2. * (n % 4) - 2.9, 2. * (n / 4) - 2.9, 0.5 + height(n)}});
    });
    measured m;
    for (int n = 0; n < heights; ++n) {
      const auto& way = all[static_cast<std::size_t>(n)];
      const real expected = std::sqrt(2 * height(n) / g) * (1 + e) / (1 - e);
      real last = 0, apex = 0, before = 0, wanted = height(n);
      int bounces = 0;
      for (std::size_t k = 1; k < way.size(); ++k) {
        const real v = way[k].velocity[2], z = way[k].position[2] - 0.5;
        if (std::abs(v) > 1e-9) last = static_cast<real>(k) * step;
        if (before < 0 && v > 0) {
          if (++bounces > 1 && bounces <= 4)
            m.apex = std::max(m.apex, std::abs(apex / wanted - 1)), ++m.apexes;
          wanted *= e * e;
          apex = 0;
        }
        apex = std::max(apex, z);
        m.gain = std::max(m.gain, z - height(n));
        before = v;
      }
      m.time += (last - expected) / expected / heights;
      if (n == 0) m.first_time = last;
      m.rest = std::max(m.rest, std::abs(way.back().position[2] - 0.5));
    }
    m.time = std::abs(m.time);
    return m;
  };
  const std::vector<std::pair<real, real>> total{
      {0.5, 1.354570923}, {0.8, 4.063712769}, {0.9, 8.578949179}};
  for (const auto& [e, time] : total) {
    for (const int ranks : {1, 4}) {
      const std::string test = on(fmt::format("bouncing ball, e = {}", e).c_str(), ranks);
      const measured m = run(ranks, e, dt);
      check_relative(test, "time until rest from h = 1 (s), dt 1/240", time, m.first_time, 0.05);
      check_error(test, "mean relative error of that time over 16 heights", m.time, 0.05);
      check_error(test, "largest relative error of the first three apexes h e^(2k)", m.apex, 0.05);
      CHECK(m.apexes == 3 * heights);
      check_error(test, "height above the floor at rest", m.rest, 1e-9);
      check_error(test, "height gained", m.gain, 1e-9);
    }
    const real coarse = run(1, e, dt).time, fine = run(1, e, dt / 16).time;
    check_at_least(fmt::format("bouncing ball, e = {}", e), "order of the time until rest in dt",
                   0.8, std::log2(coarse / fine) / 4);
  }
}

TEST_CASE("a ball that bounces with e = 1 comes back to its height, and gains nothing") {
  for (const int ranks : {1, 4})
    for (const real step : {dt, dt / 4}) {
      if (ranks > 1 && step < dt) continue;
      const auto way = follow<balls>(ranks, step, steps_of(20, step), [&](auto& w) {
        w.material({.restitution = 1});
        w.gravity({0, 0, -g});
        floor(w);
        w.add_if_local(
            body{.shape = sphere{0.5}, .position = {-1, 0.1, 1.5}, .velocity = {0.1, 0, 0}});
      })[0];
      real late = 0, highest = 0;
      for (std::size_t k = 0; k < way.size(); ++k) {
        const real z = way[k].position[2] - 0.5;
        if (k > way.size() * 9 / 10) late = std::max(late, z);
        highest = std::max(highest, z);
      }
      const std::string test =
          on(fmt::format("bouncing ball, e = 1, dt 1/{:.0f}", 1 / step).c_str(), ranks);
      check_error(test, "height gained", std::max(real{0}, highest - 1), 1e-9);
      check_absolute(test, "height after 18 to 20 s", 1, late, g * step * step);
    }
}

TEST_CASE("Newton's cradle: with gaps the last ball leaves with ((1+e)/2)^(n-1)") {
  for (const int ranks : {1, 4})
    for (const real e : {0.5, 0.9, 1.0}) {
      const real v0 = 1, gap = 3 * v0 * dt;
      const auto all = follow<balls>(ranks, dt, 24, [&](auto& w) {
        w.material({.restitution = e});
        for (int k = 0; k < 5; ++k)
          w.add_if_local(body{.shape = sphere{0.5},
                              .position = {(k - 2) * (1 + gap), 0, 0},
                              .velocity = {k == 0 ? v0 : 0, 0, 0}});
      });
      real momentum = 0;
      for (const auto& way : all) momentum += way.back().velocity[0];
      const std::string test = on(fmt::format("cradle with gaps, e = {}", e).c_str(), ranks);
      check_absolute(test, "speed of the last of 5 balls, over v0", std::pow((1 + e) / 2, 4),
                     all[4].back().velocity[0], 1e-9);
      check_absolute(test, "momentum, over m v0", 1, momentum, 1e-12);
    }
}

TEST_CASE("Newton's cradle: balls that touch obey the simultaneous law of Newton") {
  for (const int ranks : {1, 4}) {
    const auto all = follow<balls>(ranks, dt, 1, [&](auto& w) {
      w.material({.restitution = 1});
      w.solver().iterations = ranks == 1 ? 400 : 1500;
      for (int k = 0; k < 5; ++k)
        w.add_if_local(body{.shape = sphere{0.5},
                            .position = {1. * (k - 2), 0, 0},
                            .velocity = {k == 0 ? 1. : 0., 0, 0}});
    });
    const std::string test = on("cradle that touches, e = 1", ranks);
    real momentum = 0;
    for (std::size_t k = 0; k < 5; ++k) {
      check_absolute(test, fmt::format("speed of ball {}, over v0", k + 1), k == 0 ? -0.6 : 0.4,
                     all[k].back().velocity[0], 1e-9);
      momentum += all[k].back().velocity[0];
    }
    check_absolute(test, "momentum, over m v0", 1, momentum, 1e-12);
  }
}

TEST_CASE("oblique impact: slides beyond v_t / v_n = 3.5 mu (1 + e), else sticks") {
  const real e = 0.5, mu = 0.3, radius = 0.5, speed = 3;
  for (const int ranks : {1, 4}) {
    const auto along = [](int k) {
      const real heading = 0.7 + k;
      return vec3(std::cos(heading), std::sin(heading), 0);
    };
    const auto all = follow<balls>(ranks, dt, 2, [&](auto& w) {
      w.material({.restitution = e, .friction = mu});
      floor(w);
      for (int k = 0; k < 90; ++k) {
        const real vn = speed * std::cos(k * degree), vt = speed * std::sin(k * degree);
        w.add_if_local(
            body{.shape = sphere{radius},
                 .position = {2. * (k % 10) - 9, 2. * (k / 10) - 8, radius + 0.37 * vn * dt},
                 .velocity = vt * along(k) - vn * vec3(0, 0, 1)});
      }
    });
    real worst_sliding = 0, worst_sticking = 0;
    int sliding = 0, sticking = 0;
    for (int k = 0; k < 90; ++k) {
      const real vn = speed * std::cos(k * degree), vt = speed * std::sin(k * degree);
      const bool slides = vt >= 3.5 * mu * (1 + e) * vn;
      const real vt_after = slides ? vt - mu * (1 + e) * vn : 5. / 7 * vt;
      const real spin = (slides ? 2.5 * mu * (1 + e) * vn : 5. / 7 * vt) / radius;
      const vec3 t = along(k), v = vt_after * t + e * vn * vec3(0, 0, 1),
                 w = spin * vec3(0, 0, 1).cross(t);
      const moment& end = all[static_cast<std::size_t>(k)].back();
      real& worst = slides ? worst_sliding : worst_sticking;
      ++(slides ? sliding : sticking);
      worst = std::max({worst, (end.velocity - v).norm() / speed,
                        radius * (end.angular_velocity - w).norm() / speed});
    }
    const std::string test = on("oblique impact, e = 0.5, mu = 0.3", ranks);
    check_error(test, fmt::format("velocity and spin of {} sliding impacts", sliding),
                worst_sliding, 1e-9);
    check_error(test, fmt::format("velocity and spin of {} sticking impacts", sticking),
                worst_sticking, 1e-9);
    CHECK(sliding > 10);
    CHECK(sticking > 10);
  }
}

TEST_CASE("spheres with restitution 1, without friction and with mu = 2, gain no energy") {
  for (const int ranks : {1, 4})
    for (const real e : {0.0, 1.0})
      for (const real mu : {0.0, 2.0}) {
        const auto all = follow<balls>(ranks, dt, 240 * 3, [&](auto& w) {
          w.material({.restitution = e, .friction = mu});
          w.gravity({0, 0, -g});
          w.global([&](auto& s) {
            s.add(plane{}, material_id{});
            for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
              s.add(plane{.normal = n, .offset = -2}, material_id{});
          });
          random_stream random(7);
          for (int k = 0; k < 27; ++k)
            w.add_if_local(body{
                .shape = sphere{0.5},
                .position = {1.2 * (k % 3) - 1.2, 1.2 * (k / 3 % 3) - 1.15, 1.2 * (k / 9) + 0.8},
                .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 2)),
                .angular_velocity = random.uniform(vec3(-4, -4, -4), vec3(4, 4, 4))});
        });
        const auto energy = [&](std::size_t k) {
          real sum = 0;
          for (const auto& way : all)
            sum += 0.5 * way[k].velocity.squaredNorm() +
                   0.05 * way[k].angular_velocity.squaredNorm() + g * way[k].position[2];
          return sum;
        };
        // A velocity is that of half a step before: a fall of v dt/2 is not counted yet.
        real gain = 0, start = energy(0), speed = 0;
        bool finite = true;
        for (std::size_t k = 0; k < all[0].size(); ++k) {
          gain = std::max(gain, energy(k) / start - 1);
          for (const auto& way : all) {
            speed = std::max(speed, way[k].velocity.norm());
            finite = finite && way[k].position.allFinite() && way[k].position[2] > 0.4;
          }
        }
        const std::string test =
            on(fmt::format("27 spheres, e = {}, mu = {}", e, mu).c_str(), ranks);
        check_error(test, "energy gained in 3 s, over that at the start", gain, 0.02);
        check_holds(test, "all finite, none through the floor", true, finite);
      }
}
