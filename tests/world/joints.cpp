// Joints in a world: pendulums and chains against closed forms, on any number of ranks.
// timeout: 300
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <string>
#include <talus/constraint/ball_joint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/joints.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

constexpr real g = 9.81;

using lone = scenario<bodies<sphere, box, plane>, joints<ball_joint>, transport<threads>,
                      features<energy_ledger>>;

/// Calls f(world, a material of density 1) on one rank.
template <class Scenario, class F>
void alone(F&& f) {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<Scenario> w(link);
    w.gravity({0, 0, -g});
    const auto stuff = w.material({.density = 1});
    f(w, stuff);
  });
}
template <class World>
handle<sphere> add_wall(World& w, const vec3& at, material_id stuff) {
  handle<sphere> wall;
  w.global([&](auto& scope) { wall = scope.add(sphere{0.1}, stuff, at); });
  return wall;
}

/// The angle of a physical pendulum from the vertical after `time`, by the classical Runge-Kutta
/// method with small steps: k^2 is inertia over mass times arm.
real angle_of_pendulum(real angle, real time, real arm, real inertia_per_mass) {
  const real rate = g * arm / (inertia_per_mass + arm * arm);
  const int n = 100000;
  const real h = time / n;
  real x = angle, v = 0;
  for (int k = 0; k < n; ++k) {
    const auto f = [&](real y) { return -rate * std::sin(y); };
    const real a1 = f(x), v2 = v + h / 2 * a1, a2 = f(x + h / 2 * v), v3 = v + h / 2 * a2,
               a3 = f(x + h / 2 * v2), v4 = v + h * a3, a4 = f(x + h * v3);
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return x;
}

struct swing {
  real angle = 0;         ///< at the end
  real drift = 0;         ///< largest distance of the point of the body from the joint
  real energy_error = 0;  ///< that the ledger leaves, over the energies of a step
  bool gained = false;    ///< energy grew by more than round-off, in sum
};
/// A body on a joint at the origin, released at this angle.
template <class Shape>
swing let_swing(const Shape& shape, real arm, real angle, real dt, real time) {
  swing result;
  alone<lone>([&](auto& w, material_id stuff) {
    const auto wall = add_wall(w, {0, 0, 0}, stuff);
    const quat tilt(std::cos(angle / 2), 0, std::sin(-angle / 2), 0);
    const vec3 at = rotated(tilt, vec3(0, 0, -arm));
    const auto h = *w.add_if_local(
        body{.shape = shape, .position = at, .material = stuff, .orientation = tilt});
    (void)w.join(wall, h, ball_joint{});
    const int steps = static_cast<int>(std::lround(time / dt));
    const auto energy = [&] {
      const auto e = measure_energy(w);
      return e.kinetic + e.potential;
    };
    const real first = energy();
    for (int k = 0; k < steps; ++k) {
      w.step(dt);
      const auto b = w[h];
      const vec3 point = b.position() + rotated(b.orientation(), vec3(0, 0, arm));
      result.drift = std::max(result.drift, point.norm());
      result.gained = result.gained || energy() > first + 1e-9 * std::abs(first);
    }
    const vec3 p = w[h].position();
    result.angle = std::atan2(p[0], -p[2]);
    result.energy_error = measure_energy(w).worst;
  });
  return result;
}

}  // namespace

TEST_CASE(
    "a rod and a sphere on a ball joint swing as pendulums, with an error of first order in dt, "
    "and the point of the joint stays") {
  const real time = 1, angle = 1.2;
  const auto check = [&](const auto& shape, real arm, real inertia_per_mass) {
    const real exact = angle_of_pendulum(angle, time, arm, inertia_per_mass);
    std::array<real, 3> error{};
    for (int k = 0; k < 3; ++k) {
      const real dt = 0.002 / (1 << k);
      const swing s = let_swing(shape, arm, angle, dt, time);
      error[static_cast<std::size_t>(k)] = std::abs(s.angle - exact);
      CAPTURE(dt);
      CHECK(error[static_cast<std::size_t>(k)] < 10 * dt);
      CHECK(s.drift < 100 * dt * dt * dt * g / arm * std::sqrt(g / arm) * arm);
      CHECK(s.energy_error < 1e-12);
      CHECK_FALSE(s.gained);
    }
    for (const int k : {0, 1}) {
      const real order =
          std::log2(error[static_cast<std::size_t>(k)] / error[static_cast<std::size_t>(k + 1)]);
      CHECK(order > 0.9);
      CHECK(order < 1.2);
    }
  };
  const box rod{.size = {0.1, 0.1, 1}};
  check(rod, 0.5, rod.inertia()[1]);
  const sphere ball{0.2};
  check(ball, 0.7, ball.inertia()[1]);
}

TEST_CASE("the reactions of a hanging chain of 10 equal the weights below, to 1e-6") {
  alone<lone>([](auto& w, material_id stuff) {
    std::vector<joint_handle<lone, ball_joint>> all;
    std::vector<real> mass;
    handle<sphere> last = add_wall(w, {0, 0, 5}, stuff);
    for (int k = 1; k <= 10; ++k) {
      const sphere link{0.3 + 0.02 * k};
      const auto h =
          *w.add_if_local(body{.shape = link, .position = {0, 0, 5.0 - k}, .material = stuff});
      all.push_back(w.join(last, h, ball_joint{.at = {0, 0, 5.5 - k}}));
      mass.push_back(link.volume());
      last = h;
    }
    for (int k = 0; k < 400; ++k) w.step(1e-3);
    real below = 0;
    for (std::size_t k = all.size(); k-- > 0;) {
      below += mass[k] * g;
      CAPTURE(k);
      // On the first body, which is above.
      CHECK((all[k].force() - vec3(0, 0, -below)).norm() < 1e-6 * below);
      CHECK((all[k].impulse() - 1e-3 * all[k].force()).norm() < 1e-15 * below);
    }
    CHECK((w[last].position() - vec3(0, 0, -5)).norm() < 1e-4);
    CHECK(measure_energy(w).worst < 1e-12);
  });
}

TEST_CASE(
    "with a tolerance the reactions are right after one step, and joints are in the residual") {
  alone<lone>([](auto& w, material_id stuff) {
    w.solver().tolerance = 1e-8;
    std::vector<joint_handle<lone, ball_joint>> all;
    handle<sphere> last = add_wall(w, {0, 0, 5}, stuff);
    for (int k = 1; k <= 6; ++k) {
      const auto h = *w.add_if_local(
          body{.shape = sphere{0.4}, .position = {0, 0, 5.0 - k}, .material = stuff});
      all.push_back(w.join(last, h, ball_joint{.at = {0, 0, 5.5 - k}}));
      last = h;
    }
    w.step(1e-3);
    CHECK(w.convergence().residual <= 1e-8);
    CHECK(w.convergence().iterations <= 2);  // all joints are solved at once
    const real weight = 6 * sphere{0.4}.volume() * g;
    CHECK((all[0].force() - vec3(0, 0, -weight)).norm() < 1e-6 * weight);
    CHECK(measure_residual(w).value < 1e-7);
    w.solver().tolerance = 0;
    w.solver().iterations = 1;
    w.gravity({5, 0, -g});
    w.step(1e-3);
    CHECK(measure_residual(w).value < 1e-12);
  });
}

TEST_CASE("joined bodies have no contacts with each other, and a released joint lets go") {
  alone<lone>([](auto& w, material_id stuff) {
    w.gravity({0, 0, 0});
    const auto add = [&](real x) {
      return *w.add_if_local(body{.shape = sphere{0.5}, .position = {x, 0, 0}, .material = stuff});
    };
    const auto a = add(0), b = add(0.6);
    auto pin = w.join(a, b, ball_joint{.at = {0.3, 0, 0}});
    w[a].set_velocity({0, 0.3, 0});
    for (int k = 0; k < 100; ++k) w.step(1e-2);
    const auto apart = [&] { return (w[b].position() - w[a].position()).norm(); };
    CHECK(std::abs(apart() - 0.6) < 1e-4);
    CHECK(pin.known());
    CHECK(measure_penetration(w).max == 0);
    pin.release();
    CHECK(measure_penetration(w).max == doctest::Approx(0.8).epsilon(1e-3));
    CHECK_FALSE(pin.known());
    CHECK_THROWS_WITH_AS((void)pin.force(), doctest::Contains("does not hold this ball_joint"),
                         std::invalid_argument);
    for (int k = 0; k < 200; ++k) w.step(1e-2);
    CHECK(apart() > 0.99);
    w.release(pin);  // again, without effect
  });
}

namespace {

template <class Solver>
using cable =
    scenario<bodies<sphere, box>, joints<ball_joint>, talus::solver<Solver>,
             decomposition<grid<dynamic, dynamic>>, transport<threads>, features<momentum_balance>>;

using cells = grid<dynamic, dynamic>;
[[nodiscard]] cells square_cells(int ranks) {
  const int x = ranks == 1 ? 1 : ranks == 2 ? 2 : ranks == 9 ? 3 : 2;
  return {.cells = {x, ranks / x}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
}

/// A cable of spheres and boxes across all domains, in motion, with grains that hit it; no forces.
template <class World>
std::vector<joint_handle<typename World::scenario_type, ball_joint>> add_cable(World& w) {
  const auto stuff = w.material({.density = 1, .restitution = 0.3, .friction = 0.3});
  std::vector<joint_handle<typename World::scenario_type, ball_joint>> all;
  std::optional<handle<sphere>> ball;
  std::optional<handle<box>> brick;
  const int links = 14;
  const auto place = [](real k) { return vec3(-3.3 + 0.5 * k, 0.3 * std::sin(k), 0.2 * k); };
  for (int k = 0; k < links; ++k) {
    const bool is_ball = k % 2 == 0;
    const vec3 at = place(k), v(0.5 * std::sin(3.0 * k), 0.6, 0.4 * std::cos(2.0 * k));
    const ball_joint pin{.at = place(k - 0.5)};
    if (is_ball) {
      ball = w.add_if_local(body{.shape = sphere{0.25},
                                 .position = at,
                                 .material = stuff,
                                 .velocity = v,
                                 .angular_velocity = {0.3, 0.2, 1}});
      if (k > 0) all.push_back(w.join(brick, ball, pin));
    } else {
      brick = w.add_if_local(body{
          .shape = box{.size = {0.4, 0.3, 0.2}}, .position = at, .material = stuff, .velocity = v});
      all.push_back(w.join(ball, brick, pin));
    }
    w.add_if_local(body{.shape = sphere{0.2},
                        .position = at + vec3(0.1, -0.9, 0.1),
                        .material = stuff,
                        .velocity = {0, 2, 0}});
  }
  return all;
}

struct cable_end {
  std::string digest;
  vec3 before{0, 0, 0}, after{0, 0, 0};
  real gained = 0;          ///< kinetic energy
  std::uint64_t moved = 0;  ///< bodies that changed ranks
  std::size_t known = 0;    ///< joints on this and on other ranks, in sum
};
template <class Solver>
cable_end run_cable(int ranks, int steps) {
  cable_end end;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<cable<Solver>> w(link, square_cells(ranks));
    const auto pins = add_cable(w);
    w.synchronize();
    const auto before = measure_motion(w);
    for (int k = 0; k < steps; ++k) w.step(2e-3);
    const auto after = measure_motion(w);
    std::array<double, 1> known{0};
    for (const auto& p : pins) known[0] += p.known();
    w.link().reduce(reduction::sum, std::span<double>(known));
    const std::string digest = state_digest(w);
    if (link.rank() != 0) return;
    end = {digest,
           before.momentum,
           after.momentum,
           after.kinetic_energy - before.kinetic_energy,
           0,
           static_cast<std::size_t>(known[0])};
  });
  return end;
}

}  // namespace

TEST_CASE("a cable across ranks conserves momentum to round-off, and gains no energy") {
  for (const int ranks : {1, 2, 4, 9}) {
    CAPTURE(ranks);
    const cable_end end = run_cable<nonlinear_gauss_seidel>(ranks, 500);
    CHECK((end.after - end.before).norm() < 1e-13 * (1 + end.before.norm()));
    CHECK(end.gained < 0);
    CHECK(end.known >= 13);
    if (ranks == 1) CHECK(end.known == 13);
    if (ranks > 1) CHECK(end.known > 13);  // some joints are between ranks
  }
}

TEST_CASE("with solver<reproducible> a cable has one digest on 1, 2, 4 and 9 ranks") {
  const cable_end one = run_cable<reproducible>(1, 500);
  CHECK((one.after - one.before).norm() < 1e-13 * (1 + one.before.norm()));
  for (const int ranks : {2, 4, 9}) {
    CAPTURE(ranks);
    const cable_end many = run_cable<reproducible>(ranks, 500);
    CHECK(many.digest == one.digest);
    CHECK((many.after - many.before).norm() < 1e-13 * (1 + many.before.norm()));
  }
}

TEST_CASE("all ranks read the same force of a joint, and the same errors of all joints") {
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    world<cable<nonlinear_gauss_seidel>> w(link, square_cells(4));
    w.gravity({0, 0, -g});
    const auto stuff = w.material({.density = 1});
    const auto a =
        w.add_if_local(body{.shape = sphere{0.2}, .position = {-0.3, 1, 0}, .material = stuff});
    const auto b =
        w.add_if_local(body{.shape = sphere{0.2}, .position = {0.3, 1, 0}, .material = stuff});
    auto pin = w.join(world_frame, a, ball_joint{.at = {-0.3, 1, 0}});
    (void)w.join(world_frame, b, ball_joint{.at = {0.3, 1, 0}});
    (void)w.join(a, b, ball_joint{.at = {0, 1, 0}});
    CHECK(measure_joint(w, pin).exists);
    CHECK(measure_joint(w, pin).force == vec3(0, 0, 0));
    for (int k = 0; k < 20; ++k) w.step(1e-3);
    const real weight = sphere{0.2}.volume() * g;
    CHECK((measure_joint(w, pin).force - vec3(0, 0, -weight)).norm() < 1e-6 * weight);
    const joint_errors errors = measure_joints(w);
    CHECK(errors.joints == 3);
    CHECK(errors.gap < 1e-9);
    CHECK(errors.angle == 0);
    if (a) w[*a].translate({0, 0, 0.01});
    CHECK(measure_joints(w).gap == doctest::Approx(0.01).epsilon(1e-6));
    pin.release();
    CHECK_FALSE(measure_joint(w, pin).exists);
    CHECK(measure_joints(w).joints == 2);
  });
}

TEST_CASE("a joint that is longer than connections reach is refused, and works with that reach") {
  const auto run = [](real connections) {
    threads::launch({.ranks = 4}, [&](threads::link& link) {
      world<cable<nonlinear_gauss_seidel>> w(
          link, cells{.cells = {4, 1}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}},
          reach{connections});
      const auto stuff = w.material({});
      const auto add = [&](real x, real v) {
        return w.add_if_local(body{
            .shape = sphere{0.1}, .position = {x, 0, 0}, .material = stuff, .velocity = {0, v, 0}});
      };
      const auto a = add(-3, 0.5), b = add(3, -0.5);
      const auto bar = w.join(a, b, ball_joint{.at = {0, 1, 0}});
      for (int k = 0; k < 200; ++k) w.step(5e-3);
      // The ends turn about the joint, which the bodies carry: its two arms stay long.
      if (a) {
        const auto body = w.find(*a);
        if (body) CHECK(bar.known() == !body->is_remote());
      }
    });
  };
  CHECK_THROWS_WITH_AS(run(0), doctest::Contains("connect ranks within 7.9"), std::runtime_error);
  CHECK_NOTHROW(run(8));
}

TEST_CASE("wrong joints are refused in words, alike on all ranks") {
  threads::launch({.ranks = 2}, [](threads::link& link) {
    world<cable<nonlinear_gauss_seidel>> w(link, square_cells(2));
    const auto stuff = w.material({});
    const auto add = [&](real x, bool fixed) {
      return w.add_if_local(
          body{.shape = sphere{0.1}, .position = {x, 0, 0}, .material = stuff, .fixed = fixed});
    };
    const auto a = add(-1, false), b = add(1, false), rock = add(-2, true), cliff = add(2, true);
    const ball_joint pin{.at = {0, 0, 0}};
    const std::optional<handle<sphere>> nobody, gone(handle<sphere>{system_id{77}});
    CHECK_THROWS_WITH_AS((void)w.join(a, gone, pin),
                         doctest::Contains("no rank knows the sphere 0x4d, the second body"),
                         std::invalid_argument);
    CHECK_THROWS_WITH_AS((void)w.join(nobody, a, pin),
                         doctest::Contains("join was called without the first body"),
                         std::invalid_argument);
    CHECK_THROWS_WITH_AS((void)w.join(a, a, pin), doctest::Contains("as both bodies"),
                         std::invalid_argument);
    CHECK_THROWS_WITH_AS((void)w.join(rock, cliff, pin),
                         doctest::Contains("two bodies that cannot move"), std::invalid_argument);
    CHECK_THROWS_WITH_AS((void)w.join(w.rank() == 0 ? a : b, w.rank() == 0 ? gone : b, pin),
                         doctest::Contains("different handles of the first body"),
                         std::invalid_argument);
    CHECK_THROWS_WITH_AS((void)w.join(a, b, ball_joint{.at = {std::nan(""), 0, 0}}),
                         doctest::Contains("the point of a ball_joint must be finite"),
                         std::invalid_argument);
    w.exclusive(0, [&] {
      CHECK_THROWS_WITH_AS((void)w.join(a, b, pin),
                           doctest::Contains("join was called inside an exclusive section"),
                           std::runtime_error);
    });
    auto good = w.join(a, rock, pin);
    w.exclusive(0, [&] {
      CHECK_THROWS_WITH_AS(good.release(),
                           doctest::Contains("release was called inside an exclusive section"),
                           std::runtime_error);
    });
    if (a)
      CHECK_THROWS_WITH_AS(w.destroy(*a), doctest::Contains("release its joints first"),
                           std::logic_error);
    good.release();
    if (a) CHECK_NOTHROW(w.destroy(*a));
  });
}
