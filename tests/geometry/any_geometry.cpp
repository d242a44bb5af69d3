#include "talus/geometry/any_geometry.hpp"

#include <doctest/doctest.h>

#include <random>
#include "../vectors.hpp"

using namespace talus;

namespace {
constexpr half_space a(1, 0, 0, 2), b(0, 1, 0, 1), c(0, 0, 1, 3), d(1, 1, 1, 0);
constexpr auto corner = intersect(a, b);
constexpr auto nested = merge(intersect(a, merge(b, c)), intersect(d, complement(b)), c);
static_assert(complement(complement(nested)) == nested);
static_assert(concepts::polyhedral<any_geometry>);
static_assert(sizeof(corner) == 2 * sizeof(half_space));

std::vector<vec3> points(int n) {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<real> u(-5, 5);
  std::vector<vec3> result;
  for (int i = 0; i < n; ++i) {
    vec3 p(u(random), u(random), u(random));
    if (i % 2) p = rounded(p);
    result.push_back(p);
  }
  return result;
}
}  // namespace

TEST_CASE("the erased form has the values of the typed one, to the bit") {
  const any_geometry erased_corner = corner, erased = nested;
  const any_geometry all_of_it = intersect(), nothing = merge();
  int wrong = 0;
  for (const vec3& p : points(50'000)) {
    wrong += erased_corner.value(p) != corner.value(p) || erased.value(p) != nested.value(p);
    wrong += erased_corner.owns(p) != corner.owns(p) || erased.owns(p) != nested.owns(p);
    wrong += complement(erased).value(p) != -nested.value(p);
    wrong += complement(nested).value(p) != -nested.value(p);
    wrong += complement(erased).owns(p) == nested.owns(p);
    wrong += complement(erased_corner).value(p) != -corner.value(p);
    wrong += !all_of_it.contains(p) || nothing.contains(p);
    wrong += merge(erased, a).value(p) != merge(nested, a).value(p);
  }
  CHECK(wrong == 0);
  CHECK(!erased.contains({std::nan(""), 0, 0}));
  CHECK(!erased_corner.contains({0, std::nan(""), 0}));
}

TEST_CASE("-value is at most the distance from a region, value that from its complement") {
  const any_geometry g = nested;
  const auto far = points(2'000), near = points(300);
  int wrong = 0;
  for (const vec3& p : far)
    for (const vec3& q : near) {
      const real distance = (p - q).norm() + 1e-12;
      if (g.contains(q)) wrong += -g.value(p) > distance;
      if (!g.contains(q)) wrong += g.value(p) > distance;
    }
  CHECK(wrong == 0);
}

TEST_CASE("regions are equal when their canonical forms are") {
  using any = any_geometry;
  CHECK(any(intersect(a, b)) == any(intersect(b, a, b)));
  CHECK(any(intersect(a, intersect(b, c))) == any(intersect(intersect(a, b), c)));
  CHECK(any(merge(a, merge(b, merge(c)))) == any(merge(c, b, a)));
  CHECK(any(intersect(a, b)) != any(merge(a, b)));
  CHECK(any(intersect(a)) == any(a));
  CHECK(any(merge(intersect(merge(a, b)))) == any(merge(a, b)));
  CHECK(any(merge(intersect(a, b), c)) == any(merge(c, intersect(b, a), intersect(a, b))));
  CHECK(any(intersect(a, half_space(1, 0, 0, 5))) == any(half_space(1, 0, 0, 5)));
  CHECK(any(merge(a, half_space(1, 0, 0, 5))) == any(a));
  CHECK(any(intersect(a, merge())) == any(merge()));
  CHECK(any(merge(a, intersect())) == any(intersect()));
  CHECK(any(intersect(a, intersect())) == any(a));
  CHECK(complement(any(intersect(a, b))) == any(merge(complement(a), complement(b))));
  CHECK(complement(complement(any(nested))) == any(nested));
  CHECK(any() == any(intersect()));
  CHECK(any(a) != any(half_space(1, 0, 0, std::nextafter(2.0, 3.0))));
}

TEST_CASE("regions read as they are written") {
  CHECK(to_string(any_geometry(corner)) == "intersect(y >= 1, x >= 2)");
  CHECK(to_string(any_geometry(a)) == "x >= 2");
  CHECK(to_string(any_geometry(intersect(a, merge(b, c)))) ==
        "intersect(x >= 2, merge(z >= 3, y >= 1))");
  CHECK(to_string(any_geometry()) == "all of space");
  CHECK(to_string(complement(any_geometry())) == "nothing");
}

TEST_CASE("regions travel as bytes") {
  for (const any_geometry& g : {any_geometry(), any_geometry(a), any_geometry(corner),
                                any_geometry(nested), any_geometry(merge())}) {
    detail::byte_buffer bytes;
    detail::byte_writer out(bytes);
    g.write(out);
    detail::byte_reader in(bytes);
    CHECK(any_geometry::read(in) == g);
    CHECK(in.empty());
  }
}

TEST_CASE("planes are listed, and nesting has a limit") {
  CHECK(any_geometry(corner).planes().size() == 2);
  CHECK(any_geometry(corner).convex());
  CHECK(!any_geometry(nested).convex());
  any_geometry deep = a;
  const auto nest = [&] {
    for (int i = 0; i < 20; ++i) {
      deep = intersect(deep, half_space(0, 1, 0, i));
      deep = merge(deep, half_space(0, 0, 1, -i));
    }
  };
  CHECK_THROWS_WITH_AS(nest(), doctest::Contains("more than 16 levels"), std::invalid_argument);
}
