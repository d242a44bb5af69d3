#include "talus/parallel/grid.hpp"

#include "decomposition_laws.hpp"

using namespace talus;
using doctest::Contains;
using laws::decomposition_laws;

TEST_CASE("a grid keeps the laws of decompositions at millions of hard points") {
  std::size_t tested = 0;
  tested += decomposition_laws(grid<2>{}, 2, 400'000);
  tested += decomposition_laws(grid<2, 2>{.lower = {-30, -30}, .upper = {30, 30}}, 4, 600'000);
  tested += decomposition_laws(grid<2, 3>{.cuts = {{0}, {-1, 1}}}, 6, 400'000);
  tested += decomposition_laws(grid<3, 3, 3>{.lower = {0, 0, 0}, .upper = {1, 1, 1}}, 27, 400'000);
  tested +=
      decomposition_laws(grid<1, 1, 5>{.lower = {.z = -0.7}, .upper = {.z = 0.1}}, 5, 200'000);
  tested += decomposition_laws(
      grid<dynamic, dynamic>{.lower = {-1e-3, 1e6}, .upper = {1e-3, 1e6 + 1}}, 12, 200'000);
  tested += decomposition_laws(
      grid<4, 2>{.cuts = {{-1e200, std::nextafter(-0.3, -1.0), -0.3}, {5e-324}}}, 8, 200'000);
  tested += decomposition_laws(grid<1>{}, 1, 10'000);
  MESSAGE(tested << " points tested");
  CHECK(tested > 2'000'000);
}

TEST_CASE("many ranks: a grid of 10 x 10 connects each to its neighbours, whatever the number") {
  decomposition_laws(grid<10, 10>{.lower = {0, 0}, .upper = {10, 10}}, 100, 20'000);
  const grid_cells small = grid<3, 3>{.lower = {0, 0}, .upper = {3, 3}}.resolve(9);
  const grid_cells large = grid<10, 10>{.lower = {0, 0}, .upper = {10, 10}}.resolve(100);
  CHECK(small.neighbours(4, 0).size() == 8);
  CHECK(large.neighbours(44, 0).size() == 8);
  CHECK(large.neighbours(44, 1.0).size() == 24);
  CHECK(large.neighbours(0, 0) == std::vector<int>{1, 10, 11});
}

TEST_CASE("a point on a cut belongs to the upper cell") {
  const grid_cells cells = grid<2, 2>{}.resolve(4);
  CHECK(cells.owner({0, 0, 5}) == 3);
  CHECK(cells.owner({-0.0, -0.0, 5}) == 3);
  CHECK(cells.owner({-5e-324, 0, 5}) == 2);
  CHECK(cells.owner({0, -5e-324, 5}) == 1);
  CHECK(cells.owner({-1, -1, 5}) == 0);
}

TEST_CASE("cells at the border are unbounded and have fewer planes") {
  const grid_cells cells = grid<3, 3, 3>{.lower = {0, 0, 0}, .upper = {3, 3, 3}}.resolve(27);
  CHECK(cells.geometry(0).planes().size() == 3);
  CHECK(cells.geometry(13).planes().size() == 6);
  CHECK(cells.owner({-1e300, -1e300, -1e300}) == 0);
  CHECK(grid<1>{}.resolve(1).geometry(0) == any_geometry());
}

TEST_CASE("run-time extents come from cells, cuts or the number of ranks") {
  using cells = std::array<int, 3>;
  const auto balanced = [](int ranks) {
    return grid<dynamic>{.lower = {0, 0, 0}, .upper = {1, 1, 1}}.resolve(ranks).cells();
  };
  CHECK(balanced(1) == cells{1, 1, 1});
  CHECK(balanced(7) == cells{7, 1, 1});
  CHECK(balanced(12) == cells{3, 2, 2});
  CHECK(balanced(24) == cells{4, 3, 2});
  CHECK(balanced(1000) == cells{10, 10, 10});
  CHECK(grid<dynamic, dynamic>{.lower = {0, 0}, .upper = {1, 1}}.resolve(24).cells() ==
        cells{6, 4, 1});
  CHECK(grid<dynamic, 1, 1>{.lower = {0}, .upper = {1}}.resolve(6).cells() == cells{6, 1, 1});
  CHECK(grid<2, dynamic>{.lower = {0, 0}, .upper = {1, 1}}.resolve(6).cells() == cells{2, 3, 1});
  CHECK(grid<dynamic>{{4, 2, 1}, {0}, {1}}.resolve(8).cells() == cells{4, 2, 1});
  CHECK(grid<dynamic>{{4, 2, 1}}.size() == 8);
  CHECK(grid<dynamic>{}.size() == 0);
  CHECK(grid<dynamic, dynamic>{.cuts = {{1, 2}}}.resolve(6).cells() == cells{3, 2, 1});
  CHECK(grid<2, 3>{}.size() == 6);
}

TEST_CASE("equal cells are cut evenly between the bounds") {
  const grid_cells cells = grid<4>{.lower = {-30}, .upper = {30}}.resolve(4);
  CHECK(cells.cuts()[0] == std::vector<real>{-15, 0, 15});
}

TEST_CASE("ill-defined grids are refused with the axis, the values and the remedy") {
  const real nan = std::nan(""), inf = std::numeric_limits<real>::infinity();
  const auto refuses = [](const auto& grid, int ranks, const char* text) {
    CHECK_THROWS_WITH_AS((void)grid.resolve(ranks), Contains(text), std::invalid_argument);
  };
  refuses(grid<2, 2>{}, 6, "a grid of 2 x 2 x 1 cells needs exactly 4 ranks, but there are 6");
  refuses(grid<2, dynamic>{}, 5,
          "a grid of 2 x ? x 1 cells needs a multiple of 2 ranks, but there are 5");
  refuses(grid<3>{}, 3, "3 cells along x, but no bounds or cuts");
  refuses(grid<2, 2>{.lower = {1, 0}, .upper = {1, 1}}, 4,
          "along x with lower < upper, but they are 1 and 1");
  refuses(grid<2, 2>{.lower = {0, 2}, .upper = {1, 1}}, 4,
          "along y with lower < upper, but they are 2 and 1");
  refuses(grid<2>{.lower = {0}}, 2, "along x with lower < upper, but they are 0 and nan");
  refuses(grid<2>{.lower = {0}, .upper = {inf}}, 2, "finite bounds along x");
  refuses(grid<2>{.lower = {-1e308}, .upper = {1e308}}, 2, "finite bounds along x");
  refuses(grid<3>{.cuts = {{1, 0}}}, 3, "cut 1 is 0 after 1; sort them");
  refuses(grid<3>{.cuts = {{1, 1}}}, 3, "strictly increasing");
  refuses(grid<3>{.cuts = {{0, nan}}}, 3, "cut 1 is nan");
  refuses(grid<2>{.cuts = {{-inf}}}, 2, "cut 0 is -inf");
  refuses(grid<2>{.cuts = {{1, 2}}}, 2, "2 cells along x need 1 cut(s), but 2 are given");
  refuses(grid<2>{.lower = {0}, .upper = {1}, .cuts = {{1}}}, 2, "both bounds and cuts along x");
  refuses(grid<8>{.lower = {1}, .upper = {std::nextafter(1.0, 2.0)}}, 8, "strictly increasing");
  refuses(grid<dynamic>{.cells = {-1, 0, 0}}, 2, "at least one cell along x, but .cells says -1");
  refuses(grid<2, 2>{.cells = {4, 1, 1}}, 4, "says 2 cell(s) along x, but .cells says 4");
  refuses(grid<dynamic>{}, 3, "3 cells along x, but no bounds");
  CHECK_THROWS_AS((void)(grid<2>{}.resolve(2).geometry(2)), std::invalid_argument);
}
