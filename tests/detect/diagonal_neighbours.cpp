// Bodies that share an edge, as diagonal neighbours in a wall.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/detect/collide_pair.hpp>
#include <talus/detect/pairs/box_box.hpp>
#include <talus/detect/pairs/convex_convex.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <vector>

#include "../generator.hpp"

using namespace talus;

namespace {

convex_polyhedron block(const vec3& edges) {
  std::vector<vec3> corners;
  for (const real x : {-0.5, 0.5})
    for (const real y : {-0.5, 0.5})
      for (const real z : {-0.5, 0.5})
        corners.push_back({x * edges[0], y * edges[1], z * edges[2]});
  return convex_polyhedron(corners);
}
template <class Shape>
std::size_t contacts(const Shape& a, const pose& pa, const Shape& b, const pose& pb) {
  std::size_t count = 0;
  collide_pair(a, pa, b, pb, 1e-3, [&](const contact_geometry&) { ++count; });
  return count;
}

}  // namespace

TEST_CASE("blocks with a common edge or corner do not touch, those with a common face do") {
  generator random{std::mt19937_64(20261201)};
  const vec3 edges(1, 0.6, 0.8);
  const box a(edges);
  const convex_polyhedron b = block(edges);
  for (int k = 0; k < 200; ++k) {
    const quat turn = random.turn();
    const vec3 at = random.point(3);
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const int shifts = std::abs(x) + std::abs(y) + std::abs(z);
          if (shifts == 0) continue;
          const vec3 way(x * edges[0], y * edges[1], z * edges[2]);
          const vec3 noise = random.point(1);
          const pose here{at, turn}, there{at + turn * way + 1e-6 * noise, turn};
          CHECK(contacts(a, here, a, there) == (shifts == 1 ? 4 : 0));
          CHECK(contacts(b, here, b, there) == (shifts == 1 ? 4 : 0));
        }
  }
}

TEST_CASE("a block that overlaps another by a thousandth rests on it") {
  const vec3 edges(1, 1, 1);
  const pose below{vec3(0, 0, 0), quat::Identity()}, above{vec3(0.999, 0, 1), quat::Identity()};
  CHECK(contacts(box(edges), below, box(edges), above) >= 2);
  CHECK(contacts(block(edges), below, block(edges), above) >= 2);
}

TEST_CASE("blocks that approach along a common edge meet with the side that is deeper") {
  const vec3 edges(1, 1, 1);
  const box a(edges);
  const pose here{vec3(0, 0, 0), quat::Identity()},
      there{vec3(1 - 1e-3, 0, 1 - 0.02), quat::Identity()};
  std::size_t count = 0;
  collide_pair(a, here, a, there, 1e-3, [&](const contact_geometry& c) {
    ++count;
    CHECK(std::abs(c.normal[0]) == doctest::Approx(1));
    CHECK(c.gap == doctest::Approx(-1e-3));
  });
  CHECK(count >= 2);
}
