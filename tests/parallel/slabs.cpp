#include "talus/parallel/slabs.hpp"

#include "decomposition_laws.hpp"
#include "talus/parallel/grid.hpp"
#include "talus/parallel/reach.hpp"
#include "talus/parallel/rectilinear.hpp"

using namespace talus;
using doctest::Contains;
using laws::decomposition_laws;

TEST_CASE("slabs keep the laws of decompositions at a million hard points") {
  std::size_t tested = 0;
  tested += decomposition_laws(slabs<1>{}, 1, 10'000);
  tested += decomposition_laws(slabs<2>{}, 2, 200'000);
  tested += decomposition_laws(slabs<5>{.lower = 0, .upper = 10}, 5, 200'000);
  tested += decomposition_laws(
      slabs<4>{.axis = {0, -1, 0}, .cuts = {-1e200, -0.3, std::nextafter(-0.3, 0.0)}}, 4, 200'000);
  tested += decomposition_laws(slabs<3>{.axis = {1, 2, -7}, .lower = -3, .upper = 4}, 3, 200'000);
  tested += decomposition_laws(slabs<dynamic>{.axis = {-1, 1, 0}, .lower = 1e6, .upper = 1e6 + 1},
                               12, 200'000);
  MESSAGE(tested << " points tested");
  CHECK(tested > 1'000'000);
}

TEST_CASE("slabs along an axis are a grid in one dimension") {
  const auto cells = slabs<4>{.axis = {0, 1, 0}, .lower = -3, .upper = 7}.resolve(4);
  const auto same = grid<1, 4>{.lower = {.y = -3}, .upper = {.y = 7}}.resolve(4);
  laws::hard_points source({{vec3(0, 1, 0), same.cuts()[1][0]}, {vec3(0, 1, 0), same.cuts()[1][2]}},
                           3);
  laws::tally law("slabs own what the cells of the grid own");
  for (int i = 0; i < 100'000; ++i) {
    const vec3 p = source.next();
    law.expect(cells.owner(p) == same.owner(p), [&] { return laws::show(p); });
  }
  for (int r = 0; r < 4; ++r) {
    CHECK(cells.geometry(r) == same.geometry(r));
    for (const real reach : {0.0, 2.4, 2.5, 5.0})
      CHECK(cells.neighbours(r, reach) == same.neighbours(r, reach));
  }
}

TEST_CASE("a reach connects slabs beyond the next: five, with an agglomerate across all") {
  const slabs<5> d{.lower = 0, .upper = 10};
  CHECK(domain<slabs<5>>(d, 2, 5).connections().size() == 2);
  CHECK(domain<slabs<5>>(d, 2, 5, reach{1.9}.distance).connections().size() == 2);
  CHECK(domain<slabs<5>>(d, 2, 5, reach{2}.distance).connections().size() == 4);
  CHECK_THROWS_WITH_AS((domain<slabs<5>>(d, 2, 5, -1)), Contains("reach"), std::invalid_argument);
}

TEST_CASE("rectilinear cells are those between the given cuts") {
  const auto fixed = rectilinear<3, 2>{.x = {-1, 4}, .y = {0}};
  CHECK(fixed.size() == 6);
  CHECK(decomposition_laws(fixed, 6, 100'000) == 100'000);
  const rectilinear<> open{.x = {-1, 4}, .z = {0}};
  CHECK(open.size() == 6);
  CHECK(open.resolve(6).owner({0, 7, 1}) == 4);
  CHECK(decomposition_laws(open, 6, 100'000) == 100'000);
  CHECK_THROWS_WITH_AS((void)fixed.resolve(4), Contains("exactly 6 ranks, but there are 4"),
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS((void)(rectilinear<3, 2>{.x = {1}, .y = {0}}.resolve(6)),
                       Contains("3 cells along x need 2 cut(s), but 1 are given"),
                       std::invalid_argument);
}

TEST_CASE("wrong slabs are refused with their numbers") {
  const auto refuses = [](auto action, const char* text) {
    CHECK_THROWS_WITH_AS((void)action(), Contains(text), std::invalid_argument);
  };
  refuses([] { return slabs<3>{.lower = 0, .upper = 1}.resolve(4); },
          "3 slabs need exactly 3 ranks, but there are 4");
  refuses([] { return slabs<dynamic>{.cuts = {0, 1}}.resolve(4); }, "exactly 3 ranks");
  refuses([] { return slabs<dynamic>{.count = 5, .lower = 0, .upper = 1}.resolve(4); },
          "exactly 5 ranks");
  refuses([] { return slabs<3>{}.resolve(3); }, "no bounds or cuts");
  refuses([] { return slabs<3>{.lower = 1, .upper = 1}.resolve(3); }, "lower < upper");
  refuses([] { return slabs<3>{.cuts = {1, 1}}.resolve(3); }, "cut 1 is 1 after 1");
  refuses([] { return slabs<3>{.cuts = {1}}.resolve(3); }, "3 slabs need 2 cut(s), but 1");
  refuses([] { return slabs<2>{.lower = 0, .upper = 1, .cuts = {1}}.resolve(2); }, "both");
  refuses([] { return slabs<2>{.axis = {0, 0, 0}}.resolve(2); }, ".axis of the slabs");
}
