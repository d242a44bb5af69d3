// Joints with the other policies: solvers, precision, periodic space, driven bodies, integrators.
// timeout: 300
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <talus/body/motion.hpp>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/cylindrical_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/joints.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/accelerated_jacobi.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/substepping.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

using namespace talus;

namespace {

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

[[nodiscard]] cells square_cells(int ranks) {
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

}  // namespace

TEST_CASE("joints hold with accelerated_jacobi") {
  holds<row<solver<accelerated_jacobi>, decomposition<cells>>>(1e-10);
}
namespace {

using divided = scenario<bodies<sphere, box>, joints<ball_joint, hinge>, transport<threads>,
                         solver<substepping>, decomposition<cells>>;

/// The angular velocity of a box on a hinge to the world after half a second.
real turned(int ranks, int parts, const hinge& how, real before) {
  real spin = 0;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<divided> w(link, square_cells(ranks));
    w.solver().iterations = parts;
    (void)w.material({.density = 1});
    const auto wheel =
        w.add_if_local(body{.shape = box{{1, 2, 0.5}}, .angular_velocity = {0, 0, before}});
    (void)w.join(world_frame, wheel, how);
    for (int k = 0; k < 120; ++k) w.step(1.0 / 240);
    if (const auto b = wheel ? w.find(*wheel) : std::nullopt) spin = b->angular_velocity()[2];
  });
  return spin;
}

}  // namespace

TEST_CASE("joints hold with substepping") { holds<divided>(2e-3); }

TEST_CASE("with substepping, motors and friction have their torque and springs their stiffness") {
  const real inertia = (1 + 4) / 12.0, torque = 0.6;  // of a mass of 1
  for (const int ranks : {1, 4})
    for (const int parts : {1, 5, 50}) {
      CAPTURE(ranks);
      CAPTURE(parts);
      const hinge driven{.axis = {0, 0, 1}, .motor = {.velocity = 1e3, .largest_torque = torque}};
      CHECK(turned(ranks, parts, driven, 0) ==
            doctest::Approx(0.5 * torque / inertia).epsilon(1e-9));
      const hinge rough{.axis = {0, 0, 1}, .friction = torque};
      CHECK(turned(ranks, parts, rough, 5) ==
            doctest::Approx(5 - 0.5 * torque / inertia).epsilon(1e-9));
      // A quarter of a period, whose speed at its end is the largest.
      const real stiffness = inertia * pi * pi;
      const hinge wound{.axis = {0, 0, 1}, .spring = {.stiffness = stiffness, .rest = 0.2}};
      CHECK(turned(ranks, parts, wound, 0) == doctest::Approx(0.2 * pi).epsilon(0.02));
    }
}
TEST_CASE("joints hold in mixed precision") {
  holds<row<precision<mixed_precision>, decomposition<cells>>>(1e-9, 1e-5);
}
TEST_CASE("joints hold with a solver on request") {
  using scene = row<solver<nonlinear_gauss_seidel, reproducible>, decomposition<cells>>;
  holds<scene>(1e-10);
  std::string one;
  for (const int ranks : {1, 4}) {
    const auto request = [](auto& w, auto) { w.use_solver_on_request(); };
    const outcome end =
        run_row<scene>(square_cells(ranks), ranks, 300, 2e-3, {0, 0, -9.81}, request);
    if (ranks == 1) one = end.digest;
    CHECK(end.digest == one);
    CHECK(end.gap < 1e-10);
  }
}
TEST_CASE("joints hold in the middle of the step, with one digest on 1 and 4 ranks") {
  using scene = row<solver<reproducible>, integrator<moreau_midpoint>, decomposition<cells>>;
  holds<scene>(1e-10);
  CHECK(run_row<scene>(square_cells(1), 1, 300, 2e-3, {0, 0, -9.81}).digest ==
        run_row<scene>(square_cells(4), 4, 300, 2e-3, {0, 0, -9.81}).digest);
}

TEST_CASE("a row flies through the faces of a periodic box, with one digest on 1 and 4 ranks") {
  using torus = periodic<grid<dynamic, dynamic>, along::x, along::y>;
  using scene = row<solver<reproducible>, decomposition<torus>>;
  std::string one;
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    const torus box(grid<dynamic, dynamic>{.cells = {ranks == 1 ? 1 : 2, ranks == 1 ? 1 : 2},
                                           .lower = {.x = -4, .y = -4},
                                           .upper = {.x = 4, .y = 4}});
    const auto fast = [](auto& w, auto) {
      w.for_each_local([](auto& b) { b.set_velocity(b.velocity() + vec3(11, 7, 0)); });
    };
    const outcome end = run_row<scene>(box, ranks, 800, 2e-3, {0, 0, 0}, fast);
    CHECK((end.after - end.before).norm() < 1e-12 * (1 + end.before.norm()));
    CHECK(end.gap < 1e-10);
    if (ranks == 1) one = end.digest;
    CHECK(end.digest == one);
  }
}

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

namespace {

/// A sphere on a ball joint with the world at `pin`, a way of `arm` from it along x, which starts
/// along y. Returns its digest after each step, and the largest gap.
template <class Scenario, class Decomposition>
std::pair<std::vector<std::string>, real> orbit(const Decomposition& d, int ranks, const vec3& pin,
                                                real arm) {
  std::pair<std::vector<std::string>, real> seen;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, d);
    const auto stuff = w.material({.density = 1});
    const auto ball = w.add_if_local(body{.shape = sphere{0.3},
                                          .position = pin + vec3(arm, 0, 0),
                                          .material = stuff,
                                          .velocity = {0, 5 * arm, 0}});
    (void)w.join(world_frame, ball, ball_joint{.at = pin});
    for (int k = 0; k < 300; ++k) {
      w.step(5e-3);
      const real gap = measure_joints(w).gap;
      const std::string digest = state_digest(w);
      if (link.rank() != 0) continue;
      seen.first.push_back(digest), seen.second = std::max(seen.second, gap);
    }
  });
  return seen;
}

}  // namespace

TEST_CASE("a body has no further copies for a joint with the world") {
  using scene = row<decomposition<cells>>;
  const cells four{.cells = {4, 1}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    world<scene> w(link, four);
    const auto stuff = w.material({.density = 1});
    const auto ball = w.add_if_local(body{
        .shape = sphere{0.3}, .position = {-3, 0, 0}, .material = stuff, .velocity = {0, 1, 0}});
    (void)w.join(world_frame, ball, ball_joint{.at = {3, 0, 0}});
    w.step(5e-3);
    double copies = 0;
    w.for_each_known([&](const auto& b) { copies += b.is_remote(); });
    w.link().reduce(reduction::sum, std::span(&copies, 1));
    const auto joints = measure_joints(w).joints;
    if (link.rank() > 0) return;
    CHECK(joints == 1);
    CHECK(copies == 0);
  });
}

TEST_CASE("bodies part by the travel of a cylindrical joint, not by its turns") {
  CHECK(detail::distance_of<cylindrical_joint>({}, {100, 0.5}) == 0.5);
}

TEST_CASE("a joint with the world holds near the corner of a periodic box and across its faces") {
  using torus = periodic<cells, along::x, along::y>;
  using scene = row<decomposition<torus>>;
  const auto box = [](int ranks) { return torus(square_cells(ranks)); };
  const auto one = orbit<scene>(box(1), 1, {3.9, -3.9, 1}, -0.5);
  CHECK(one.second < 1e-12);
  CHECK(orbit<scene>(box(4), 4, {3.9, -3.9, 1}, -0.5) == one);
}
