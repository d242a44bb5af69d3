// Joints with the other policies: precision, integrators, periodic space.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <string>
#include <talus/constraint/ball_joint.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

#include "joint_row.hpp"

using namespace talus;
using namespace joint_row;

TEST_CASE("joints hold in mixed precision") {
  holds<row<precision<mixed_precision>, decomposition<cells>>>(1e-9, 1e-5);
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
