// Two unions of spheres have the contacts that their spheres have one by one.
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "../generator.hpp"
#include "talus/detect/narrow.hpp"

namespace {

using namespace talus;
using balls = union_of<sphere>;
using others = union_of<sphere, box>;  // by the general way

}  // namespace

TEST_CASE("two unions of spheres have the contacts of their parts, to the bit and in one order") {
  generator random{std::mt19937_64(17)};
  std::size_t contacts = 0, apart = 0;
  const auto cloud = [&](int n, std::vector<balls::part>& parts, std::vector<others::part>& same) {
    for (int k = 0; k < n; ++k) {
      const sphere s{random(0.1, 0.4)};
      const pose at{random.point(0.6)};
      parts.push_back({.shape = s, .at = at});
      same.push_back({.shape = s, .at = at});
    }
  };
  const union_options counted{.overlaps = overlap_rule::counted};
  for (int trial = 0; trial < 60; ++trial) {
    CAPTURE(trial);
    // Also with more parts near the other union than have places.
    const int n = trial % 10 == 9 ? 200 : 1 + trial % 12;
    std::vector<balls::part> parts_a, parts_b;
    std::vector<others::part> same_a, same_b;
    cloud(n, parts_a, same_a), cloud(n, parts_b, same_b);
    const balls a(parts_a, counted), b(parts_b, counted);
    const others c(same_a, counted), d(same_b, counted);
    const pose at_a{random.point(3), random.turn()};
    const pose at_b{at_a.position + random(0.3, 2.2) * random.direction(), random.turn()};
    const real margin = random(0, 0.2);
    std::vector<contact_geometry> found, expected;
    collide_pair(a, at_a, b, at_b, margin, [&](const contact_geometry& g) { found.push_back(g); });
    collide_pair(c, at_a, d, at_b, margin,
                 [&](const contact_geometry& g) { expected.push_back(g); });
    REQUIRE(found.size() == expected.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      CHECK(found[k].feature == expected[k].feature);
      CHECK(found[k].point == expected[k].point);
      CHECK(found[k].normal == expected[k].normal);
      CHECK(found[k].gap == expected[k].gap);
      CHECK(found[k].gap <= margin * (1 + 1e-12));
    }
    contacts += found.size(), apart += found.empty();
    // Every pair of spheres that comes within the margin is there.
    std::size_t near = 0;
    a.each_part([&](const sphere& s, const pose& of_s) {
      b.each_part([&](const sphere& t, const pose& of_t) {
        const vec3 p = at_a.to_world(of_s.position), q = at_b.to_world(of_t.position);
        near += (p - q).norm() <= s.radius + t.radius + margin;
      });
    });
    CHECK(found.size() == near);
  }
  CHECK(contacts > 1000);
  CHECK(apart > 3);
}
