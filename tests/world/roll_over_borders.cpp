// Cylinders roll over seams of flush bodies, on borders of ranks and beside them.
#include <doctest/doctest.h>

#include <algorithm>
#include <mutex>
#include <talus/mesh.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

using scene = scenario<bodies<box, cylinder, convex_polyhedron, triangle_mesh>,
                       decomposition<grid<dynamic, dynamic>>, transport<threads>>;

enum class floor_of { boxes, hulls, meshes };

/// Two floors that meet at x = 0; boxes and hulls are bodies of their ranks.
void put_floor(world<scene>& w, floor_of kind) {
  for (const real x : {-0.25, 0.25}) {
    if (kind == floor_of::boxes)
      w.add_if_local(
          body<box>{.shape = box{{0.5, 0.5, 0.2}}, .position = {x, 0, -0.1}, .fixed = true});
    if (kind == floor_of::hulls) {
      std::vector<vec3> corners;
      for (const real i : {-0.25, 0.25})
        for (const real y : {-0.25, 0.25})
          for (const real z : {-0.2, 0.0}) corners.push_back({x + i, y, z});
      const convex_polyhedron hull(corners);
      const pose at = placed(hull);
      w.add_if_local(body<convex_polyhedron>{
          .shape = hull, .position = at.position, .orientation = at.orientation, .fixed = true});
    }
    if (kind == floor_of::meshes) {
      const vec3 a(x - 0.25, -0.25, 0), b(x + 0.25, -0.25, 0), c(x + 0.25, 0.25, 0),
          d(x - 0.25, 0.25, 0);
      const triangle_mesh mesh({{a, b, c}, {a, c, d}});
      const pose at = placed(mesh);
      w.global([&](auto& scope) {
        scope.add(body<triangle_mesh>{
            .shape = mesh, .position = at.position, .orientation = at.orientation});
      });
    }
  }
}

/// The largest change of a cylinder's velocity over its speed while it rolls over the seam, by its
/// axis parallel to the seam or turned from it.
real change_of_velocity(floor_of kind, int ranks, real border, real turn) {
  const real radius = 0.02, speed = 0.3, dt = 1.0 / 240;
  const vec3 v = rotation({0, 0, 1}, turn) * vec3(speed, 0, 0);
  const auto steps = static_cast<int>(0.1 / (speed * dt));
  std::mutex mutex;
  real change = 0;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scene> w(link,
                   {.cells = {std::min(ranks, 2), ranks == 4 ? 2 : 1},
                    .lower = {border - 1, border / 3 - 1},
                    .upper = {border + 1, border / 3 + 1}},
                   reach{1});
    w.gravity({0, 0, -9.81});
    w.material({.density = 1000, .restitution = 0, .friction = 0.5});
    put_floor(w, kind);
    w.add_if_local(body{.shape = cylinder{radius, 0.05},
                        .position = vec3(0.0013, 0.004, radius) - 0.5 * steps * dt * v,
                        .velocity = v,
                        .angular_velocity = vec3(0, 0, 1).cross(v) / radius,
                        .orientation = rotation({0, 0, 1}, turn) * rotation({1, 0, 0}, pi / 2)});
    for (int k = 0; k < steps; ++k) {
      w.step(dt);
      w.for_each_local([&](const auto& one) {
        if (one.is_fixed()) return;
        const std::lock_guard lock(mutex);
        change = std::max(change, (one.velocity() - v).norm() / speed);
      });
    }
  });
  return change;
}

}  // namespace

TEST_CASE("cylinders keep their speed over seams on a border of ranks and beside it") {
  for (const auto kind : {floor_of::boxes, floor_of::hulls, floor_of::meshes})
    for (const int ranks : {1, 2, 4})
      for (const real border : {0.0, 0.01, -0.03})
        for (const real turn : {0.0, 0.2}) {
          CAPTURE(static_cast<int>(kind));
          CAPTURE(ranks);
          CAPTURE(border);
          CAPTURE(turn);
          CHECK(change_of_velocity(kind, ranks, border, turn) < 1e-6);
        }
}
