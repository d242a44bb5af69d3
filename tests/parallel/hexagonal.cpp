#include "talus/parallel/hexagonal.hpp"

#include "decomposition_laws.hpp"

using namespace talus;
using doctest::Contains;
using laws::decomposition_laws;

namespace {
constexpr real rounding = 4e-15;
}

TEST_CASE("hexagonal cells keep the laws of decompositions at a million hard points") {
  std::size_t tested = 0;
  tested += decomposition_laws(hexagonal<1>{.spacing = 2}, 7, 400'000, rounding);
  tested +=
      decomposition_laws(hexagonal<2>{.spacing = 0.7, .centre = {3, -1, 2}}, 19, 250'000, rounding);
  tested += decomposition_laws(
      hexagonal<1>{.spacing = 5, .centre = {-1, 1, 1}, .axis = {1, 2, -0.5}, .start = {0, 0.3, 1}},
      7, 200'000, rounding);
  tested += decomposition_laws(hexagonal<dynamic>{.spacing = 1e-3, .centre = {1e3, 0, 0}}, 37,
                               50'000, rounding);
  tested += decomposition_laws(hexagonal<5>{.spacing = 10}, 91, 100'000, rounding);
  tested += decomposition_laws(hexagonal<0>{}, 1, 10'000, rounding);
  MESSAGE(tested << " points tested");
  CHECK(tested > 1'000'000);
}

TEST_CASE("hexagonal cells have at most six neighbours, whatever their number") {
  for (const int rings : {1, 2, 5, 9}) {
    const auto cells =
        hexagonal<dynamic>{.rings = rings, .spacing = 3}.resolve(hexagonal_cells::size_of(rings));
    std::size_t most = 0, corners = 0;
    for (int r = 0; r < cells.size(); ++r) {
      const auto near = cells.neighbours(r, 0);
      most = std::max(most, near.size());
      corners += near.size() == 3;
      for (const int other : near)
        CHECK((cells.centre(r) - cells.centre(other)).norm() == doctest::Approx(3));
      CHECK(cells.owner(cells.centre(r)) == r);
      CHECK(hexagonal_cells::rank_of(cells.place_of(r)) == r);
    }
    CHECK(most == 6);
    CHECK(corners == 6);
  }
}

TEST_CASE("ranks count ring by ring from the start, and the rings are hexagons") {
  const auto cells = hexagonal<2>{.spacing = 1}.resolve(19);
  CHECK(cells.neighbours(0, 0) == std::vector<int>{1, 2, 3, 4, 5, 6});
  CHECK((cells.centre(1) - vec3(1, 0, 0)).norm() < 1e-15);
  CHECK((cells.centre(2) - vec3(0.5, std::sqrt(0.75), 0)).norm() < 1e-15);
  CHECK((cells.centre(7) - vec3(2, 0, 0)).norm() < 1e-15);
  CHECK((cells.centre(8) - vec3(1.5, std::sqrt(0.75), 0)).norm() < 1e-15);
  CHECK(cells.neighbours(7, 0) == std::vector<int>{1, 8, 18});
}

TEST_CASE("a point belongs to the nearest centre, and of several to the lowest rank") {
  const auto cells = hexagonal<3>{.spacing = 1.7, .centre = {0.3, 0.1, -5}}.resolve(37);
  laws::hard_points source({}, 99);
  laws::tally nearest("the owner's centre is the nearest");
  for (int i = 0; i < 100'000; ++i) {
    const vec3 p = 5 * source.anywhere();
    const int owner = cells.owner(p);
    const auto distance = [&](int r) {
      const vec3 d = cells.centre(r) - p;
      return std::hypot(d[0], d[1]);
    };
    for (int r = 0; r < 37; ++r)
      nearest.expect(distance(owner) <= distance(r) + 1e-13, [&] { return laws::show(p); });
  }
  const auto unit = hexagonal<1>{.spacing = 1}.resolve(7);
  CHECK(unit.owner({0.5, 0, 0}) == 0);
  CHECK(unit.owner({std::nextafter(0.5, 1.0), 0, 0}) == 1);
  CHECK(unit.owner({-0.5, 0, 7}) == 0);
  CHECK(unit.owner({0, 5, 7}) == 2);
  CHECK(unit.owner({std::nextafter(-0.0, -1.0), 5, 7}) == 2);
  CHECK(unit.owner({-1e-15, 5, 7}) == 3);
}

TEST_CASE("a reach connects hexagonal cells beyond the next") {
  const hexagonal<3> d{.spacing = 2};
  const auto cells = d.resolve(37);
  CHECK(cells.neighbours(0, 0.5).size() == 6);
  CHECK(cells.neighbours(0, 1.2).size() == 12);  // those whose corners point this way
  CHECK(cells.neighbours(0, 2.01).size() == 18);
  CHECK(domain<hexagonal<3>>(d, 0, 37, 1.2).connections().size() == 12);
}

TEST_CASE("a wrong hexagonal decomposition is refused with its numbers") {
  const auto refuses = [](auto action, const char* text) {
    CHECK_THROWS_WITH_AS((void)action(), Contains(text), std::invalid_argument);
  };
  refuses([] { return hexagonal<2>{.spacing = 1}.resolve(7); },
          "18 hexagonal cell(s) in 2 ring(s) around one need exactly 19 ranks, but there are 7");
  refuses([] { return hexagonal<2>{.spacing = 1}.resolve(7); },
          "start the program with 19, or use hexagonal<dynamic>, which fits");
  refuses([] { return hexagonal<dynamic>{.spacing = 1}.resolve(8); }, "but there are 8");
  // A user of hexagonal<dynamic> is not advised to use it.
  refuses([] { return hexagonal<dynamic>{.spacing = 1}.resolve(8); },
          "but there are 8 ranks: start the program with 7 or 19");
  refuses([] { return hexagonal<dynamic>{.rings = 3, .spacing = 1}.resolve(8); },
          "or leave .rings out, so that they follow from the ranks");
  refuses([] { return hexagonal<dynamic>{.rings = 3, .spacing = 1}.resolve(8); }, "exactly 37");
  refuses([] { return hexagonal<1>{}.resolve(7); }, ".spacing of the cells of hexagonal must be");
  refuses([] { return hexagonal<1>{.spacing = -1}.resolve(7); }, "but is -1");
  refuses([] { return hexagonal<1>{.rings = 2, .spacing = 1}.resolve(7); },
          "says 1 for its rings, but .rings is 2");
  refuses([] { return hexagonal<1>{.spacing = 1, .axis = {0, 0, 0}}.resolve(7); }, ".axis");
  refuses(
      [] {
        return hexagonal<1>{.spacing = 1, .start = {0, 0, 2}}.resolve(7);
      },
      "along its axis");
  CHECK(hexagonal<dynamic>{}.size() == 0);
  CHECK(hexagonal<5>{}.size() == 91);
}
