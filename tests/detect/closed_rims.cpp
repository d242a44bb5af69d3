// Bodies that reach over the rim of a closed surface of triangles, and lean there: no contact is
// far deeper than they overlap it, and they do not lose their contacts.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <talus/detect/narrow.hpp>
#include <talus/mesh.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

/// A closed cuboid of n x n squares on each face.
triangle_mesh cuboid(const vec3& half, int n) {
  std::vector<triangle_mesh::triangle> all;
  for (int axis = 0; axis < 3; ++axis)
    for (const real sign : {-1., 1.}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto at = [&](int i, int j) {
        vec3 p;
        p[axis] = sign * half[axis];
        p[u] = sign * (real(2) * i / n - 1) * half[u], p[v] = (real(2) * j / n - 1) * half[v];
        return p;
      };
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          all.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
          all.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
  return triangle_mesh(all);
}
convex_polyhedron prism(int sides, real radius, real height) {
  std::vector<vec3> corners;
  for (int k = 0; k < sides; ++k)
    for (const real z : {-0.5, 0.5}) {
      const real turn = 2 * std::numbers::pi * k / sides;
      corners.push_back({radius * std::cos(turn), radius * std::sin(turn), z * height});
    }
  return convex_polyhedron(corners);
}
/// Its top is at z = 0, and its rim at x = 1.
const vec3 table{1, 1, 0.5};

}  // namespace

TEST_CASE(
    "a body that leans over the rim has no contact much deeper than it reaches into the top") {
  for (const int n : {1, 5, 20}) {
    const triangle_mesh m = cuboid(table, n);
    const pose at_table = placed(m, pose{{0, 0, -0.5}, {1, 0, 0, 0}});
    for (unsigned seed = 0; seed < 150; ++seed) {
      std::mt19937 g(seed);
      const auto draw = [&](real low, real high) {
        return std::uniform_real_distribution<real>(low, high)(g);
      };
      const real beyond = draw(-0.3, 0.35), overlap = std::pow(10, draw(-6, -2.5));
      const real tilt = std::pow(10, draw(-6, -1.5)) * (draw(0, 1) < 0.5 ? -1 : 1);
      const quat turn = rotation({0, 0, 1}, draw(0, 1)) * rotation({0, 1, 0}, tilt) *
                        rotation({1, 0, 0}, tilt * draw(-1, 1));
      const auto look = [&](const auto& shape, const quat& lying) {
        CAPTURE(n);
        CAPTURE(seed);
        pose at{{1 + beyond, 0.11, 0}, turn * lying};
        const vec3 down = rotated(at.orientation.conjugate(), vec3(0, 0, -1));
        at.position[2] = -rotated(at.orientation, vec3(shape.support(down)))[2] - overlap;
        collide_pair(m, at_table, shape, at, 0, [&](const contact_geometry& c) {
          CHECK(c.gap > -5 * (overlap + std::abs(tilt)));
        });
      };
      const quat upright(1, 0, 0, 0);
      look(box{{0.8, 0.5, 0.4}}, upright);
      look(cylinder{0.3, 0.4}, upright);
      look(prism(5, 0.4, 0.4), upright);
      look(capsule{0.2, 0.6}, rotation({0, 1, 0}, std::numbers::pi / 2));
    }
  }
}

TEST_CASE("soft bodies whose centre is within the rim rest there, however fine the surface is") {
  using soft = scenario<bodies<box, cylinder, convex_polyhedron, triangle_mesh>,
                        soft_contact<linear_spring_dashpot, coulomb_friction>, transport<serial>>;
  const auto rest = [](const auto& shape, int n, real within) {
    serial::link link;
    world<soft> w(link);
    w.gravity({0, 0, -9.81});
    w.material({.density = 1000, .restitution = 0.3, .friction = 0.6, .stiffness = 1e6});
    const triangle_mesh m = cuboid(table, n);
    const pose at = placed(m, pose{{0, 0, -0.5}, {1, 0, 0, 0}});
    w.global([&](auto& scope) {
      scope.add(body{.shape = m, .position = at.position, .orientation = at.orientation});
    });
    w.add(body{.shape = shape,
               .position = {1 - within, 0.11, 0.2001},
               .orientation = rotation({0, 0, 1}, 0.2)});
    real fastest = 0;
    for (int k = 0; k < 5000; ++k) {
      w.step(1e-4);
      w.for_each_local([&](const auto& b) { fastest = std::max(fastest, b.velocity().norm()); });
    }
    INFO(n, " squares, ", within, " within the rim");
    CHECK(fastest < 0.1);
  };
  for (const int n : {1, 5, 20})
    for (const real within : {0.1, 0.02}) {
      rest(box{{0.8, 0.5, 0.4}}, n, within);
      rest(cylinder{0.3, 0.4}, n, within);
      rest(prism(5, 0.3, 0.4), n, within);
    }
}
