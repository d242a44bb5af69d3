// What motors, springs and friction of joints bear, and the energy that they give.
// timeout: 300
#include <unistd.h>

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/constraint/cylindrical_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/constraint/universal_joint.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/joints.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/plane.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
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
          CHECK(1e-3 * (x.motor.power + x.spring.power + x.friction.power) ==
                doctest::Approx(e.step.work).epsilon(1e-10));
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
