// timeout: 300
// Contacts of all pairs of finite shapes, against their support functions.
#include <doctest/doctest.h>

#include <map>

#include "solids.hpp"

using namespace solids;

namespace {

// Properties of every answer. Points on the two surfaces are gap apart along the normal, so the
// distance is at most the gap; and no smaller gap is possible along that normal.
void check_sound(const solid& a, const solid& b, const contacts& found, real margin) {
  const real smallest = std::min(a.smallest(), b.smallest());
  CHECK(found.size() <= detail::most_corners);
  CHECK(feature_ids(found).size() == found.size());
  if (found.empty()) return;
  for (const contact_geometry& c : found) {
    REQUIRE(detail::finite(c.normal));
    REQUIRE(detail::finite(c.point));
    CHECK(c.normal.norm() == doctest::Approx(1).epsilon(1e-12));
    CHECK(c.gap <= margin);
    const real along = gap_along(a, b, c.normal);
    CHECK(c.gap >= along - 1e-3 * smallest * (found.size() > 1) - 1e-9 * smallest);
    const real soft = 2.1e-2 * smallest;
    CHECK(a.outside(c.point + 0.5 * c.gap * c.normal) <= soft + std::max(real(0), -c.gap));
    CHECK(b.outside(c.point - 0.5 * c.gap * c.normal) <= soft + std::max(real(0), -c.gap));
    if (c.gap > 0 && c.gap == smallest_gap(found)) {
      CHECK(a.outside(c.point + 0.5 * c.gap * c.normal) >= -soft - 0.01 * c.gap);
      CHECK(b.outside(c.point - 0.5 * c.gap * c.normal) >= -soft - 0.01 * c.gap);
    }
  }
}

}  // namespace

TEST_CASE("random pairs of shapes: right gaps, sound points, no pair missed") {
  std::map<std::string, std::array<int, 4>> met;
  for (std::uint64_t seed = 1; seed <= 6000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const std::size_t kind_a = seed % 5, kind_b = seed / 5 % 5;
    if (kind_a == 1 && kind_b == 1) continue;  // box_box.cpp has its own measure
    solid a{random_shape(kind_a, random), {random.point(3), random.turn()}};
    solid b{random_shape(kind_b, random), {random.point(3), random.turn()}};
    if (seed % 3 == 0) b.at.orientation = a.at.orientation * rotation(random.direction(), 0.02);
    if (seed % 7 == 0) b.at.orientation = a.at.orientation * rotation({0, 0, 1}, random(0, 3));
    INFO("seed " << seed << ", " << a.name() << " and " << b.name());
    auto& count = met[a.name() + " " + b.name()];
    const real smallest = std::min(a.smallest(), b.smallest()), margin = 0.1;

    // Near each other: at the distance of the answer for a far larger margin, and slightly off.
    const vec3 line = random.direction();
    a.at.position = b.at.position + random(0.2, 1) * (a.radius() + b.radius()) * line;
    const contacts anywhere = find(a, b, 10);
    REQUIRE(!anywhere.empty());
    if (seed % 4 != 0)
      a.at.position += (random(-0.1, 0.13) * (seed % 8 == 1 ? 0.01 : 1) - smallest_gap(anywhere)) *
                       anywhere[0].normal;

    const contacts found = find(a, b, margin);
    check_sound(a, b, found, margin);
    const vec3 start = found.empty() ? find(a, b, 10).at(0).normal : deepest(found).normal;
    const real first = gap_along(a, b, start);
    const real best = best_gap(a, b, start, random, first > 0 ? 0 : 600);
    if (best > margin) {
      ++count[0];
      CHECK(found.empty());
      continue;
    }
    REQUIRE((!found.empty() || best > margin - 1e-6));
    if (found.empty()) continue;
    const real gap = smallest_gap(found);
    if (best > 1e-5 * smallest) {
      ++count[1];
      // The nearest points, or within five percent if a face replaces them; if that face has an
      // overlap, within half a percent of the thickness.
      CHECK(gap <= 1.051 * best + (first > 0 ? 1.1e-4 : 5.1e-3) * smallest + 1e-7);
      CHECK(gap >= 0.95 * best - 5.1e-3 * smallest);
    } else {
      ++count[2];
      const real slack = 0.0101 * smallest + 0.11 * std::abs(best);
      CHECK(gap_along(a, b, deepest(found).normal) >= best - slack);
      CHECK(gap <= best + slack);
      CHECK(gap >= best - slack);
    }
    count[3] += found.size() > 1;
  }
  for (const auto& [names, count] : met) {
    MESSAGE(names, ": apart ", count[0], ", near ", count[1], ", overlapping ", count[2],
            ", several points ", count[3]);
    CHECK(count[1] > 20);
    CHECK(count[2] > 20);
  }
}
