// Joints with features: bodies that are driven, mechanisms that sleep.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <talus/body/motion.hpp>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/joints.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "joint_row.hpp"

using namespace talus;
using namespace joint_row;

TEST_CASE("a row hangs on a driven body and follows it") {
  using scene = row<decomposition<cells>, features<driven>>;
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    const auto lift = [](auto& w, auto wall) {
      w.drive(wall, [](real t) {
        return rigid_displacement{.shift = {0, 0.2 * std::sin(3 * t), t}};
      });
    };
    const outcome end = run_row<scene>(square_cells(ranks), ranks, 500, 2e-3, {0, 0, -9.81}, lift);
    CHECK(end.gap < 1e-9);
  }
}

namespace {

/// A row that hangs along x over all domains, with a wheel at its end. When it sleeps,
/// `rouse(world, motor, material)` is called. Returns how many of the six bodies sleep before, and
/// 20 steps after that.
template <class Scenario>
std::array<std::uint64_t, 2> asleep(int ranks, auto&& rouse) {
  std::array<std::uint64_t, 2> count{};
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, square_cells(ranks));
    w.gravity({9.81, 0, 0});
    w.sleeping({.speed = 0.02, .time = 0.1});
    const auto stuff = w.material({.density = 1});
    handle<sphere> wall;
    w.global([&](auto& scope) { wall = scope.add(sphere{0.2}, stuff, vec3(-2.6, 0.4, 0)); });
    std::optional<handle<sphere>> last = wall;
    for (int k = 0; k < 5; ++k) {
      const vec3 at(-2 + 0.7 * k, 0.4, 0);
      const auto next =
          w.add_if_local(body{.shape = sphere{0.3}, .position = at, .material = stuff});
      (void)w.join(last, next, ball_joint{.at = at - vec3(0.35, 0, 0)});
      last = next;
    }
    const auto wheel =
        w.add_if_local(body{.shape = sphere{0.3}, .position = {1.5, 0.4, 0}, .material = stuff});
    auto motor = w.join(last, wheel, hinge{.at = {1.5, 0.4, 0}, .axis = {1, 0, 0}});
    for (int k = 0; k < 400; ++k) w.step(2e-3);
    const std::uint64_t before = measure_motion(w).asleep;
    rouse(w, motor, stuff);
    for (int k = 0; k < 20; ++k) w.step(2e-3);
    const std::uint64_t after = measure_motion(w).asleep;
    if (link.rank() == 0) count = {before, after};
  });
  return count;
}

/// A ball that hangs along x on an anchor on the other side of the cut, asleep. Then
/// `change(world, anchor)` is called, and 100 steps follow, of which the largest gap is taken.
struct hanging {
  std::uint64_t asleep = 0, joints = 0, asleep_after = 0;
  real fallen = 0;  ///< the momentum along x over that of a free fall of both
  real gap = 0;
};
template <class Scenario>
hanging hang(int ranks, bool global, auto&& change) {
  hanging seen;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, square_cells(ranks));
    w.gravity({9.81, 0, 0});
    w.sleeping({.speed = 0.02, .time = 0.1});
    const auto stuff = w.material({.density = 1});
    const vec3 at(-0.2, 0.4, 0);
    std::optional<handle<sphere>> anchor;
    if (global) {
      w.global([&](auto& scope) { anchor = scope.add(sphere{0.1}, stuff, at); });
      w.drive(*anchor, [](real t) {
        return rigid_displacement{
            .shift = {0, t > 0.8 ? 0.5 * (1 - std::cos(3 * (t - 0.8))) : 0, 0}};
      });
    } else {
      anchor = w.add_if_local(
          body{.shape = sphere{0.1}, .position = at, .material = stuff, .fixed = true});
    }
    const auto ball =
        w.add_if_local(body{.shape = sphere{0.3}, .position = {0.3, 0.4, 0}, .material = stuff});
    (void)w.join(anchor, ball, ball_joint{.at = at});
    for (int k = 0; k < 400; ++k) w.step(2e-3);
    const std::uint64_t asleep = measure_motion(w).asleep, joints = measure_joints(w).joints;
    change(w, anchor);
    real gap = 0;
    for (int k = 0; k < 100; ++k) {
      w.step(2e-3);
      gap = std::max(gap, measure_joints(w).gap);
    }
    const motion after = measure_motion(w);
    const real whole = 4. / 3 * pi * (0.001 + 0.027) * 9.81 * 0.2;
    if (link.rank() == 0) seen = {asleep, joints, after.asleep, after.momentum[0] / whole, gap};
  });
  return seen;
}

}  // namespace

TEST_CASE_TEMPLATE(
    "a mechanism sleeps as one island, and wakes when its motor or its anchor changes or something "
    "touches it",
    Solver, nonlinear_gauss_seidel, reproducible) {
  using scene = scenario<bodies<sphere>, joints<ball_joint, hinge>, transport<threads>,
                         solver<Solver>, decomposition<cells>, features<sleeping, driven>>;
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    const auto undisturbed = asleep<scene>(ranks, [](auto&, auto&, auto) {});
    CHECK(undisturbed == std::array<std::uint64_t, 2>{6, 6});
    const auto driven = asleep<scene>(ranks, [](auto&, auto& motor, auto) {
      motor.set_motor(torque_motor{.velocity = 9, .largest_torque = 1});
    });
    CHECK(driven == std::array<std::uint64_t, 2>{6, 0});
    const auto released = asleep<scene>(ranks, [](auto&, auto& motor, auto) { motor.release(); });
    CHECK(released == std::array<std::uint64_t, 2>{6, 0});
    const auto struck = asleep<scene>(ranks, [](auto& w, auto&, auto stuff) {
      w.add_if_local(body{.shape = sphere{0.3},
                          .position = {-2, 1.1, 0},
                          .material = stuff,
                          .velocity = {0, -20, 0}});
    });
    CHECK(struck == std::array<std::uint64_t, 2>{6, 0});

    const auto hangs = [&](const hanging& x) {
      CHECK(x.asleep == 1);
      CHECK(x.joints == 1);
      CHECK(x.gap < 1e-12);
    };
    const hanging still = hang<scene>(ranks, false, [](auto&, auto&) {});
    hangs(still);
    CHECK(still.asleep_after == 1);
    const hanging falls = hang<scene>(ranks, false, [](auto& w, auto& anchor) {
      if (anchor) w[*anchor].release();
    });
    hangs(falls);
    CHECK(falls.asleep_after == 0);
    CHECK(falls.fallen == doctest::Approx(1).epsilon(1e-12));
    const hanging shifted = hang<scene>(ranks, false, [](auto& w, auto& anchor) {
      if (anchor) w[*anchor].translate({0.05, 0.1, 0.2});
    });
    hangs(shifted);
    const hanging carried = hang<scene>(ranks, true, [](auto&, auto&) {});
    hangs(carried);
    CHECK(carried.asleep_after == 0);
  }
}

namespace {

/// A row of spheres along x, each on a rank of its own if there are four, at rest. Before step
/// `push` the first is pushed across the row. Returns the digest after each step.
template <class Scenario>
std::vector<std::string> pushed_row(int ranks, int push) {
  std::vector<std::string> digests;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(
        link, cells{.cells = {ranks, 1}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}});
    w.sleeping({.speed = 0.02, .time = 0.1});
    const auto stuff = w.material({.density = 1});
    std::array<std::optional<handle<sphere>>, 4> row;
    for (std::size_t k = 0; k < row.size(); ++k) {
      const vec3 at(2 * real(k) - 3, 0.4, 0);
      row[k] = w.add_if_local(body{.shape = sphere{0.3}, .position = at, .material = stuff});
      if (k > 0) (void)w.join(row[k - 1], row[k], ball_joint{.at = at - vec3(1, 0, 0)});
    }
    for (int k = 0; k < 100; ++k) {
      if (k == push && row[0]) w[*row[0]].set_velocity({0, 0.06, 0});
      w.step(2e-3);
      const std::string digest = state_digest(w);
      if (link.rank() == 0) digests.push_back(digest);
    }
  });
  return digests;
}

}  // namespace

TEST_CASE("a mechanism on several ranks falls asleep and wakes on all of them in one step") {
  using scene = scenario<bodies<sphere>, joints<ball_joint, hinge>, transport<threads>,
                         decomposition<cells>, features<sleeping>>;
  for (const int push : {48, 49, 50, 51, 53, 60}) {
    CAPTURE(push);
    CHECK(pushed_row<scene>(4, push) == pushed_row<scene>(1, push));
  }
}
