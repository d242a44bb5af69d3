#include "talus/parallel/join.hpp"

#include "decomposition_laws.hpp"
#include "talus/parallel/any_decomposition.hpp"
#include "talus/parallel/cells.hpp"
#include "talus/parallel/grid.hpp"
#include "talus/parallel/hexagonal.hpp"
#include "talus/parallel/ring.hpp"
#include "talus/parallel/slabs.hpp"

using namespace talus;
using doctest::Contains;
using laws::decomposition_laws;

namespace {

constexpr real rounding = 4e-15;

/// The stair: sectors about its column, slabs at its foot.
template <int Sectors = dynamic, int Slabs = dynamic>
auto stair(int sectors, int slabs_below) {
  const half_space foot(1, 0, 0, 0), below(0, -1, 0, 0);
  return join(
             ring<Sectors>{
                 .sectors = sectors, .axis = {0, 0, -1}, .start = {-1, 0, 0}, .angle = pi},
             within(
                 intersect(foot, below),
                 slabs<Slabs>{.count = slabs_below, .axis = {0, -1, 0}, .lower = 0, .upper = 20}))
      .closed(intersect(complement(foot), below));
}

/// The outlet: nine columns and seven rows, and one rank for the region below.
const auto outlet = join(grid<9, 1, 7>{.lower = {.x = -9, .z = 0}, .upper = {.x = 9, .z = 14}},
                         within(half_space(0, 0, -1, 0), slabs<1>{}));

}  // namespace

TEST_CASE("joins keep the laws of decompositions at a million hard points") {
  std::size_t tested = 0;
  tested += decomposition_laws(stair<6, 2>(6, 2), 8, 300'000, rounding);
  tested += decomposition_laws(stair(8, 1), 9, 200'000, rounding);
  tested += decomposition_laws(outlet, 64, 100'000);
  tested += decomposition_laws(
      join(hexagonal<1>{.spacing = 4}, within(half_space(0, 0, 1, 5), ring<3>{.centre = {1, 1, 5}}),
           within(half_space(0, 0.6, -0.8, 5), slabs<2>{})),
      12, 200'000, rounding);
  tested +=
      decomposition_laws(join(join(grid<2, 1>{}, within(half_space(0, 0, 1, 1), grid<1, 2>{})),
                              within(half_space(1, 1, 1, 10), slabs<1>{})),
                         5, 200'000, rounding);
  MESSAGE(tested << " points tested");
  CHECK(tested >= 1'000'000);
}

TEST_CASE("joins of decompositions in random places and directions keep the laws") {
  for (int seed = 1; seed <= 24; ++seed) {
    CAPTURE(seed);
    std::mt19937_64 random(seed);
    const auto number = [&] { return static_cast<real>(random() >> 11) * 0x1p-52 - 1; };
    const auto any = [&] { return vec3(number(), number(), number()); };
    const half_space beyond(any(), number());
    if (seed % 2 == 0)
      decomposition_laws(
          join(
              hexagonal<1>{
                  .spacing = 1 + number() / 2, .centre = any(), .axis = any(), .start = any()},
              within(beyond, ring<3>{.axis = any(), .centre = any(), .start = any()})),
          10, 10'000, 2 * rounding);
    else
      decomposition_laws(
          join(ring<5>{.axis = any(), .centre = any(), .start = any(), .angle = 3 + 3 * number()},
               within(intersect(beyond, half_space(any(), number())), slabs<2>{.axis = any()})),
          7, 10'000, 2 * rounding);
  }
}

TEST_CASE("the stair's ranks own what the tutorial's errata settle, and form a chain") {
  for (const auto& [sectors, below] : {std::pair{6, 2}, {8, 1}, {2, 3}, {3, 1}}) {
    CAPTURE(sectors);
    const int ranks = sectors + below;
    const auto cells = stair(sectors, below).resolve(ranks);
    laws::hard_points source({half_space(1, 0, 0, 0), half_space(0, 1, 0, 20)}, 17);
    laws::tally law("owners by angle and by depth");
    for (int i = 0; i < 100'000; ++i) {
      const vec3 p = source.anywhere();
      const real x = p[0], y = p[1], turn = std::atan2(y, -x) / pi * sectors;
      int expected = 0;
      if (y < 0 && x >= 0)
        expected = sectors + std::clamp(static_cast<int>(-y / (20.0 / below)), 0, below - 1);
      else if (y >= 0)
        expected = std::min(static_cast<int>(turn), sectors - 1);
      law.expect(cells.owner(p) == expected, [&] { return laws::show(p); });
    }
    for (int r = 0; r < ranks; ++r) {
      std::vector<int> chain;
      if (r > 0) chain.push_back(r - 1);
      if (r + 1 < ranks) chain.push_back(r + 1);
      CHECK(cells.neighbours(r, 0) == chain);
    }
    CHECK(std::ranges::count(cells.closed(0), sectors) == 1);
  }
  // Spheres are emitted on y = 0, at x < 0, and rank 0 owns {x < 0, y < 0} as well.
  const auto cells = stair(6, 2).resolve(8);
  CHECK(cells.owner({-10, 0, 40}) == 0);
  CHECK(cells.owner({-10, -0.0, 40}) == 0);
  CHECK(cells.owner({-10, -1e-300, 40}) == 0);
  CHECK(cells.owner({-5e-324, -3, 40}) == 0);
  CHECK(cells.owner({0, -5e-324, 0}) == 6);
  CHECK(cells.owner({0, -10, 0}) == 6);
  CHECK(cells.owner({7, std::nextafter(-10.0, -11.0), 0}) == 7);
  CHECK(cells.owner({7, -30, 0}) == 7);
}

TEST_CASE("the outlet's rank 23 has the neighbours of the tutorial's Figure 4") {
  const auto cells = outlet.resolve(64);
  CHECK(cells.neighbours(23, 0) == std::vector<int>{13, 14, 15, 22, 24, 31, 32, 33});
  CHECK(cells.neighbours(63, 0) == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8});
  CHECK(cells.neighbours(0, 0) == std::vector<int>{1, 9, 10, 63});
  CHECK(cells.owner({100, 0, -1e-300}) == 63);
  CHECK(cells.owner({100, 0, 0}) == 8);
  CHECK(cells.geometry(63) == half_space(0, 0, -1, 0));
}

TEST_CASE("a reach goes across the parts of a join") {
  const auto cells = outlet.resolve(64);
  CHECK(cells.neighbours(63, 1.9).size() == 9);
  CHECK(cells.neighbours(63, 2.0).size() == 18);
  CHECK(cells.neighbours(23, 2.0).size() == 24);
  // Closed faces stay closed; the region around the column is open.
  const auto steps = stair(6, 2).resolve(8);
  CHECK(steps.neighbours(5, 11.0) == std::vector<int>{4, 6, 7});
  CHECK(steps.neighbours(7, 11.0) == std::vector<int>{1, 2, 3, 4, 5, 6});
}

TEST_CASE("a decomposition chosen when the program runs offers what the chosen one does") {
  const any_decomposition chosen(stair(6, 2));
  CHECK(decomposition_laws(chosen, 8, 50'000, rounding) == 50'000);
  CHECK(domain<any_decomposition>(chosen, 0, 8).closed().size() == 6);
  const any_decomposition cells(grid<3, 1>{.cuts = {.x = {0, 4}}});
  CHECK(decomposition_laws(cells, 3, 50'000) == 50'000);
  const auto [lower, upper] = domain<any_decomposition>(cells, 1, 3).bounds();
  CHECK(lower[0] == 0);
  CHECK(upper[0] == 4);
  CHECK(upper[1] == std::numeric_limits<real>::infinity());
}

TEST_CASE("one part of a join may leave its size open") {
  const auto open = join(grid<9, 1, dynamic>{.lower = {.x = 0, .z = 0}, .upper = {.x = 9, .z = 3}},
                         within(half_space(0, 0, -1, 0), slabs<1>{}));
  CHECK(open.size() == 0);
  CHECK(open.resolve(28).size() == 28);
  CHECK(outlet.size() == 64);
  CHECK(join<ring<6>, slabs<2>>{}.size() == 8);
}

TEST_CASE("a wrong join is refused with its numbers") {
  const auto refuses = [](auto action, const char* text) {
    CHECK_THROWS_WITH_AS((void)action(), Contains(text), std::invalid_argument);
  };
  const half_space above(0, 0, 1, 0);
  refuses([&] { return stair(6, 2).resolve(9); },
          "a join of 6 + 2 ranks needs exactly 8, but there are 9");
  refuses([&] { return join(grid<2>{}, within(above, slabs<dynamic>{})).resolve(2); },
          "a join of 2 + ? ranks needs more than 2, but there are 2");
  refuses([&] { return join(ring<dynamic>{}, within(above, slabs<dynamic>{})).resolve(5); },
          "2 parts of the join (? + ? ranks)");
  refuses(
      [&] {
        return join(slabs<2>{.axis = {0, 0, 1}}, within(above, slabs<1>{})).resolve(3);
      },
      "rank 1 of the join, cell 1 of its part 0, owns no space");
  refuses([] { return join<ring<6>, slabs<2>>{}.resolve(8); }, "which part of space is whose");
  refuses([] { return join<ring<6>, slabs<2>>{}.resolve(4); }, "exactly 8, but there are 4");
}
