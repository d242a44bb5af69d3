// Where lines are inside shapes: the closed forms against the search that knows nothing but the
// support function.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "../generator.hpp"
#include "../vectors.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/capsule.hpp"
#include "talus/shape/convex_polyhedron.hpp"
#include "talus/shape/cylinder.hpp"
#include "talus/shape/detail/support_chord.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/shape/superellipsoid.hpp"

using namespace talus;

namespace {

template <class Shape>
chord searched(const Shape& s, const vec3& p, const vec3& d, int& asked) {
  const auto support = [&](const vec3& u) -> vec3 {
    ++asked;
    return s.support(u);
  };
  return detail::support_chord(support, d, s.bounding_radius()).of(p);
}

template <class Shape>
void test(const Shape& s, std::uint64_t seed) {
  INFO(std::string(Shape::name) << ", seed " << seed);
  generator random{std::mt19937_64(seed)};
  const real r = s.bounding_radius();
  int met = 0, asked = 0, most = 0;
  constexpr int lines = 2000;
  for (int k = 0; k < lines; ++k) {
    const vec3 p = k % 10 == 0 ? vec3(0, 0, 0) : random.point(r);
    const vec3 d = k % 4 == 0 ? vec3(vec3::Unit(k / 4 % 3)) : random.direction();
    CAPTURE(p);
    CAPTURE(d);
    const chord known = s.chord(p, d);
    const int before = asked;
    const chord found = searched(s, p, d, asked);
    most = std::max(most, asked - before);
    if (known.empty() || found.empty()) {  // both, but for lines that graze
      const chord& other = known.empty() ? found : known;
      CHECK((other.empty() || other.to - other.from < 1e-5 * r));
      continue;
    }
    ++met;
    CHECK(std::abs(known.from - found.from) < 2e-9 * r);
    CHECK(std::abs(known.to - found.to) < 2e-9 * r);
  }
  CHECK(met > lines / 50);
  CHECK(asked < 60 * lines);
  CHECK(most < 320);
}

}  // namespace

TEST_CASE("chords agree with those of the support function") {
  test(sphere{1.5}, 1);
  test(ellipsoid{{1, 2, 3}}, 2);
  test(ellipsoid{{1e-3, 0.02, 0.3}}, 3);
  test(box{{1, 2, 3}}, 4);
  test(capsule{1, 2}, 5);
  test(cylinder{1, 2}, 6);
  test(convex_polyhedron({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1.5}, {1, 1, 1}}), 7);
  for (const real n1 : {2., 3., 4., 8.})
    for (const real n2 : {2., 5., 8.}) test(superellipsoid{{1, 2, 3}, n1, n2}, 8);
}

TEST_CASE("a line along the flat side of a superellipsoid has a chord") {
  const superellipsoid s{{1, 2, 3}, 4, 4};
  int met = 0;
  for (int k = 0; k < 2000; ++k) {
    const real x = 0.82 + 1e-5 * k, y = -0.5 + 1e-4 * k, z = -2.56;
    const real rest = 1 - std::pow(x, 4) - std::pow(-z / 3, 4);
    if (rest < 1e-5) continue;
    CAPTURE(x);
    const real half = 2 * std::pow(rest, 0.25);
    const chord c = s.chord({x, y, z}, {0, 1, 0});
    CHECK(c.from == doctest::Approx(-y - half).epsilon(1e-9));
    CHECK(c.to == doctest::Approx(-y + half).epsilon(1e-9));
    ++met;
  }
  CHECK(met > 500);
  // Lines that pass by have none.
  CHECK(s.chord({0.9, -0.5, -2.6}, {0, 1, 0}).empty());
  CHECK(s.chord({1 + 1e-9, 0, 0}, {0, 1, 0}).empty());
}
