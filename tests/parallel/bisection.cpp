#include "talus/parallel/bisection.hpp"

#include <algorithm>
#include <mutex>
#include <set>

#include "decomposition_laws.hpp"
#include "talus/core/random.hpp"
#include "talus/parallel/any_decomposition.hpp"
#include "talus/parallel/serial.hpp"
#include "talus/parallel/threads.hpp"

using namespace talus;
using doctest::Contains;
using laws::decomposition_laws;

namespace {

constexpr auto cube = [](int ranks) {
  return bisection<dynamic>{.count = ranks, .lower = {-3, -4, -2.5}, .upper = {3, 4, 2.5}};
};

/// Points crowded in a corner, some of them in layers, some alone far away.
std::vector<vec3> heap(std::size_t count) {
  random_stream random(11, 1);
  std::vector<vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    vec3 p = random.uniform(vec3(0, 0, 0), vec3(1, 1, 1));
    p = vec3(6 * p[0] * p[0] * p[0] - 3, 8 * p[1] * p[1] - 4, p[2] - 2.5);
    if (i % 30 == 0) p[0] = std::round(4 * p[0]) / 4;
    points.push_back(i % 500 == 0 ? vec3(5 * p) : p);
  }
  return points;
}

/// Weight of the points that each rank owns.
std::vector<double> shares(const bisection<dynamic>& d, int ranks,
                           const std::vector<vec3>& points) {
  const auto cells = d.resolve(ranks);
  std::vector<double> owned(static_cast<std::size_t>(ranks));
  for (const vec3& p : points) owned[static_cast<std::size_t>(cells.owner(p))] += 1;
  return owned;
}
double largest_over_mean(const std::vector<double>& owned) {
  double sum = 0, most = 0;
  for (const double x : owned) sum += x, most = std::max(most, x);
  return most * static_cast<double>(owned.size()) / sum;
}

/// Divides points of which `holders` ranks hold some each, by holder(index of a point).
template <class Holder>
bisection<dynamic> shared(const bisection<dynamic>& d, int ranks, const std::vector<vec3>& points,
                          int holders, Holder&& holder) {
  std::vector<bisection<dynamic>> found(static_cast<std::size_t>(holders));
  threads::launch({.ranks = holders}, [&](threads::link& link) {
    std::vector<vec3> mine;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (holder(i) == link.rank()) mine.push_back(points[i]);
    found[static_cast<std::size_t>(link.rank())] =
        d.shared_out(link, std::span<const vec3>(mine), 7, ranks);
  });
  for (const auto& each : found) REQUIRE(each.cuts == found[0].cuts);
  return found[0];
}

}  // namespace

TEST_CASE("bisections keep the laws of decompositions, for any number of ranks") {
  std::size_t tested = 0;
  for (const int ranks : {1, 2, 3, 5, 6, 7, 9, 13, 16, 31})
    tested += decomposition_laws(cube(ranks), ranks, 30'000);
  tested += decomposition_laws(bisection<5>{.lower = {.y = -1}, .upper = {.y = 7}}, 5, 50'000);
  tested += decomposition_laws(
      bisection<4>{.cuts = {{0, -0.3}, {2, std::nextafter(-0.3, 0.0)}, {0, -0.0}}}, 4, 100'000);
  tested += decomposition_laws(bisection<3>{.cuts = {{1, 1e200}, {1, 1.5e200}}}, 3, 50'000);
  const auto points = heap(4000);
  for (const int ranks : {4, 7, 19})
    tested += decomposition_laws(shared(cube(ranks), ranks, points, 1, [](auto) { return 0; }),
                                 ranks, 50'000);
  MESSAGE(tested << " points tested");
  CHECK(tested > 500'000);
}

TEST_CASE("equal volumes: half of the ranks below each cut, across the longest axis") {
  const auto cells = cube(7).resolve(7);
  // y is longest: 3 of 7 below. Below: x, then y or z; above: x again.
  CHECK(cells.cuts()[0] == bisection_cut{1, -4 + 8.0 * 3 / 7});
  CHECK(cells.cuts()[1] == bisection_cut{0, -1});
  CHECK(cells.size() == 7);
  const bisection<dynamic> flat{.lower = {.z = 0}, .upper = {.z = 8}};
  const auto four = flat.resolve(4).cuts();
  CHECK(four == std::vector<bisection_cut>{{2, 4}, {2, 2}, {2, 6}});
  CHECK(flat.resolve(1).owner({1, 2, 3}) == 0);
  CHECK(flat.size() == 0);
}

TEST_CASE("a load is shared out so that each rank has its part, wherever it lies") {
  const auto points = heap(20'000);
  for (const int ranks : {2, 3, 4, 6, 7, 9, 17, 64}) {
    CAPTURE(ranks);
    const auto one = shared(cube(ranks), ranks, points, 1, [](auto) { return 0; });
    CHECK(largest_over_mean(shares(cube(ranks), ranks, points)) > 1.4);
    CHECK(largest_over_mean(shares(one, ranks, points)) < 1.02);
  }
}

TEST_CASE("by count, cuts follow from the bodies alone, whoever holds them") {
  const auto points = heap(5000);
  for (const int ranks : {3, 7}) {
    const auto one = shared(cube(ranks), ranks, points, 1, [](auto) { return 0; });
    for (const int holders : {2, 5, 7}) {
      const auto n = static_cast<std::size_t>(holders);
      const auto mixed = shared(cube(ranks), ranks, points, holders,
                                [&](std::size_t i) { return static_cast<int>(i * 7 % n); });
      CHECK(mixed.cuts == one.cuts);
      const auto last =
          shared(cube(ranks), ranks, points, holders, [&](auto) { return holders - 1; });
      CHECK(last.cuts == one.cuts);
    }
  }
}

TEST_CASE("where bodies weigh more, domains hold fewer") {
  std::vector<vec3> points;
  for (int i = 0; i < 4000; ++i) points.push_back({-3 + 6 * (i + 0.5) / 4000, 0, 0});
  bisection<dynamic> d{.lower = {.x = -3}, .upper = {.x = 3}}, found;
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    const auto mine = std::span<const vec3>(points).subspan(link.rank() == 0 ? 0 : 2000, 2000);
    const auto moved = d.shared_out(link, mine, link.rank() == 0 ? 300 : 100, 2);
    if (link.rank() == 0) found = moved;
  });
  // 2000 of 300 and 2000 of 100: half of the weight are the first 1333 1/3.
  CHECK(found.cuts[0].at == doctest::Approx(-3 + 6 * 1333.5 / 4000).epsilon(0.01));
}

TEST_CASE("cuts lie between layers, and axes stay until another one is longer by half") {
  std::vector<vec3> points;
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 12; ++y) points.push_back({x * 1.0, y * 1.0, 0});
  const auto of = [](const bisection<dynamic>& d, const std::vector<vec3>& places) {
    serial::link link;
    return d.shared_out(link, std::span<const vec3>(places), 1, 2).cuts[0];
  };
  const bisection<dynamic> plane{.lower = {0, 0}, .upper = {9, 11}};
  CHECK(of(plane, points) == bisection_cut{1, 5.5});
  bisection<dynamic> along_x = plane;
  along_x.cuts = {{0, 4}};
  CHECK(of(along_x, points) == bisection_cut{0, 4.5});
  for (int y = 12; y < 20; ++y)
    for (int x = 0; x < 10; ++x) points.push_back({x * 1.0, y * 1.0, 0});
  CHECK(of(along_x, points) == bisection_cut{1, 9.5});
}

TEST_CASE("few bodies, all in one place, or none: every rank has space") {
  for (const int ranks : {2, 5, 7, 12})
    for (const std::size_t count : {0u, 1u, 2u, 3u, 50u})
      for (const bool one_place : {false, true}) {
        CAPTURE(ranks);
        CAPTURE(count);
        std::vector<vec3> points = heap(count);
        if (one_place) std::fill(points.begin(), points.end(), vec3(0.3, 0.3, 9));
        auto d = cube(ranks);
        for (int again = 0; again < 3; ++again)
          d = shared(d, ranks, points, 2, [](std::size_t i) { return static_cast<int>(i % 2); });
        (void)d.resolve(ranks);
        if (count == 50 && !one_place)
          CHECK(largest_over_mean(shares(d, ranks, points)) < 1 + ranks / 50.0 + 0.05);
      }
  // Points next to each other, to the last bit, across the only axis there is.
  std::vector<vec3> dense;
  real x = 1;
  for (int i = 0; i < 12; ++i) dense.push_back({x = std::nextafter(x, 2.0), 0, 0});
  const bisection<dynamic> line{.lower = {.x = 0}, .upper = {.x = 2}};
  const auto found = shared(line, 12, dense, 1, [](auto) { return 0; });
  CHECK(found.resolve(12).size() == 12);
}

TEST_CASE("cuts travel as numbers") {
  const auto found = shared(cube(9), 9, heap(300), 1, [](auto) { return 0; });
  const auto back = cube(9).placed(found.positions());
  CHECK(back.cuts == found.cuts);
  CHECK_THROWS_WITH_AS((void)cube(3).placed(std::vector<real>{4, 1, 0, 2}),
                       Contains("axis 4 makes no sense"), std::runtime_error);
  const any_decomposition any = found;
  CHECK(any.movable());
  CHECK(any.positions() == found.positions());
  CHECK(any_decomposition(cube(9)).placed(found.positions()).positions() == found.positions());
  CHECK(!any_decomposition(grid<2, 2>{}).movable());
  CHECK(any_decomposition(grid<2, 2>{}).positions().empty());
}

TEST_CASE("wrong bisections are refused with their numbers") {
  const auto refuses = [](auto action, const char* text) {
    CHECK_THROWS_WITH_AS((void)action(), Contains(text), std::invalid_argument);
  };
  const std::vector<vec3> none;
  serial::link link;
  refuses([] { return cube(3).resolve(4); }, "3 ranks needs exactly 3 ranks, but there are 4");
  refuses([] { return bisection<3>{}.resolve(3); }, "no bounds or cuts");
  refuses([] { return bisection<3>{.count = 2}.size(); },
          "leave it out, or use bisection<dynamic>");
  refuses([] { return bisection<2>{.lower = {1}, .upper = {1}}.resolve(2); }, "lower < upper");
  refuses([] { return bisection<2>{.lower = {.z = 1}}.resolve(2); }, "bounds along z");
  refuses([] { return bisection<3>{.cuts = {{0, 1}}}.resolve(3); }, "2 cut(s), but 1");
  refuses([] { return bisection<2>{.cuts = {{3, 1}}}.resolve(2); }, "axis 3");
  refuses([] { return bisection<2>{.cuts = {{0, NAN}}}.resolve(2); }, "does not divide");
  refuses(
      [] {
        return bisection<4>{.cuts = {{0, 1}, {0, 1}, {1, 0}}}.resolve(4);
      },
      "cut 1 of a bisection, at 1 across x");
  refuses(
      [] {
        return bisection<4>{.cuts = {{0, 1}, {1, 1}, {0, 0}}}.resolve(4);
      },
      "cut 2 of a bisection, at 0 across x");
  refuses(
      [&] {
        return bisection<2>{.cuts = {{0, 1}}}.shared_out(link, std::span<const vec3>(none), 1, 2);
      },
      "has no bounds");
}
