// Joints with the other solvers.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <string>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/accelerated_jacobi.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/substepping.hpp>
#include <talus/world/world.hpp>

#include "joint_row.hpp"

using namespace talus;
using namespace joint_row;

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
