// Chains, joints that are redundant or contradict each other, and mechanisms of the IFToMM library
// of benchmark problems.
// timeout: 300
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "machines.hpp"

using namespace machines;

TEST_CASE("redundant joints share their load by the least norm") {
  // Two spheres circle about each other: the load of the joint between them lies along the arm.
  const auto loads = [](bool twice, bool first) {
    std::array<std::vector<vec3>, 2> found;
    in_world([&](auto& w, material_id stuff) {
      w.gravity({0, 0, 0});
      const auto ball = [&](const vec3& at) {
        return *w.add_if_local(body{.shape = sphere{0.3}, .position = at, .material = stuff});
      };
      const auto a = ball({-0.5, 0, 0}), b = ball({0.5, 0, 0});
      const point_on_plane plane{.normal = {1, 0, 0}};
      if (twice && first) (void)w.join(a, b, plane);
      const auto pin = w.join(a, b, ball_joint{});
      if (twice && !first) (void)w.join(a, b, plane);
      w[a].set_velocity({0, -2, 0}), w[b].set_velocity({0, 2, 0});
      for (const auto h : {a, b}) w[h].set_angular_velocity({0, 0, 4});
      for (int k = 0; k < 100; ++k) {
        w.step(1e-2);
        found[0].push_back(pin.force());
        if (twice)
          for_each_joint(w, [&](const joint_in_world& x) {
            if (std::string_view(x.name) == point_on_plane::name) found[1].push_back(x.force);
          });
      }
      CHECK(measure_joints(w).gap < 1e-13);
    });
    return found;
  };
  const auto whole = loads(false, false)[0];
  for (const bool first : {true, false}) {
    const auto [on_pin, on_plane] = loads(true, first);
    REQUIRE(on_plane.size() == whole.size());
    for (std::size_t k = 0; k < whole.size(); ++k) {
      const real size = whole[k].norm();
      CHECK((on_pin[k] + on_plane[k] - whole[k]).norm() <= 1e-3 * size);
      CHECK(on_pin[k].norm() <= size);
      CHECK(on_plane[k].norm() <= size);
    }
    // As long as the normal is that of a row of the ball joint, too.
    CHECK((on_pin[1] - 0.5 * whole[1]).norm() < 0.01 * whole[1].norm());
    CHECK((on_plane[1] - 0.5 * whole[1]).norm() < 0.01 * whole[1].norm());
  }
}

TEST_CASE("joints that contradict each other share the opening, and the worst is noted") {
  in_world([](auto& w, material_id stuff) {
    const auto fixed = [&](const vec3& at) {
      return *w.add_if_local(
          body{.shape = sphere{0.2}, .position = at, .material = stuff, .fixed = true});
    };
    const auto left = fixed({-0.8, 0, 0}), right = fixed({0.8, 0, 0}), below = fixed({-2, 0, -3});
    const auto beam = add_brick(w, stuff, {0, 0, 0});
    (void)w.join(left, beam, ball_joint{.at = {-0.5, 0, 0}});
    (void)w.join(right, beam, ball_joint{.at = {0.5, 0, 0}});
    const auto loose = add_brick(w, stuff, {-2, 0, -5}), other = add_brick(w, stuff, {2, 0, -5});
    (void)w.join(below, loose, rod{.from = {-2, 0, -3}, .to = {-2, 0, -5}});
    (void)w.join(loose, other, gear{.ratio = 3});  // nothing holds its axes
    w[loose].set_angular_velocity({3, 2, 1}), w[other].set_angular_velocity({-1, 2, 3});
    for (int k = 1; k <= 100; ++k) {
      w[right].translate({0.01, 0, 0});
      w.step(1e-2);
      CHECK(measure_joints(w).gap == doctest::Approx(0.005 * k).epsilon(1e-3));
      CHECK(std::abs(w[beam].velocity()[0]) < 1);
      CHECK(w[loose].angular_velocity().norm() < 20);
      CHECK(w[other].angular_velocity().norm() < 20);
    }
    const detail::joint_opening& worst = detail::state_of(w).joints.opening;
    CHECK(worst.step == 100);
    CHECK(worst.gap == doctest::Approx(0.5).epsilon(1e-3));
    CHECK((worst.key.b == beam.id && (worst.key.a == left.id || worst.key.a == right.id)));
  });
}

TEST_CASE("a chain of 300 links with a last one of a million masses stays connected") {
  in_world([](auto& w, material_id stuff) {
    const auto heavy = w.material({.density = 1e6});
    const int links = 300;
    std::vector<handle<sphere>> chain;
    std::optional<joint_handle<first_order, ball_joint>> top;
    for (int k = 0; k < links; ++k) {
      const auto h = *w.add_if_local(body{.shape = sphere{0.4},
                                          .position = {0, 0, -k - 0.5},
                                          .material = k + 1 == links ? heavy : stuff});
      const ball_joint pin{.at = {0, 0, -real(k)}};
      if (k == 0) top = w.join(world_frame, h, pin);
      if (k > 0) (void)w.join(chain.back(), h, pin);
      chain.push_back(h);
    }
    // The tension makes a link swing by sqrt(T / (m l)) = 3100 a second, which steps must resolve.
    w[chain[0]].set_velocity({0.1, 0, 0});
    real gap = 0;
    for (int step = 0; step < 200; ++step) {
      w.step(1e-4);
      vec3 end(0, 0, 0);
      for (const auto& h : chain) {
        const auto b = w[h];
        gap =
            std::max(gap, (b.position() + rotated(b.orientation(), vec3(0, 0, 0.5)) - end).norm());
        end = b.position() + rotated(b.orientation(), vec3(0, 0, -0.5));
      }
    }
    CHECK(gap < 1e-10);
    const real weight = sphere{0.4}.volume() * (1e6 + links - 1) * g;
    CHECK(top->force()[2] == doctest::Approx(-weight).epsilon(1e-5));
  });
}

TEST_CASE("a chain of 10 keeps its joints to round-off over 10,000 steps") {
  in_world([](auto& w, material_id stuff) {
    std::vector<handle<box>> chain;
    const box link{.size = {1, 0.1, 0.2}};
    for (int k = 0; k < 10; ++k) {
      const auto h =
          *w.add_if_local(body{.shape = link, .position = {k + 0.5, 0, 0}, .material = stuff});
      const ball_joint pin{.at = {real(k), 0, 0}};
      if (k == 0) (void)w.join(world_frame, h, pin);
      if (k > 0) (void)w.join(chain.back(), h, pin);
      chain.push_back(h);
    }
    real gap = 0;
    for (int step = 0; step < 10000; ++step) {
      w.step(1e-3);
      vec3 end(0, 0, 0);
      for (const auto& h : chain) {
        const auto b = w[h];
        gap =
            std::max(gap, (b.position() + rotated(b.orientation(), vec3(-0.5, 0, 0)) - end).norm());
        end = b.position() + rotated(b.orientation(), vec3(0.5, 0, 0));
      }
    }
    CHECK(gap < 1e-12);
    CHECK(w[chain[9]].position()[2] < -3);
    CHECK(measure_energy(w).worst < 1e-12);
  });
}

TEST_CASE("A01: a pendulum keeps its energy and its length") {
  in_world<second_order>([](auto& w, material_id) {
    const sphere ball{0.1};
    const auto one = w.material({.density = 1 / ball.volume()});
    const auto h = *w.add_if_local(body{.shape = ball, .position = {-1, 0, 0}, .material = one});
    (void)w.join(world_frame, h, rod{.from = {0, 0, 0}, .to = {-1, 0, 0}});
    const real energy = energy_of(w);
    real drift = 0, gap = 0;
    for (int k = 0; k < 10000; ++k) {
      w.step(1e-3);
      drift = std::max(drift, std::abs(energy_of(w) - energy));
      gap = std::max(gap, std::abs(w[h].position().norm() - 1));
    }
    CHECK(drift < 1e-10);
    CHECK(gap < 1e-13);
  });
}

namespace {

/// The upper left corner of n parallelograms in a row, of rods of 1 kg and 1 m, after `time`, by
/// the classical Runge-Kutta method: at the angle x from the vertical
/// ((n + 1) / 3 + n) x'' = ((n + 1) / 2 + n) g sin(x).
vec3 corner_of_four_bars(int windows, real time) {
  const int n = 100000;
  const real h = time / n;
  real x = 0, v = 1;
  const real pull = (real(windows + 1) / 2 + windows) / (real(windows + 1) / 3 + windows);
  const auto f = [&](real y) { return pull * g * std::sin(y); };
  for (int k = 0; k < n; ++k) {
    const real a1 = f(x), v2 = v + h / 2 * a1, a2 = f(x + h / 2 * v), v3 = v + h / 2 * a2,
               a3 = f(x + h / 2 * v2), v4 = v + h * a3, a4 = f(x + h * v3);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return {std::sin(x), 0, std::cos(x)};
}

}  // namespace

TEST_CASE("A02: a four-bar mechanism passes its singular positions") {
  in_world<second_order>([](auto& w, material_id) {
    const real t = 0.01;
    const auto one = w.material({.density = 1 / (t * t)});
    const auto add = [&](const vec3& size, const vec3& at, const vec3& v, const vec3& spin) {
      return *w.add_if_local(body{.shape = box{.size = size},
                                  .position = at,
                                  .material = one,
                                  .velocity = v,
                                  .angular_velocity = spin});
    };
    // The right rod lies in a plane of its own, so that it does not touch the left one.
    const auto left = add({t, t, 1}, {0, 0, 0.5}, {0.5, 0, 0}, {0, 1, 0});
    const auto right = add({t, t, 1}, {1, 3 * t, 0.5}, {0.5, 0, 0}, {0, 1, 0});
    const auto across = add({1, t, t}, {0.5, 0, 1}, {1, 0, 0}, {0, 0, 0});
    const vec3 y(0, 1, 0);
    (void)w.join(world_frame, left, hinge{.at = {0, 0, 0}, .axis = y});
    (void)w.join(world_frame, right, hinge{.at = {1, 3 * t, 0}, .axis = y});
    (void)w.join(left, across, hinge{.at = {0, 0, 1}, .axis = y});
    (void)w.join(right, across, hinge{.at = {1, 3 * t, 1}, .axis = y});
    const real energy = energy_of(w);
    real drift = 0;
    for (int k = 0; k < 10000; ++k) {
      w.step(1e-3);
      drift = std::max(drift, std::abs(energy_of(w) - energy));
    }
    const auto b = w[left];
    const vec3 corner = b.position() + rotated(b.orientation(), vec3(0, 0, 0.5));
    CHECK(drift < 1e-6);
    CHECK((corner - corner_of_four_bars(1, 10)).norm() < 2e-4);
  });
}

TEST_CASE("A02: two coupled four-bar mechanisms keep their energy in singular positions") {
  in_world<second_order>([](auto& w, material_id) {
    const real t = 0.001;
    const int windows = 2, steps = 4000;
    const auto one = w.material({.density = 1 / (t * t)});
    const vec3 y(0, 1, 0);
    std::vector<handle<box>> up;
    for (int k = 0; k <= windows; ++k) {  // each rod lies in a plane of its own
      up.push_back(*w.add_if_local(body{.shape = box{.size = {t, t, 1}},
                                        .position = {real(k), 6 * t * k, 0.5},
                                        .material = one,
                                        .velocity = {0.5, 0, 0},
                                        .angular_velocity = y}));
      (void)w.join(world_frame, up.back(), hinge{.at = {real(k), 6 * t * k, 0}, .axis = y});
    }
    for (int k = 0; k < windows; ++k) {
      const auto across = *w.add_if_local(body{.shape = box{.size = {1, t, t}},
                                               .position = {k + 0.5, 6 * t * k + 3 * t, 1},
                                               .material = one,
                                               .velocity = {1, 0, 0}});
      const auto left = up[static_cast<std::size_t>(k)],
                 right = up[static_cast<std::size_t>(k) + 1];
      (void)w.join(left, across, hinge{.at = {real(k), 6 * t * k, 1}, .axis = y});
      (void)w.join(across, right, hinge{.at = {real(k + 1), 6 * t * k, 1}, .axis = y});
    }
    const real energy = energy_of(w);
    real drift = 0;
    for (int k = 0; k < steps; ++k) {
      w.step(1e-3);
      drift = std::max(drift, std::abs(energy_of(w) - energy));
    }
    const auto b = w[up[0]];
    const vec3 corner = b.position() + rotated(b.orientation(), vec3(0, 0, 0.5));
    vec3 exact = corner_of_four_bars(windows, steps * 1e-3);
    exact[1] = corner[1];
    CHECK(drift < 1e-9);
    CHECK((corner - exact).norm() < 1e-4);
  });
}

TEST_CASE("A04: Bricard's mechanism, which is overconstrained, moves and keeps its energy") {
  in_world<second_order>([](auto& w, material_id) {
    const real t = 0.02;
    const auto one = w.material({.density = 1 / (t * t)});
    const vec3 corner[] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, -1}, {0, -1, -1}, {0, 0, -1}};
    const vec3 axis[] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    std::vector<handle<box>> rods;
    std::vector<vec3> start, end;  // of each rod, in its frame
    for (int k = 0; k < 5; ++k) {
      const vec3 along = corner[k + 1] - corner[k], at = 0.5 * (corner[k] + corner[k + 1]);
      vec3 size(t, t, t);
      for (int i = 0; i < 3; ++i) size[i] = std::max(t, std::abs(along[i]));
      rods.push_back(
          *w.add_if_local(body{.shape = box{.size = size}, .position = at, .material = one}));
      start.push_back(corner[k] - at), end.push_back(corner[k + 1] - at);
    }
    (void)w.join(world_frame, rods[0], hinge{.at = corner[0], .axis = axis[0]});
    for (std::size_t k = 1; k < 5; ++k)
      (void)w.join(rods[k - 1], rods[k], hinge{.at = corner[k], .axis = axis[k]});
    (void)w.join(rods[4], world_frame, hinge{.at = corner[5], .axis = axis[5]});
    const real energy = energy_of(w);
    real drift = 0, gap = 0, way = 0;
    for (int step = 0; step < 10000; ++step) {
      w.step(1e-3);
      drift = std::max(drift, std::abs(energy_of(w) - energy));
      vec3 last = corner[0];
      for (std::size_t k = 0; k < 5; ++k) {
        const auto b = w[rods[k]];
        gap = std::max(gap, (b.position() + rotated(b.orientation(), start[k]) - last).norm());
        last = b.position() + rotated(b.orientation(), end[k]);
      }
      gap = std::max(gap, (last - corner[5]).norm());
      way = std::max(way, (w[rods[2]].position() - vec3(1, -1, -0.5)).norm());
    }
    CHECK(gap < 1e-13);
    CHECK(drift < 1e-6);
    CHECK(way > 1.5);
  });
}
