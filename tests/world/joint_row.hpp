#pragma once
// A row of bodies on joints over all domains, for tests of joints with other policies.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <talus/constraint/ball_joint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>

namespace joint_row {

using namespace talus;

using cells = grid<dynamic, dynamic>;

struct outcome {
  std::string digest;
  vec3 before{0, 0, 0}, after{0, 0, 0};
  real gap = 0;   ///< largest distance of the two points of a joint
  real load = 0;  ///< of the first joint, downward
};

/// A row of four bodies along x from the wall, released from the horizontal, over all domains.
template <class Scenario, class Decomposition>
outcome run_row(const Decomposition& d, int ranks, int steps, real dt, const vec3& gravity,
                auto&& tend) {
  outcome result;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, d);
    w.gravity(gravity);
    w.solver().iterations = 30;
    const auto stuff = w.material({.density = 1, .restitution = 0.2, .friction = 0.4});
    handle<sphere> wall;
    w.global([&](auto& scope) { wall = scope.add(sphere{0.2}, stuff, vec3(-2.2, 0.4, 1)); });
    std::optional<handle<sphere>> ball;
    std::optional<handle<box>> brick;
    for (int k = 0; k < 4; ++k) {
      const vec3 at(-1.6 + k, 0.4 - 0.25 * k, 1 + 0.1 * k);
      const ball_joint pin{.at = at + vec3(-0.5, 0.1, 0)};
      const vec3 v =
          gravity == vec3(0, 0, 0) ? vec3(0.2 * k, 0.5 * std::cos(2.0 * k), 1) : vec3(0, 0, 0);
      if (k % 2 == 0) {
        const auto next = w.add_if_local(
            body{.shape = sphere{0.3}, .position = at, .material = stuff, .velocity = v});
        if (k > 0)
          (void)w.join(brick, next, pin);
        else if (gravity != vec3(0, 0, 0))
          (void)w.join(wall, next, pin);
        ball = next;
      } else {
        const auto next = w.add_if_local(body{.shape = box{.size = {0.7, 0.3, 0.2}},
                                              .position = at,
                                              .material = stuff,
                                              .velocity = v});
        (void)w.join(ball, next, pin);
        brick = next;
      }
    }
    tend(w, wall);
    w.synchronize();
    result.before = measure_motion(w).momentum;
    for (int k = 0; k < steps; ++k) w.step(dt);
    const vec3 after = measure_motion(w).momentum;
    real gap = 0;
    auto& joints = detail::state_of(w).joints.template of<ball_joint>();
    const auto place = [&](system_id id) -> std::optional<pose> {
      if (auto b = w.find(handle<sphere>{id})) return pose{b->position(), b->orientation()};
      if (auto b = w.find(handle<box>{id})) return pose{b->position(), b->orientation()};
      return std::nullopt;
    };
    for (const auto& r : joints.records) {
      const auto a = place(r.key.a), b = place(r.key.b);
      if (a && b) {
        const vec3 x = a->to_world(r.anchors.frames.on_a);
        gap = std::max(
            gap, (detail::seen_from(detail::state_of(w), x, b->to_world(r.anchors.frames.on_b)) - x)
                     .norm());
      }
    }
    w.link().reduce(reduction::max, std::span<double>(&gap, 1));
    const std::string digest = state_digest(w);
    if (link.rank() == 0) result.digest = digest, result.after = after, result.gap = gap;
  });
  return result;
}
template <class Scenario, class Decomposition>
outcome run_row(const Decomposition& d, int ranks, int steps, real dt, const vec3& gravity) {
  return run_row<Scenario>(d, ranks, steps, dt, gravity, [](auto&, auto) {});
}

[[nodiscard]] inline cells square_cells(int ranks) {
  const int x = ranks == 1 ? 1 : 2;
  return {.cells = {x, ranks / x}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
}

template <class... Policies>
using row = scenario<bodies<sphere, box>, joints<ball_joint>, transport<threads>, Policies...>;

/// Momentum is conserved in free flight and the joints hold, in flight and under gravity.
template <class Scenario>
void holds(real gap, real momentum = 1e-13) {
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    const outcome free = run_row<Scenario>(square_cells(ranks), ranks, 300, 2e-3, {0, 0, 0});
    CHECK((free.after - free.before).norm() < momentum * (1 + free.before.norm()));
    CHECK(free.gap < gap);
    const outcome hung = run_row<Scenario>(square_cells(ranks), ranks, 300, 2e-3, {0, 0, -9.81});
    CHECK(hung.gap < gap);
    CHECK(hung.after != hung.before);
  }
}

}  // namespace joint_row
