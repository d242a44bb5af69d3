#include "talus/parallel/ring.hpp"

#include "decomposition_laws.hpp"

using namespace talus;
using doctest::Contains;
using laws::decomposition_laws;

namespace {
constexpr real rounding = 4e-15;
}

TEST_CASE("rings keep the laws of decompositions at a million hard points, on the axis too") {
  std::size_t tested = 0;
  tested += decomposition_laws(ring<1>{}, 1, 10'000, rounding);
  tested += decomposition_laws(ring<2>{}, 2, 100'000, rounding);
  tested += decomposition_laws(ring<3>{}, 3, 100'000, rounding);
  tested += decomposition_laws(ring<4>{}, 4, 100'000, rounding);
  tested += decomposition_laws(ring<6>{.centre = {0.5, -3, 1}, .hub = 2}, 6, 150'000, rounding);
  tested += decomposition_laws(
      ring<7>{.axis = {1, -2, 0.3}, .centre = {3, 1, 1}, .start = {0, 0, 1}}, 7, 150'000, rounding);
  tested += decomposition_laws(
      ring<6>{.axis = {0, 0, -1}, .start = {-1, 0, 0}, .angle = pi, .hub = 6, .closed = true}, 6,
      150'000, rounding);
  tested += decomposition_laws(ring<5>{.angle = pi}, 5, 50'000, rounding);
  tested += decomposition_laws(ring<2>{.angle = 0.3}, 2, 50'000, rounding);
  tested += decomposition_laws(ring<4>{.angle = 1.7 * pi, .closed = true}, 4, 50'000, rounding);
  tested += decomposition_laws(ring<dynamic>{.start = {3, 4, 0}}, 36, 100'000, rounding);
  MESSAGE(tested << " points tested");
  CHECK(tested > 1'000'000);
}

TEST_CASE("sectors are neighbours in sequence, and closed to all others") {
  const auto full = ring<6>{}.resolve(6);
  CHECK(full.neighbours(0, 0) == std::vector<int>{1, 5});
  CHECK(full.closed(0) == std::vector<int>{2, 3, 4});
  const auto open = ring<6>{.angle = pi}.resolve(6);
  CHECK(open.neighbours(0, 0) == std::vector<int>{1, 5});
  const auto part = ring<6>{.angle = pi, .closed = true}.resolve(6);
  CHECK(part.neighbours(0, 0) == std::vector<int>{1});
  CHECK(part.neighbours(3, 0) == std::vector<int>{2, 4});
  CHECK(part.closed(0) == std::vector<int>{2, 3, 4, 5});
  CHECK(ring<3>{}.resolve(3).closed(1).empty());
}

TEST_CASE("a reach goes around the hub, not across a closed end") {
  const ring<12> d{.hub = 10};
  const auto cells = d.resolve(12);
  CHECK(cells.neighbours(0, 5.0) == std::vector<int>{1, 11});  // 2 * 10 * sin(15 degrees) = 5.18
  CHECK(cells.neighbours(0, 5.2) == std::vector<int>{1, 2, 10, 11});
  CHECK(cells.neighbours(0, 20.1).size() == 11);
  const domain<ring<12>> wide(d, 0, 12, 5.2);
  CHECK(wide.connections().size() == 4);
  CHECK(wide.closed().size() == 7);
  const auto half = ring<6>{.angle = pi, .hub = 10, .closed = true}.resolve(6);
  CHECK(half.neighbours(0, 5.2) == std::vector<int>{1, 2});
  CHECK(ring<6>{}.resolve(6).neighbours(0, 0.1).size() == 5);  // all meet at an axis without a hub
}

TEST_CASE("sectors count about the axis from the start, and share the rest of the circle") {
  const auto owner = [](const auto& d, real degrees) {
    const real a = degrees / 180 * pi;
    return d.resolve(d.size()).owner(5 * vec3(std::cos(a), std::sin(a), 3));
  };
  const ring<4> full;
  for (const int k : {0, 1, 2, 3}) CHECK(owner(full, 45 + 90 * k) == k);
  // The stair: clockwise from -x over +y to +x.
  const ring<6> stair{.axis = {0, 0, -1}, .start = {-1, 0, 0}, .angle = pi};
  for (int k = 0; k < 6; ++k) CHECK(owner(stair, 180 - 15 - 30 * k) == k);
  CHECK(owner(stair, 181) == 0);
  CHECK(owner(stair, 269) == 0);
  CHECK(owner(stair, 271) == 5);
  CHECK(owner(stair, 359) == 5);
  // Quarter turns are exact, and boundaries belong to the side towards +x, then +y.
  const auto quarters = full.resolve(4);
  CHECK(quarters.owner({0, 5, 1}) == 0);
  CHECK(quarters.owner({-5e-324, 5, 1}) == 1);
  CHECK(quarters.owner({-5, 0, 1}) == 1);
  CHECK(quarters.owner({0, -5, 1}) == 3);
  CHECK(quarters.geometry(0) == intersect(half_space(1, 0, 0, 0), half_space(0, 1, 0, 0)));
}

TEST_CASE("a closed face is as far away as it looks") {
  const domain<ring<36>> d({}, 0, 36);  // sectors of 10 degrees
  const auto distance = [&](const vec3& p) {
    real least = 1e9;
    for (const closed_neighbour& c : d.closed())
      if (const auto place = c.within(p, 1e3)) least = std::min(least, place->distance);
    return least;
  };
  const real a = 5.0 / 180 * pi;
  const vec3 p = 10 * vec3(std::cos(a), std::sin(a), 0);
  // The next but one boundary is 15 degrees away on both sides; the sector opposite, though its
  // planes pass near the point, is 10 away.
  CHECK(distance(p) == doctest::Approx(10 * std::sin(15.0 / 180 * pi)));
  for (const closed_neighbour& c : d.closed())
    if (c.rank() == 18) CHECK(c.within(p, 1e3)->distance == doctest::Approx(10));
}

TEST_CASE("a wrong ring is refused with its numbers") {
  const auto refuses = [](auto action, const char* text) {
    CHECK_THROWS_WITH_AS((void)action(), Contains(text), std::invalid_argument);
  };
  refuses([] { return ring<6>{}.resolve(4); },
          "a ring of 6 sectors needs exactly 6 ranks, but there are 4");
  refuses([] { return ring<dynamic>{.sectors = 3}.resolve(4); }, "exactly 3 ranks");
  refuses([] { return ring<dynamic>{.sectors = -3}.resolve(4); }, "1 or more .sectors, but -3");
  refuses([] { return ring<6>{.sectors = 5}.resolve(6); }, "says 6 for its sectors");
  refuses([] { return ring<6>{.angle = 7}.resolve(6); }, "at most the full circle");
  refuses([] { return ring<6>{.angle = 0}.resolve(6); }, "but is 0");
  refuses([] { return ring<6>{.hub = -1}.resolve(6); }, ".hub of finite radius");
  refuses([] { return ring<6>{.start = {0, 0, 1}}.resolve(6); }, "along its axis");
  CHECK(ring<dynamic>{}.size() == 0);
  CHECK(ring<dynamic>{}.resolve(9).size() == 9);
}
