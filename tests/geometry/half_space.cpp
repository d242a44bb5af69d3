#include "talus/geometry/half_space.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <random>

using namespace talus;
using doctest::Contains;

static_assert(concepts::polyhedral<half_space>);
constexpr half_space fixed(0, 3, 4, 2);
static_assert(fixed == half_space(0, 3, 4, 2).flipped().flipped());
static_assert(fixed.value(0, 3, 4) == 3);
static_assert(half_space(1, 0, 0, 5, 6, 7) == half_space(2, 0, 0, 5));

TEST_CASE("a half-space has the same bits in all its forms, folded or computed") {
  volatile real a = 0.3, b = -0.7, c = 1.9, x = 0.1, y = 2.3, z = -1.7;
  constexpr half_space folded(0.3, -0.7, 1.9, 0.1, 2.3, -1.7);
  CHECK(folded == half_space(a, b, c, x, y, z));
  CHECK(folded == half_space(vec3(real(a), real(b), real(c)), vec3(real(x), real(y), real(z))));
  CHECK(folded.value(1.1, 2.2, 3.3) == half_space(a, b, c, x, y, z).value(vec3(1.1, 2.2, 3.3)));
  CHECK(half_space(1, 1, 0, -2) == half_space(vec3(7, 7, 0), -2.0));
  CHECK(half_space(0.1, 0.2, -0.7, 1) == half_space(0.4, 0.8, -2.8, 1));
  CHECK(half_space(3, 7, 11, 1) == half_space(-15, -35, -55, -1).flipped());
  CHECK(half_space(-0.0, 1, 0, -0.0) == half_space(0, 1, 0, 0));
  CHECK(to_string(half_space(0, -1, 0, -0.0)) == "-y >= 0");
  CHECK(to_string(half_space(0.6, 0, -0.8, 1)) == "0.6 x - 0.8 z >= 1");
}

TEST_CASE("the normal is normalised, the displacement is kept") {
  const half_space h(1, 1, 0, -std::sqrt(2.0));
  CHECK(h.normal().norm() == doctest::Approx(1));
  CHECK(h.displacement() == -std::sqrt(2.0));
  CHECK(h.value({-1, -1, 3}) == doctest::Approx(0));
  CHECK(half_space(h.normal(), h.displacement()) == h);
  CHECK(half_space(3e200, 4e200, 0, 1) == half_space(3, 4, 0, 1));
  CHECK((half_space(3e-200, 4e-200, 0, 1).normal() - vec3(0.6, 0.8, 0)).norm() < 1e-15);
  CHECK((half_space(5e-324, 0, 0, 1).normal() - vec3(1, 0, 0)).norm() == 0);
}

TEST_CASE("both sides see exactly negative values, and own each point once") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<real> u(-2, 2);
  int wrong = 0, on = 0;
  for (int i = 0; i < 200'000; ++i) {
    const vec3 n(u(random), u(random), i % 3 ? u(random) : 0), q(u(random), u(random), u(random));
    const half_space h(n, q), back(-n, q);
    vec3 p(u(random), u(random), u(random));
    if (i % 2) p -= h.value(p) * h.normal();
    on += h.value(p) == 0;
    wrong += h.value(p) != -back.value(p) || h.owns(p) == back.owns(p) || !(back == h.flipped());
    wrong += half_space(h.normal(), h.displacement()) != h;
  }
  CHECK(wrong == 0);
  CHECK(on > 1000);
}

TEST_CASE("a boundary belongs to the side towards +x, then +y, then +z") {
  CHECK(half_space(1, 0, 0, 2).owns({2, 9, 9}));
  CHECK(!half_space(-1, 0, 0, -2).owns({2, 9, 9}));
  CHECK(half_space(-1, 0, 0, -2).contains({2, 9, 9}));
  CHECK(half_space(0, 1, -1, 0).owns({2, 3, 3}));
  CHECK(!half_space(0, -1, 1, 0).owns({2, 3, 3}));
}

TEST_CASE("no point is inside that is not a number") {
  const real nan = std::nan("");
  CHECK(!half_space(1, 0, 0, 0).contains({nan, 0, 0}));
  CHECK(!half_space(1, 0, 0, 0).owns({1, nan, 0}));
}

TEST_CASE("half-spaces without direction or place are refused with their numbers") {
  const real nan = std::nan(""), inf = std::numeric_limits<real>::infinity();
  CHECK_THROWS_WITH_AS(half_space(0, 0, 0, 1), Contains("the normal (0, 0, 0) of a half-space"),
                       std::invalid_argument);
  CHECK_THROWS_AS(half_space(nan, 0, 1, 1), std::invalid_argument);
  CHECK_THROWS_AS(half_space(inf, 0, 1, 1), std::invalid_argument);
  CHECK_THROWS_WITH_AS(half_space(1, 0, 0, nan), Contains("finite displacement, but it is nan"),
                       std::invalid_argument);
  CHECK_THROWS_AS(half_space(1, 0, 0, inf), std::invalid_argument);
  CHECK_THROWS_AS(half_space(1, 0, 0, nan, 0, 0), std::invalid_argument);
}
