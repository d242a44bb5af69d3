#include "talus/parallel/cells.hpp"

#include "decomposition_laws.hpp"
#include "talus/parallel/grid.hpp"

using namespace talus;
using doctest::Contains;
using laws::decomposition_laws;

namespace {

constexpr real rounding = 4e-15;

// The two-process examples of the tutorial.
const half_space diagonal(1, 1, 0, -std::sqrt(2.0));                             // its Figure 7
const auto quarter = intersect(half_space(1, 0, 0, 2), half_space(0, 1, 0, 1));  // its Figure 8

/// Three wedges about an oblique line, planes by sines and cosines.
std::vector<any_geometry> wedges() {
  const auto boundary = [](int i) {
    const real angle = 2 * pi / 3 * i + 0.2;
    return half_space(-std::sin(angle), std::cos(angle), 0.1, 0.3);
  };
  std::vector<any_geometry> result;
  for (int i = 0; i < 3; ++i)
    result.emplace_back(intersect(boundary(i), complement(boundary((i + 1) % 3))));
  return result;
}

}  // namespace

TEST_CASE("cells keep the laws of decompositions at a million hard points") {
  std::size_t tested = 0;
  tested += decomposition_laws(cells(complement(diagonal), diagonal), 2, 200'000, rounding);
  tested += decomposition_laws(cells(complement(quarter), quarter), 2, 200'000, rounding);
  tested += decomposition_laws(cells(quarter, complement(quarter)), 2, 200'000, rounding);
  // A cross of four arms, not convex, and the four quadrants it leaves.
  const auto strip = [](const vec3& n) {
    return intersect(half_space(n, -1.0), half_space(vec3(-n), -1.0));
  };
  const auto corner = [](real x, real y) {
    return intersect(half_space(x, 0, 0, 1), half_space(0, y, 0, 1));
  };
  tested += decomposition_laws(cells(merge(strip({1, 0, 0}), strip({0, 1, 0})), corner(1, 1),
                                     corner(-1, 1), corner(-1, -1), corner(1, -1)),
                               5, 200'000, rounding);
  auto list = wedges();
  tested += decomposition_laws(cells(any_geometry(list[0]), any_geometry(list[1]),
                                     complement(any_geometry(merge(list[0], list[1])))),
                               3, 100'000, rounding);
  // Boxes within each other: everyone but the innermost has a hole, as lower ranks own first.
  std::vector<any_geometry> shells;
  for (const real half : {1.0, 2.5, 4.0}) {
    std::vector<half_space> box;
    for (int axis = 0; axis < 3; ++axis)
      for (const real sign : {1, -1}) box.emplace_back(vec3(sign * vec3::Unit(axis)), -half);
    shells.push_back(any_geometry::cell(box));
  }
  shells.emplace_back();
  tested += decomposition_laws(cells(shells), 4, 100'000, rounding);
  MESSAGE(tested << " points tested");
  CHECK(tested >= 1'000'000);
}

TEST_CASE("space cut at random, by planes in any direction, keeps the laws") {
  for (int seed = 1; seed <= 24; ++seed) {
    CAPTURE(seed);
    std::mt19937_64 random(seed);
    const auto number = [&] { return static_cast<real>(random() >> 11) * 0x1p-52 - 1; };
    std::vector<detail::convex_piece> parts(1);
    while (std::ssize(parts) < 3 + seed % 9) {
      auto& part = parts[random() % parts.size()];
      const vec3 normal =
          seed % 3 == 0 ? vec3(vec3::Unit(random() % 3)) : vec3(number(), number(), number());
      const vec3 aside(number(), number(), number());
      const half_space cut(normal, vec3(detail::deepest_point(part).point + 0.3 * aside));
      const std::vector<detail::convex_piece> one{{cut}}, other{{cut.flipped()}};
      const auto first = detail::without({part}, one), second = detail::without({part}, other);
      if (first.empty() || second.empty()) continue;
      part = first[0];
      parts.push_back(second[0]);
    }
    std::vector<any_geometry> list;
    for (const auto& part : parts) list.push_back(any_geometry::cell(part));
    decomposition_laws(cells(list), static_cast<int>(list.size()), 10'000, rounding);
  }
}

TEST_CASE("the lowest rank whose region contains a point owns it") {
  const auto overlapping =
      cells(half_space(-1, 0, 0, 0), half_space(0, 1, 0, 0), any_geometry()).resolve(3);
  CHECK(overlapping.owner({0, 5, 0}) == 0);
  CHECK(overlapping.owner({5e-324, 0, 0}) == 1);
  CHECK(overlapping.owner({1, -5e-324, 0}) == 2);
  // The connections use the remaining region, not all that its user wrote.
  CHECK(overlapping.geometry(1) == intersect(half_space(1, 0, 0, 0), half_space(0, 1, 0, 0)));
  CHECK(overlapping.geometry(2) == intersect(half_space(1, 0, 0, 0), half_space(0, -1, 0, 0)));
  // A region without overlap with others is used as its user wrote it, merged ones too.
  const auto two = cells(complement(quarter), quarter).resolve(2);
  CHECK(two.geometry(0) == complement(quarter));
  CHECK(two.geometry(1) == quarter);
  CHECK(two.owner({2, 1, 0}) == 0);
}

TEST_CASE("cells that are those of a grid have its neighbours") {
  std::vector<any_geometry> list;
  const auto grid_of = grid<3, 2, 2>{.lower = {0, 0, 0}, .upper = {3, 4, 2}}.resolve(12);
  for (int r = 0; r < 12; ++r) list.push_back(grid_of.geometry(r));
  const auto same = cells(list).resolve(12);
  for (int r = 0; r < 12; ++r)
    for (const real reach : {0.0, 0.9, 1.0, 2.1})
      CHECK(same.neighbours(r, reach) == grid_of.neighbours(r, reach));
  const auto [lower, upper] = same.bounds(1);
  CHECK(lower[0] == doctest::Approx(1));
  CHECK(upper[0] == doctest::Approx(2));
  CHECK(upper[1] == doctest::Approx(2));
  CHECK(lower[1] == -std::numeric_limits<real>::infinity());
}

TEST_CASE("ranks that touch in a closed plane only are not connected") {
  const half_space wall(1, 0, 0, 0), floor(0, 0, 1, 0);
  const auto four =
      cells(intersect(complement(wall), floor), intersect(wall, floor),
            intersect(complement(wall), complement(floor)), intersect(wall, complement(floor)));
  CHECK(four.resolve(4).neighbours(0, 0) == std::vector<int>{1, 2, 3});
  CHECK(four.resolve(4).closed(0).empty());
  const auto both_sides = intersect(wall, complement(wall));
  const auto walled = four.closed(both_sides).resolve(4);
  CHECK(walled.neighbours(0, 0) == std::vector<int>{2});
  CHECK(walled.closed(0) == std::vector<int>{1, 3});
  decomposition_laws(four.closed(both_sides), 4, 100'000, rounding);
  // Only the upper half of the wall; faces beside it are open.
  const auto upper = four.closed(intersect(both_sides, floor)).resolve(4);
  CHECK(upper.closed(0) == std::vector<int>{1, 3});  // of 3 it touches only the edge of the wall
  CHECK(upper.closed(2) == std::vector<int>{1});
  CHECK(upper.neighbours(2, 0) == std::vector<int>{0, 3});
  CHECK(four.closed(half_space(1, 0, 0, 1e-3)).resolve(4).closed(0).empty());
  CHECK_THROWS_WITH_AS((void)four.closed(merge(wall, floor)).resolve(4), Contains("convex regions"),
                       std::invalid_argument);
}

TEST_CASE("wrong cells are refused, with the place of a gap") {
  const auto refuses = [](auto action, std::vector<const char*> texts) {
    for (const char* text : texts)
      CHECK_THROWS_WITH_AS((void)action(), Contains(text), std::invalid_argument);
  };
  const half_space right(1, 0, 0, 1), left(-1, 0, 0, 1);
  refuses([&] { return cells(left, right).resolve(2); }, {"leave a gap", "no rank owns (0, 0, 0)"});
  refuses([&] { return cells(left, any_geometry(), right).resolve(3); },
          {"the region of rank 2 in cells has no space of its own: x >= 1"});
  refuses([&] { return cells(left, complement(left)).resolve(3); },
          {"cells of 2 region(s) need exactly 2 ranks, but there are 3"});
  refuses([&] { return cells<half_space, half_space>{}.resolve(2); }, {"no regions yet"});
  refuses([&] { return cells<>{}.resolve(2); }, {"no regions yet"});
  CHECK(cells<half_space, half_space>{}.size() == 2);
  CHECK(cells<>{}.size() == 0);
  // Round-off counts as no gap.
  const half_space a(0.3, 0.7, 0.1, 1), b(-0.3, -0.7, -0.1, -1.0000000000000002);
  CHECK(cells(a, b).resolve(2).owner({0, 0, 0}) == 1);
}
