// A periodic box and its cells.
#include "talus/parallel/periodic.hpp"

#include <doctest/doctest.h>

#include <random>

#include "talus/parallel/domain.hpp"

using namespace talus;

TEST_CASE("each point has one image in the box, and images differ by whole periods") {
  const periodic_box box({-1, 0, 2.5}, {1, 0, 5.9});
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> anywhere(-40, 40);
  for (int n = 0; n < 100'000; ++n) {
    const vec3 p(anywhere(random), anywhere(random), anywhere(random)), q = box.wrapped(p);
    CHECK(box.contains(q));
    CHECK(q[1] == p[1]);
    for (const int k : {0, 2}) {
      const double periods = (p[k] - q[k]) / box.period()[k];
      CHECK(std::abs(periods - std::round(periods)) < 1e-12);
    }
    CHECK(box.wrapped(q) == q);
    CHECK((box.nearest(p, q) - q).norm() < 1e-12);
  }
  for (const double low : {2.5, -0.9, 5.9})  // sides, and points that round-off puts there
    for (const double off : {0.0, 1e-300, 1e-17, -1e-17, 4e-16, -4e-16}) {
      const vec3 q = box.wrapped({-1, 0, low + off});
      CHECK(box.contains(q));
    }
}

TEST_CASE("an image and its reverse move a point forth and back") {
  const periodic_box box({-1, -2, -3}, {1, 2, 3});
  for (periodic_box::number image = 0; image < periodic_box::count; ++image)
    CHECK(box.shift(image) + box.shift(periodic_box::reverse(image)) == vec3(0, 0, 0));
  int images = 0;
  box.each_within({0.95, -1.9, 0}, 0.2, [&](auto image, const vec3& q) {
    CHECK(q == vec3(vec3(0.95, -1.9, 0) + box.shift(image)));
    CHECK((image == 0 || !box.contains(q)));
    ++images;
  });
  CHECK(images == 4);
}

TEST_CASE("every point has one owner, the one whose cell holds its image, and cells touch around") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> anywhere(-20, 20);
  for (const auto& [x, y, z] :
       {std::array{1, 1, 1}, std::array{2, 1, 3}, std::array{3, 2, 1}, std::array{4, 3, 2}}) {
    const periodic<grid<dynamic>, along::x, along::y> how{
        {.cells = {x, y, z}, .lower = {0.1, -3.3, 0}, .upper = {7.7, 2.2, 1}}};
    const auto cells = how.resolve(x * y * z);
    CHECK(how.size() == x * y * z);
    for (int n = 0; n < 10'000; ++n) {
      const vec3 p(anywhere(random), anywhere(random), anywhere(random));
      const int owner = cells.owner(p);
      int owners = 0;
      for (int r = 0; r < cells.size(); ++r)
        if (cells.cell(r).contains(cells.box().wrapped(p))) {
          CHECK(r == owner);
          ++owners;
        }
      CHECK(owners == 1);
      CHECK(cells.geometry(owner).value(cells.box().wrapped(p)) > -1e-12);
    }
    for (int r = 0; r < cells.size(); ++r) {
      const auto near = cells.neighbours(r, 0);
      for (const int other : near) {
        const auto back = cells.neighbours(other, 0);
        CHECK(std::find(back.begin(), back.end(), r) != back.end());
      }
      // Right behind a side: the cell there is a neighbour, and may be this one.
      const auto own = cells.cell(r);
      vec3 beyond(own.upper[0] + 1e-6, 0.5 * (own.lower[1] + own.upper[1]), 0);
      beyond[2] = z == 1                        ? 0
                  : std::isfinite(own.lower[2]) ? own.lower[2] + 1e-6
                                                : own.upper[2] - 1e-6;
      CHECK(std::find(near.begin(), near.end(), cells.owner(beyond)) != near.end());
    }
  }
}

TEST_CASE("a rank beside its own image is its own neighbour, others are not") {
  using box = periodic<grid<dynamic>, along::x>;
  const grid<dynamic> cells{.cells = {3, 1, 1}, .lower = {0}, .upper = {9}};
  const domain alone(box{{.lower = {0}, .upper = {9}}}, 0, 1);
  REQUIRE(alone.connections().size() == 1);
  CHECK(alone.connections()[0].rank == 0);
  const domain middle(box{cells}, 1, 3), wide(box{cells}, 1, 3, 7);
  CHECK(middle.connections().size() == 2);
  CHECK(wide.connections().size() == 3);
  CHECK(middle.covered() == doctest::Approx(6).epsilon(2e-3));
}
