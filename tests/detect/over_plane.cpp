// Gaps of bodies over a plane, and the width of polyhedra, for cases with exact values.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <talus/core/random.hpp>
#include <talus/detect/narrow.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <vector>

using namespace talus;

namespace {

std::vector<vec3> corners_of(const vec3& size) {
  std::vector<vec3> corners;
  for (const real x : {-0.5, 0.5})
    for (const real y : {-0.5, 0.5})
      for (const real z : {-0.5, 0.5}) corners.push_back({x * size[0], y * size[1], z * size[2]});
  return corners;
}

/// The least gap is that of the lowest point; contact points lie half way to the plane.
template <class Shape>
void check_over_plane(const Shape& shape) {
  random_stream random(7, 1);
  const plane ground{.normal = {1, 2, 2}, .offset = 0.3};
  const vec3 up = ground.unit_normal();
  for (int k = 0; k < 200; ++k) {
    const pose at{3 * random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1)), random.rotation()};
    const vec3 down = at.orientation.conjugate() * vec3(-up);
    const real lowest = ground.distance(at.position) - down.dot(shape.support(down));
    real least = 1e9;
    bool half_way = true;
    collide_pair(ground, {{0, 0, 0}, {1, 0, 0, 0}}, shape, at, 100, [&](const contact_geometry& g) {
      least = std::min(least, g.gap);
      half_way = half_way && std::abs(ground.distance(g.point) - g.gap / 2) < 1e-12;
    });
    CHECK(least == doctest::Approx(lowest).epsilon(1e-3));
    CHECK(half_way);
  }
}

}  // namespace

TEST_CASE("the gap of a body over a plane is the height of its lowest point") {
  check_over_plane(sphere{0.4});
  check_over_plane(box{{0.4, 0.7, 1.1}});
  check_over_plane(capsule{.radius = 0.3, .length = 0.8});
  check_over_plane(cylinder{.radius = 0.3, .length = 0.8});
  check_over_plane(convex_polyhedron(corners_of({0.4, 0.7, 1.1})));
}

TEST_CASE("the width of a polyhedron is the smallest over its faces, in any order of its corners") {
  for (const vec3& size : {vec3(0.4, 0.7, 1.1), vec3(1.1, 0.4, 0.7), vec3(0.7, 1.1, 0.4)})
    CHECK(convex_polyhedron(corners_of(size)).mesh().measured.half_width == doctest::Approx(0.2));
}
