// The broad phase against the sum over all pairs, in all arrangements that are difficult for a
// grid.
#include "talus/detect/hash_grid.hpp"
#include "../generator.hpp"

#include <doctest/doctest.h>

#include <random>
#include <utility>

namespace {

using namespace talus;
using pair_list = std::vector<std::pair<std::size_t, std::size_t>>;

struct cloud {
  std::vector<vec3> centres;
  std::vector<real> reaches;

  void add(const vec3& c, real r) {
    centres.push_back(c);
    reaches.push_back(r);
  }
  [[nodiscard]] std::size_t size() const { return centres.size(); }
};

bool touch(const vec3& a, real ra, const vec3& b, real rb) {
  const vec3 d = a - b;
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= (ra + rb) * (ra + rb);
}

pair_list sorted(pair_list all) {
  std::sort(all.begin(), all.end());
  return all;
}

pair_list brute(const cloud& c) {
  pair_list found;
  for (std::size_t i = 0; i < c.size(); ++i)
    for (std::size_t j = i + 1; j < c.size(); ++j)
      if (touch(c.centres[i], c.reaches[i], c.centres[j], c.reaches[j])) found.push_back({i, j});
  return found;
}

pair_list brute(const cloud& a, const cloud& b) {
  pair_list found;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j)
      if (touch(a.centres[i], a.reaches[i], b.centres[j], b.reaches[j])) found.push_back({i, j});
  return found;
}

hash_grid grid_of(const cloud& c) {
  hash_grid grid;
  grid.build(c.centres, c.reaches);
  return grid;
}

pair_list pairs_of(const hash_grid& grid) {
  pair_list found;
  grid.pairs([&](std::size_t i, std::size_t j) {
    CHECK(i != j);
    found.push_back(std::minmax(i, j));
  });
  return sorted(std::move(found));
}

pair_list pairs_of(const hash_grid& a, const hash_grid& b) {
  pair_list found;
  a.pairs_with(b, [&](std::size_t i, std::size_t j) { found.push_back({i, j}); });
  return sorted(std::move(found));
}

void check_all(const cloud& c) {
  const hash_grid grid = grid_of(c);
  REQUIRE(grid.size() == c.size());
  const pair_list want = brute(c);
  CHECK(pairs_of(grid) == want);  // equal lists: none missing, none twice

  // The two halves of the cloud against each other, both ways.
  cloud even, odd;
  for (std::size_t i = 0; i < c.size(); ++i)
    (i % 3 == 0 ? even : odd).add(c.centres[i], c.reaches[i]);
  CHECK(pairs_of(grid_of(even), grid_of(odd)) == brute(even, odd));
  CHECK(pairs_of(grid_of(odd), grid_of(even)) == brute(odd, even));
}

struct arrangement {
  const char* name;
  real from_size, to_size;  // reaches are uniform in the logarithm
  real spacing;             // edge of the cube over (sum of volumes)^(1/3)
  vec3 origin, squash;
};

const arrangement arrangements[] = {
    {"equal, packed", 1, 1, 1.2, {0, 0, 0}, {1, 1, 1}},
    {"equal, dilute", 1, 1, 20, {0, 0, 0}, {1, 1, 1}},
    {"equal, scattered wide", 1, 1, 3000, {0, 0, 0}, {1, 1, 1}},
    {"one to two", 0.6, 1.2, 1.2, {5, -7, 3}, {1, 1, 1}},
    {"one to ten", 0.1, 1, 1.5, {0, 0, 0}, {1, 1, 1}},
    {"one to a hundred", 0.01, 1, 1, {-20, 3, 8}, {1, 1, 1}},
    {"one to a thousand", 0.001, 1, 0.7, {0, 0, 0}, {1, 1, 1}},
    {"one to a million", 1e-6, 1, 0.7, {0, 0, 0}, {1, 1, 1}},
    {"on a line", 0.5, 1, 1.2, {0, 0, 0}, {40, 0, 0}},
    {"on a line along z, far", 0.5, 1, 40, {0, 1e5, 0}, {0, 0, 40}},
    {"on a slanting line", 0.5, 1, 1.2, {0, 0, 0}, {40, 0.01, 0.01}},
    {"on a sheet", 0.2, 1, 1.2, {0, 0, 0}, {0, 4, 4}},
    {"on a sheet, dilute", 0.2, 1, 1.2, {0, 0, 0}, {60, 0, 60}},
    {"far away", 0.5, 1, 1.2, {1e6, -1e6, 1e6}, {1, 1, 1}},
    {"very far away", 0.5, 1, 20, {1e12, -1e12, 3e11}, {1, 1, 1}},
    {"one cell", 1, 1, 0.05, {0.3, 0.2, -0.1}, {1, 1, 1}},
    {"one point", 0.5, 1, 0, {7, 7, 7}, {1, 1, 1}},
};

}  // namespace

TEST_CASE("the grid finds exactly the pairs that a search over all pairs finds") {
  for (const arrangement& a : arrangements)
    for (const std::uint64_t seed : {1, 2, 3}) {
      INFO("arrangement '" << std::string(a.name) << "', seed " << seed);
      generator random{std::mt19937_64(seed)};
      cloud c;
      const int n = a.spacing < 0.1 ? 60 : 400;
      real volume = 0;
      for (int i = 0; i < n; ++i) {
        const real r = a.from_size * std::pow(a.to_size / a.from_size, random(0, 1));
        volume += 4 * r * r * r;
        c.add(vec3::Zero(), r);
      }
      const real half = real(0.5) * a.spacing * std::cbrt(volume);
      for (vec3& p : c.centres) p = a.origin + random.point(half).cwiseProduct(a.squash);
      check_all(c);
    }
}

TEST_CASE("clusters of small bodies around a few big ones are searched rightly") {
  for (const std::uint64_t seed : {11, 12, 13, 14}) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    cloud c;
    for (int k = 0; k < 5; ++k) {
      const vec3 centre = random.point(1000);
      c.add(centre, random(5, 10));
      for (int i = 0; i < 100; ++i) c.add(centre + random.point(11), random(0.01, 1));
    }
    check_all(c);
  }
}

TEST_CASE("balls on a lattice that just touch, at cell borders, are found") {
  for (const real shift : {0., 0.1, -1. / 3, 1e6, -1e6 - 0.1}) {
    INFO("shift " << shift);
    cloud c;
    for (int x = -3; x < 4; ++x)
      for (int y = -3; y < 4; ++y)
        for (int z = -3; z < 4; ++z) c.add(vec3(2 * x + shift, 2 * y + shift, 2 * z - shift), 1);
    check_all(c);
  }
}

TEST_CASE("few or no bodies, and bodies without extent") {
  check_all({});
  cloud one;
  one.add({1, 2, 3}, 1);
  check_all(one);
  cloud points;
  for (int i = 0; i < 20; ++i) points.add(vec3(i % 5, 0, 0), 0);
  check_all(points);
  points.add({2, 1, 0}, 1);
  check_all(points);

  hash_grid grid = grid_of(points);
  grid.build(std::span<const vec3>{}, std::span<const real>{});
  CHECK(grid.size() == 0);
  grid.pairs([](auto, auto) { FAIL("a pair in an empty grid"); });
}

TEST_CASE("a query finds the balls that touch a ball of any size") {
  for (const arrangement& a : arrangements) {
    INFO("arrangement '" << std::string(a.name) << "', seed 5");
    generator random{std::mt19937_64(5)};
    cloud c;
    for (int i = 0; i < 300; ++i)
      c.add(a.origin + (a.spacing + 1) * random.point(5).cwiseProduct(a.squash),
            a.from_size * std::pow(a.to_size / a.from_size, random(0, 1)));
    const hash_grid grid = grid_of(c);
    for (const real reach : {0., 0.01, 1., 4., 100., 1e9})
      for (int k = 0; k < 5; ++k) {
        const vec3 p = c.centres[k] + random.point(2);
        std::vector<std::size_t> found, want;
        grid.query(p, reach, [&](std::size_t i) { found.push_back(i); });
        std::sort(found.begin(), found.end());
        for (std::size_t i = 0; i < c.size(); ++i)
          if (touch(c.centres[i], c.reaches[i], p, reach)) want.push_back(i);
        CHECK(found == want);
      }
  }
}

TEST_CASE("equal input gives the pairs in equal order, whatever the grid held before") {
  generator random{std::mt19937_64(3)};
  cloud a, b;
  for (int i = 0; i < 500; ++i) a.add(random.point(6), random(0.1, 1));
  for (int i = 0; i < 300; ++i) b.add(random.point(600), random(0.01, 1));
  pair_list fresh, reused;
  grid_of(a).pairs([&](std::size_t i, std::size_t j) { fresh.push_back({i, j}); });
  hash_grid grid = grid_of(b);
  grid.build(a.centres, a.reaches);
  grid.pairs([&](std::size_t i, std::size_t j) { reused.push_back({i, j}); });
  CHECK(!fresh.empty());
  CHECK(fresh == reused);
}

TEST_CASE("similar sizes share one level, very different ones do not") {
  generator random{std::mt19937_64(8)};
  cloud c;
  for (int i = 0; i < 1000; ++i) c.add(random.point(10), random(0.6, 1.2));
  CHECK(grid_of(c).levels() == 1);
  c.add({0, 0, 0}, 3);
  CHECK(grid_of(c).levels() == 2);
  for (int i = 0; i < 1000; ++i) c.add(random.point(100), 3);
  for (int i = 0; i < 1000; ++i) c.add(random.point(9000), 300);
  CHECK(grid_of(c).levels() == 3);
}

TEST_CASE("what no grid can hold is named by its index") {
  const real nan = std::numeric_limits<real>::quiet_NaN(), inf = 1 / real(0);
  const auto index_of = [](const vec3& centre, real reach) {
    cloud c;
    for (int i = 0; i < 7; ++i) c.add(vec3(i, i, i), 0.5);
    c.centres[4] = centre;
    c.reaches[4] = reach;
    try {
      (void)grid_of(c);
    } catch (const unplaceable& error) {
      CHECK(std::string(error.what()).size() > 20);
      return int(error.index);
    }
    return -1;
  };
  CHECK(index_of({1, 2, 3}, 1) == -1);
  CHECK(index_of({1e12, 2, 3}, 1) == -1);
  CHECK(index_of({nan, 2, 3}, 1) == 4);
  CHECK(index_of({1, -inf, 3}, 1) == 4);
  CHECK(index_of({1, 2, 1e200}, 1) == 4);
  CHECK(index_of({1, 2, 3}, nan) == 4);
  CHECK(index_of({1, 2, 3}, inf) == 4);
  CHECK(index_of({1, 2, 3}, -1) == 4);
  hash_grid grid;
  CHECK_THROWS_AS(grid.build(std::vector<vec3>(2), std::vector<real>(3)), std::invalid_argument);
}
