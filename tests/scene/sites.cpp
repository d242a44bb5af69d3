#include <doctest/doctest.h>

#include <map>
#include <random>
#include <set>

#include "../vectors.hpp"
#include "talus/geometry/any_geometry.hpp"
#include "talus/geometry/combine.hpp"
#include "talus/scene/lattice.hpp"
#include "talus/scene/ring.hpp"

using namespace talus;

namespace {

constexpr real inf = std::numeric_limits<real>::infinity();
const vec3 everywhere = vec3::Constant(inf);

template <class Sites>
std::vector<site> all_of(const Sites& sites, const vec3& lower = -everywhere,
                         const vec3& upper = everywhere) {
  std::vector<site> list;
  for_each_site(
      sites, lower, upper, [](const vec3&) { return true; },
      [&](const site& s) { list.push_back(s); });
  return list;
}

/// Visits the sites once as a whole and once by parts of space, as ranks do, and compares.
template <class Sites>
std::vector<site> check_partition(const Sites& sites, const std::vector<vec3>& cuts) {
  const auto whole = all_of(sites);
  std::map<std::uint64_t, site> by_index;
  for (const site& s : whole) CHECK(by_index.emplace(s.index, s).second);

  std::vector<std::vector<real>> edges(3);
  for (int a = 0; a < 3; ++a) {
    std::set<real> sorted{-inf, inf};
    for (const vec3& c : cuts) sorted.insert(c[a]);
    edges[a].assign(sorted.begin(), sorted.end());
  }
  std::size_t seen = 0;
  for (std::size_t x = 1; x < edges[0].size(); ++x)
    for (std::size_t y = 1; y < edges[1].size(); ++y)
      for (std::size_t z = 1; z < edges[2].size(); ++z) {
        const vec3 lower(edges[0][x - 1], edges[1][y - 1], edges[2][z - 1]);
        const vec3 upper(edges[0][x], edges[1][y], edges[2][z]);
        const auto owned = [&](const vec3& p) { return at_most(lower, p) && below(p, upper); };
        for_each_site(sites, lower, upper, owned, [&](const site& s) {
          ++seen;
          const auto found = by_index.find(s.index);
          REQUIRE(found != by_index.end());
          CHECK((found->second.position == s.position &&
                 found->second.orientation.coeffs() == s.orientation.coeffs()));
        });
      }
  CHECK(seen == whole.size());
  return whole;
}

template <class Lattice>
real nearest_distance(const Lattice& lattice) {
  const auto sites = all_of(lattice & box_region{{-2.2, -2.2, -2.2}, {2.2, 2.2, 2.2}});
  real least = inf;
  for (std::size_t i = 0; i < sites.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, (sites[i].position - sites[j].position).norm());
  return least;
}

/// The loops of the tutorial's well over the places of its spheres.
std::vector<vec3> tutorial_places(double R, double spacing, double z, std::size_t wanted) {
  std::vector<vec3> places;
  const auto X = static_cast<std::size_t>(std::ceil(1.8 * R / spacing));
  const double start = 0.5 * static_cast<double>(X - 1) * spacing;
  for (double y = -start; places.size() < wanted; y = -start, z += spacing)
    for (std::size_t row = 0; row < X; ++row, y += spacing) {
      double x = -start;
      for (std::size_t column = 0; column < X; ++column, x += spacing)
        if (x * x + y * y <= 0.81 * R * R && places.size() < wanted) places.push_back({x, y, z});
    }
  return places;
}

}  // namespace

TEST_CASE("the well has the places of the tutorial, in its order") {
  const double R = 30, spacing = 2.4, z = 28.2;
  const auto places = tutorial_places(R, spacing, z, 3000);
  const auto sites = all_of(
      (simple_cubic{.spacing = spacing, .origin = {0, 0, z}} & vertical_cylinder{.radius = 0.9 * R})
          .first(3000));
  REQUIRE(sites.size() == places.size());
  REQUIRE(sites.size() == 3000);
  std::map<long, int> layers, expected;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    CHECK((sites[i].position - places[i]).norm() < 1e-10);
    ++layers[std::lround((sites[i].position[2] - z) / spacing)];
    ++expected[std::lround((places[i][2] - z) / spacing)];
  }
  CHECK(layers == expected);
  CHECK(layers.size() == 8);
  CHECK(layers[0] == 401);  // points of the integer grid in a circle of radius 11.25
  CHECK(layers[7] == 3000 - 7 * 401);
}

TEST_CASE("the wall of the well has the bricks of the tutorial") {
  const int B = 40, H = 5;
  const real R = 30, x = std::sqrt(2 * R * R * (1 - std::cos(2 * pi / B))), y = x / 2, z = 0.4 * x;
  const ring_of ring{.count = B, .levels = H, .radius = R + y / 2, .height = z};
  const auto sites = all_of(ring);
  REQUIRE(sites.size() == std::size_t(B * H));
  const quat full = rotation({0, 0, 1}, 2 * pi / B), half = rotation({0, 0, 1}, pi / B);
  for (int h = 0; h < H; ++h) {
    quat turned = h % 2 ? full : half;
    vec3 place = turned * vec3(0, R + y / 2, (h + 0.5) * z);
    for (int i = 0; i < B; ++i) {
      const bool there = std::any_of(sites.begin(), sites.end(), [&](const site& s) {
        return (s.position - place).norm() < 1e-9 && s.orientation.angularDistance(turned) < 1e-6;
      });
      CHECK(there);
      place = full * place;
      turned = full * turned;
    }
  }
}

TEST_CASE("parts of space see every site once, with the index it has in the whole") {
  const std::vector<vec3> cuts{{-5.1, 0, 30}, {0, 4.8, 33.0}, {7.2, 2.4, 28.2}, {1e3, -1e3, 1e4}};
  const simple_cubic cubic{.spacing = 2.4, .origin = {0.3, -0.2, 28.2}};
  const vertical_cylinder shaft{.radius = 13};
  CHECK(check_partition((cubic & shaft).first(500), cuts).size() == 500);
  CHECK(check_partition(
            (cubic & vertical_cylinder{.radius = 13, .lower = 1, .upper = 77}).first(701), cuts)
            .size() == 701);
  check_partition(cubic & box_region{{-10, -9, 20}, {9, 10, 50}}, cuts);
  check_partition(cubic & ball_region{.radius = 11, .centre = {1, 2, 33}}, cuts);
  CHECK(check_partition((cubic & ball_region{.radius = 11, .centre = {1, 2, 33}}).first(100), cuts)
            .size() == 100);
  const hexagonal_close_packed hexagonal{.spacing = 1.7, .origin = {0, 0, 25}};
  CHECK(check_partition((hexagonal & shaft).first(997), cuts).size() == 997);
  check_partition(hexagonal & box_region{{-5, -5, 20}, {5, 7, 40}} & shaft, cuts);
  check_partition(body_centred_cubic{.spacing = 3} & box_region{{-9, -9, 24}, {9, 9, 36}}, cuts);
  check_partition(face_centred_cubic{.spacing = 3} & box_region{{-9, -9, 24}, {9, 9, 36}}, cuts);
  check_partition(ring_of{.count = 37, .levels = 9, .radius = 8, .centre = {0.5, 1, 26}}, cuts);
  check_partition(
      ring_of{.count = 5, .levels = 2, .radius = 8, .centre = {20, -30, 26}, .turn = 7.3}, cuts);
  check_partition(ring_of{.count = 37, .levels = 4, .radius = 9} & half_space(1, 1, 0, 2), cuts);
  check_partition(
      (ring_of{.count = 37, .levels = 4, .radius = 9} & half_space(1, 1, 0, 2)).first(20), cuts);
  check_partition(points({{0, 0, 30}, {-6, 5, 31}, {0, 0, 0}}), cuts);
}

TEST_CASE("first(n) is the beginning of the sites without it, whatever the region") {
  std::mt19937 random(7);
  std::uniform_real_distribution<real> offset(-1, 1);
  INFO("mt19937 with seed 7");
  const auto compare = [&](const auto& sites) {
    const auto whole = all_of(sites);
    REQUIRE(whole.size() > 40);
    for (std::size_t n : {std::size_t{1}, whole.size() / 3, whole.size() - 1, whole.size()}) {
      const auto some = all_of(sites.first(n));
      REQUIRE(some.size() == n);
      for (std::size_t i = 0; i < n; ++i) CHECK(some[i].position == whole[i].position);
    }
    CHECK(all_of(sites.first(0)).empty());
    CHECK_THROWS_AS(all_of(sites.first(whole.size() + 1)), std::invalid_argument);
  };
  for (int i = 0; i < 10; ++i) {
    const vec3 o(offset(random), offset(random), offset(random));
    const box_region box{vec3(-3, -4, -2) + o, vec3(3, 2, 4) - o};
    compare(simple_cubic{.spacing = 1.1, .origin = o} & box);
    compare(hexagonal_close_packed{.spacing = 1, .origin = o} & box);
    compare(face_centred_cubic{.spacing = 1, .origin = o} &
            vertical_cylinder{.radius = 2.5, .centre = -o, .lower = -2 + o[0], .upper = 3});
    compare(body_centred_cubic{.spacing = 1, .origin = o} & ball_region{.radius = 3, .centre = o});
    compare(simple_cubic{.origin = o} & box & half_space(1, 2, 3, -1));
    compare(
        simple_cubic{.origin = o} &
        merge(intersect(half_space(1, 0, 0, 0), half_space(-1, 0, 0, -4), half_space(0, 1, 0, 0),
                        half_space(0, -1, 0, -4), half_space(0, 0, 1, 0), half_space(0, 0, -1, -4)),
              intersect(half_space(1, 0, 0, -3), half_space(-1, 0, 0, -1), half_space(0, 1, 0, -2),
                        half_space(0, -1, 0, -4), half_space(0, 0, 1, -3),
                        half_space(0, 0, -1, -4))));
  }
}

TEST_CASE("indices do not depend on first(n)") {
  const auto sites =
      simple_cubic{.spacing = 1.3} & vertical_cylinder{.radius = 5, .lower = 0, .upper = 9};
  const auto whole = all_of(sites), some = all_of(sites.first(50));
  for (std::size_t i = 0; i < some.size(); ++i) CHECK(some[i].index == whole[i].index);
}

TEST_CASE("lattices have their distances and densities") {
  CHECK(nearest_distance(simple_cubic{}) == doctest::Approx(1));
  CHECK(nearest_distance(body_centred_cubic{}) == doctest::Approx(std::sqrt(0.75)));
  CHECK(nearest_distance(face_centred_cubic{}) == doctest::Approx(std::sqrt(0.5)));
  CHECK(nearest_distance(hexagonal_close_packed{}) == doctest::Approx(1));
  const box_region large{{-20.03, -20.01, -20.02}, {20.01, 20.02, 20.03}};
  const auto density = [&](const auto& lattice) {
    return static_cast<real>(all_of(lattice & large).size()) / std::pow(40.04, 3);
  };
  CHECK(density(simple_cubic{}) == doctest::Approx(1).epsilon(0.1));
  CHECK(density(body_centred_cubic{}) == doctest::Approx(2).epsilon(0.1));
  CHECK(density(face_centred_cubic{}) == doctest::Approx(4).epsilon(0.1));
  CHECK(density(hexagonal_close_packed{}) == doctest::Approx(std::sqrt(2)).epsilon(0.1));
}

TEST_CASE("regions of half-spaces have the bounds their planes give") {
  const auto extent = [](const auto& r) { return detail::extent_of(r); };
  const auto quarter = intersect(half_space(2, 0, 0, 1), half_space(0, -1, 0, 3));
  CHECK(extent(quarter).lower == vec3(1, -inf, -inf));
  CHECK(extent(quarter).upper == vec3(inf, -3, inf));
  CHECK(extent(quarter).prism);
  const any_geometry stored = merge(intersect(half_space(1, 0, 0, 1), half_space(-1, 0, 0, -2)),
                                    intersect(half_space(1, 0, 0, 4), half_space(-1, 0, 0, -5)));
  CHECK(extent(stored).lower == vec3(1, -inf, -inf));
  CHECK(extent(stored).upper == vec3(5, inf, inf));
  CHECK(extent(stored).prism);
  CHECK(extent(intersect(half_space(0, 0, 1, 3), half_space(1, 1, 0, 0))).prism);
  CHECK(!extent(merge(half_space(0, 0, 1, 3), half_space(1, 1, 0, 0))).prism);
  CHECK(!extent(half_space(0, 1, 1, 0)).prism);
  CHECK(extent(half_space(0, 0, -1, -3)).upper == vec3(inf, inf, 3));
  CHECK(extent(any_geometry()).upper == everywhere);
}

TEST_CASE("a rank looks at its own part only") {
  const auto sites =
      (simple_cubic{.spacing = 1} & box_region{{0, 0, 0}, {9.5, 9.5, inf}}).first(100'000'000);
  std::size_t seen = 0;
  sites.for_each_in({-1, -1, 499'999.5}, {4.5, 4.5, 500'000.5}, [&](const site& s) {
    ++seen;
    CHECK(s.position[2] == 500'000);
  });
  CHECK(seen == 25);  // at once: no loop over a million layers
}

TEST_CASE("what has no end is refused with advice") {
  const auto message = [](const auto& sites) {
    try {
      all_of(sites);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("nothing thrown");
  };
  const simple_cubic cubic{.spacing = 1};
  CHECK(message(cubic & vertical_cylinder{.radius = 2}) ==
        "the region to fill has no end in the direction -z: intersect it with a box_region, or end "
        "the sites with .first(n)");
  CHECK(message((cubic & half_space(1, 0, 0, 0)).first(3)) ==
        "the region to fill has no end in the direction +x: intersect it with a box_region");
  CHECK(message(cubic & box_region{{0, 0, 0}, {1, 1e300, 1}}).find("more than the 2^48") !=
        std::string::npos);
  CHECK(message((cubic & vertical_cylinder{.radius = 0.2, .centre = {0.5, 0.5, 0}}).first(3)) ==
        "first(3) asks for more sites than there are, 0: enlarge the region or ask for fewer");
  CHECK(message(points({{0, 0, 0}}).first(2)) ==
        "first(2) asks for more sites than there are, 1: enlarge the region or ask for fewer");
  CHECK(message(ring_of{.count = 0}).find("at least one site") != std::string::npos);
  CHECK_THROWS_WITH_AS((void)(simple_cubic{.spacing = 0} & box_region{{0, 0, 0}, {1, 1, 1}}),
                       "the spacing of a lattice must be positive and finite, but is 0; give a "
                       "positive value",
                       std::invalid_argument);
  const box_region unit{{0, 0, 0}, {1, 1, 1}};
  CHECK_THROWS_AS((void)((cubic & ball_region{}).first(3) & unit), std::invalid_argument);
  CHECK(all_of(cubic & box_region{{1, 1, 1}, {0, 0, 0}}).empty());
}
