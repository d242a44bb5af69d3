// What motors, springs and friction of joints bear, and the energy that they give.
// timeout: 300
#include <unistd.h>

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/constraint/cylindrical_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/universal_joint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/joints.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/plane.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <type_traits>
#include <vector>

using namespace talus;

namespace {

using machine =
    scenario<bodies<box, cylinder, plane>, joints<hinge, cylindrical_joint, universal_joint>,
             decomposition<grid<dynamic>>, transport<threads>,
             features<energy_ledger, checkpoints>>;

constexpr real g = 9.81;
const box brick{.size = {0.6, 0.4, 0.2}};
constexpr real mass = 0.6 * 0.4 * 0.2;

[[nodiscard]] std::string file_of(const char* name) {
  return (std::filesystem::temp_directory_path() /
          ("talus_" + std::to_string(::getpid()) + name + ".h5"))
      .string();
}

/// Two bricks, on different ranks if there are two, with a hinge between them.
struct pair_of_bricks {
  std::optional<handle<box>> left, right;
  template <class World>
  pair_of_bricks(World& w, material_id stuff) {
    left = w.add_if_local(body{.shape = brick, .position = {-0.4, 0, 0}, .material = stuff});
    right = w.add_if_local(body{.shape = brick, .position = {0.4, 0, 0}, .material = stuff});
  }
};

template <class Solver>
using car = scenario<bodies<box, cylinder, plane>, joints<hinge>, hard_contact<coulomb_friction>,
                     solver<Solver>, decomposition<grid<dynamic>>, transport<threads>,
                     features<forces, energy_ledger, checkpoints>>;

/// How a car of six wheels rolls, whose motors have one speed.
struct drive {
  int ranks = 1;
  double scale = 1;  ///< of lengths
  double pull = 0;   ///< over the weight of the hull
  std::string restart = {}, keep = {};
};
struct driven_car {
  std::vector<double> torques;  ///< of the motors, over that of the pull for each wheel at the end
  double speed = 0;             ///< over that of rolling
  double power = 0;             ///< of all motors, over that against the pull
  double ledger = 0;
  std::string digest;
};
template <class Solver>
driven_car roll(const drive& how) {
  driven_car result;
  threads::launch({.ranks = how.ranks}, [&](threads::link& link) {
    world<car<Solver>> w(link);
    const double L = how.scale, R = 0.3 * L, spin = 3 / std::sqrt(L);
    w.decompose({.lower = {0}, .upper = {6 * L}}, reach{3 * L});
    w.gravity({0, 0, -g});
    const auto rubber = w.material({.density = 1000, .friction = 0.7});
    w.global([&](auto& scope) { scope.add(plane{}, rubber); });
    const box hull_shape{{2 * L, L, 0.4 * L}};
    const auto hull = w.add_if_local(
        body{.shape = hull_shape, .position = {2.4 * L, 0, R + 0.1 * L}, .material = rubber});
    std::vector<joint_handle<car<Solver>, hinge>> motors;
    for (const double x : {-0.8, 0.1, 0.8})
      for (const double side : {-1., 1.}) {
        const vec3 at((2.4 + x) * L, 0.65 * side * L, R);
        const auto one = w.add_if_local(body{.shape = cylinder{R, 0.2 * L},
                                             .position = at,
                                             .material = rubber,
                                             .orientation = rotation({1, 0, 0}, 0.5 * pi)});
        motors.push_back(w.join(hull, one,
                                hinge{.at = at,
                                      .axis = {0, 1, 0},
                                      .motor = {.velocity = spin, .largest_torque = no_limit}}));
      }
    w.solver().iterations = 20;
    const double weight = 1000 * hull_shape.volume() * g, rolling = spin * R;
    if (!how.restart.empty()) read_checkpoint(w, how.restart);
    const int steps = 600;
    for (int k = static_cast<int>(w.steps()); k < steps; ++k) {
      if (k == steps / 2 && !how.keep.empty()) write_checkpoint(w, how.keep);
      w.for_each_local([&](auto& b) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(b.shape())>, box>)
          b.add_force({-how.pull * weight, 0, 0});
      });
      w.step(2e-3 * std::sqrt(L));
    }
    const double unit = (how.pull > 0 ? how.pull : 1) * weight * R;
    double power = 0;
    std::vector<double> torques;
    for (const auto& m : motors) {
      const joint_reading x = measure_joint(w, m);
      torques.push_back(x.motor.load / unit * static_cast<double>(motors.size()));
      power += x.motor.power;
    }
    double speed = 0;
    w.for_each_local([&](const auto& b) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(b.shape())>, box>)
        speed = b.velocity()[0] / rolling;
    });
    w.link().reduce(reduction::sum, std::span(&speed, 1));
    const energy_balance e = measure_energy(w);
    const std::string digest = state_digest(w);
    if (link.rank() == 0) result = {torques, speed, power / (unit * spin), e.worst, digest};
  });
  return result;
}
void check_equal(const driven_car& x, double mean, double within) {
  for (const double torque : x.torques) CHECK(torque == doctest::Approx(mean).epsilon(within));
  CHECK(x.speed == doctest::Approx(1).epsilon(1e-4));
  CHECK(x.power == doctest::Approx(mean).epsilon(1e-3));
  CHECK(x.ledger < 1e-12);
}

}  // namespace

TEST_CASE("the loads and powers of a hinge, alike on any ranks and after a restart") {
  const std::string file = file_of("joint_loads");
  joint_reading first, restarted;
  for (const int ranks : {1, 2, -2}) {
    CAPTURE(ranks);
    threads::launch({.ranks = std::abs(ranks)}, [&](threads::link& link) {
      world<machine> w(link);
      w.decompose({.lower = {-1}, .upper = {1}}, reach{3});
      const auto stuff = w.material({.density = 1});
      const pair_of_bricks two(w, stuff);
      const auto pin = w.join(two.left, two.right,
                              hinge{.motor = {.velocity = 2, .largest_torque = 0.01},
                                    .spring = {.stiffness = 0.02, .damping = 1e-3, .rest = -0.1},
                                    .friction = 0.002});
      const int steps = 200;
      if (ranks == -2) {
        read_checkpoint(w, file);
      } else {
        for (int k = 0; k < steps; ++k) {
          w.step(1e-3);
          if (k % 50 != 0) continue;
          const joint_reading x = measure_joint(w, pin);
          const energy_balance e = measure_energy(w);
          CHECK(x.motor.load == doctest::Approx(0.01).epsilon(1e-12));
          CHECK(x.friction.load == doctest::Approx(-0.002).epsilon(1e-12));
          CHECK(x.spring.load < -0.02 * 0.1 * 0.99);
          CHECK(x.motor.load + x.spring.load + x.friction.load ==
                doctest::Approx(-x.torque[2]).epsilon(1e-12));
          CHECK(x.motor.power > 0);
          CHECK(x.friction.power < 0);
          CHECK(x.spring.power < 0);
          CHECK(x.second.motor.load == 0);
          CHECK(1e-3 * x.motor.power == doctest::Approx(e.step.motors).epsilon(1e-10));
          CHECK(1e-3 * x.spring.power == doctest::Approx(e.step.springs).epsilon(1e-10));
          CHECK(1e-3 * x.friction.power == doctest::Approx(-e.step.joint_friction).epsilon(1e-10));
          CHECK(e.step.work == 0);
          CHECK(e.kinetic + e.potential ==
                doctest::Approx(e.initial + e.changes + e.total.net()).epsilon(1e-12));
          CHECK(e.worst < 1e-12);
        }
        if (ranks == 2) write_checkpoint(w, file);
      }
      const joint_reading x = measure_joint(w, pin);
      if (link.rank() == 0) (ranks == 1 ? first : restarted) = x;
    });
    if (ranks == 1) continue;
    CHECK(restarted.exists);
    CHECK(restarted.motor.power == doctest::Approx(first.motor.power).epsilon(1e-12));
    CHECK(restarted.spring.load == doctest::Approx(first.spring.load).epsilon(1e-12));
    CHECK(restarted.spring.power == doctest::Approx(first.spring.power).epsilon(1e-12));
    CHECK(restarted.friction.power == doctest::Approx(first.friction.power).epsilon(1e-12));
    restarted = {};
  }
  std::filesystem::remove(file);
}

TEST_CASE("the loads of both coordinates of a joint") {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<machine> w(link);
    w.gravity({0, 0, -g});
    const auto stuff = w.material({.density = 1});
    const auto add = [&](real x) {
      return *w.add_if_local(body{.shape = brick, .position = {x, 0, 0}, .material = stuff});
    };
    const auto lifted =
        w.join(world_frame, add(0),
               cylindrical_joint{.turn_spring = {.stiffness = 0.1, .rest = 0.2},
                                 .travel_motor = {.velocity = 0.5, .largest_force = no_limit},
                                 .travel_friction = 0.1});
    const auto bent = w.join(world_frame, add(3),
                             universal_joint{.at = {3, 0, 0},
                                             .first_axis = {1, 0, 0},
                                             .second_axis = {0, 0, 1},
                                             .first_friction = 5,
                                             .second_spring = {.stiffness = 0.3, .rest = -0.1}});
    for (int k = 0; k < 3; ++k) w.step(1e-3);
    const joint_reading a = measure_joint(w, lifted), b = measure_joint(w, bent);
    CHECK(a.spring.load == doctest::Approx(0.1 * 0.2).epsilon(0.01));
    CHECK(a.spring.power > 0);
    CHECK(a.motor.load == 0);
    CHECK(a.second.motor.load == doctest::Approx(mass * g + 0.1).epsilon(1e-9));
    CHECK(a.second.motor.power == doctest::Approx(0.5 * (mass * g + 0.1)).epsilon(1e-9));
    CHECK(a.second.friction.load == doctest::Approx(-0.1).epsilon(1e-12));
    CHECK(a.second.friction.power == doctest::Approx(-0.05).epsilon(1e-9));
    CHECK(b.second.spring.load == doctest::Approx(-0.3 * 0.1).epsilon(0.01));
    CHECK(b.second.spring.power > 0);
    CHECK(b.spring.load == 0);
    CHECK(lifted.loads(1).motor.load == a.second.motor.load);
  });
}

TEST_CASE_TEMPLATE("motors of wheels with one speed share the load of a car", Solver,
                   nonlinear_gauss_seidel, reproducible) {
  for (const double scale : {1e-3, 1., 1e3}) {
    CAPTURE(scale);
    const driven_car one = roll<Solver>({.scale = scale, .pull = 0.3});
    check_equal(one, 1, 0.01);
  }
  const driven_car free = roll<Solver>({});
  for (const double torque : free.torques) CHECK(std::abs(torque) < 1e-3);
  const std::string file = file_of("joint_loads_car");
  const driven_car one = roll<Solver>({.pull = 0.3}),
                   two = roll<Solver>({.ranks = 2, .pull = 0.3, .keep = file}),
                   restarted = roll<Solver>({.ranks = 2, .pull = 0.3, .restart = file}),
                   gathered = roll<Solver>({.ranks = 1, .pull = 0.3, .restart = file});
  std::filesystem::remove(file);
  for (const driven_car* x : {&two, &restarted, &gathered}) check_equal(*x, 1, 0.01);
  CHECK(restarted.digest == two.digest);
  if constexpr (std::is_same_v<Solver, reproducible>) {
    CHECK(two.digest == one.digest);
    CHECK(gathered.digest == one.digest);
  }
}
