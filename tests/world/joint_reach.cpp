// How far a body reaches by its joints: which copies its neighbours hold.
// timeout: 300
#include <doctest/doctest.h>

#include <algorithm>
#include <span>
#include <string>
#include <talus/constraint/ball_joint.hpp>
#include <talus/constraint/cylindrical_joint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/joints.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

#include "joint_row.hpp"

using namespace talus;
using namespace joint_row;

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
