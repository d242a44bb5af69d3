// Two boxes: textbook cases, and random poses against distances from other methods.
#include <doctest/doctest.h>

#include <random>
#include <set>
#include <vector>

#include "../generator.hpp"
#include "../vectors.hpp"
#include "talus/detect/narrow.hpp"

namespace {

using namespace talus;
using contacts = std::vector<contact_geometry>;

struct posed {
  box shape;
  pose at;

  [[nodiscard]] vec3 support(const vec3& d) const {
    return at.to_world(shape.support(at.orientation.conjugate() * d));
  }
  [[nodiscard]] vec3 nearest(const vec3& p) const {
    const vec3 h = shape.half();
    return at.to_world(at.to_body(p).cwiseMax(-h).cwiseMin(h));
  }
  [[nodiscard]] real distance(const vec3& p) const { return (nearest(p) - p).norm(); }
  // Signed: below zero inside.
  [[nodiscard]] real depth(const vec3& p) const {
    return (at.to_body(p).cwiseAbs() - shape.half()).maxCoeff();
  }
};

contacts find(const posed& a, const posed& b, real margin) {
  contacts found;
  collide_pair(a.shape, a.at, b.shape, b.at, margin,
               [&](const contact_geometry& c) { found.push_back(c); });
  return found;
}

real smallest_gap(const contacts& all) {
  real gap = 1e300;
  for (const contact_geometry& c : all) gap = std::min(gap, c.gap);
  return gap;
}
std::set<std::uint32_t> feature_ids(const contacts& all) {
  std::set<std::uint32_t> names;
  for (const contact_geometry& c : all) names.insert(c.feature);
  return names;
}

// Gap along a direction from b to a, from support points alone.
real gap_along(const posed& a, const posed& b, const vec3& n) {
  return n.dot(a.support(-n)) - n.dot(b.support(n));
}
// Exact if negative: minus the penetration depth; else a lower bound of the distance.
real best_axis(const posed& a, const posed& b) {
  std::vector<vec3> normals;
  const mat3 ra = a.at.orientation.toRotationMatrix(), rb = b.at.orientation.toRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    normals.push_back(ra.col(i));
    normals.push_back(rb.col(i));
    for (int j = 0; j < 3; ++j) {
      const vec3 cross = ra.col(i).cross(rb.col(j));
      if (cross.norm() > 1e-4) normals.push_back(cross.normalized());
    }
  }
  real best = -1e300;
  for (const vec3& n : normals) best = std::max({best, gap_along(a, b, n), gap_along(a, b, -n)});
  return best;
}
// Distance by alternating projections (Cheney, Goldstein 1959), exact in the limit, from above.
real projected_distance(const posed& a, const posed& b) {
  vec3 p = a.at.position;
  real last = 1e300;
  for (int k = 0; k < 20000; ++k) {
    const vec3 q = b.nearest(p);
    p = a.nearest(q);
    const real now = (p - q).norm();
    if (k % 50 == 0) {
      if (now == 0 || last - now < 1e-13 * now) return now;
      last = now;
    }
  }
  return last;
}
real smallest_half(const posed& a, const posed& b) {
  return std::min(a.shape.half().minCoeff(), b.shape.half().minCoeff());
}

// Properties of every answer.
void check_sound(const posed& a, const posed& b, const contacts& found, real margin) {
  CHECK(found.size() <= 8);
  CHECK(feature_ids(found).size() == found.size());
  const real largest = std::max(a.shape.half().maxCoeff(), b.shape.half().maxCoeff());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const contact_geometry& c = found[k];
    CHECK(c.feature < 4096);
    if (k > 0) CHECK(c.normal == found[0].normal);
    CHECK(c.normal.norm() == doctest::Approx(1).epsilon(1e-13));
    CHECK(c.gap <= margin);
    CHECK(c.gap >= gap_along(a, b, c.normal) - 1e-12);  // never below the gap along the normal
    // The two surface points are gap apart along the normal, each on its box.
    CHECK(a.distance(c.point + 0.5 * c.gap * c.normal) <= 1.5e-3 * largest);
    CHECK(b.distance(c.point - 0.5 * c.gap * c.normal) <= 1.5e-3 * largest);
    CHECK(a.depth(c.point + 0.5 * c.gap * c.normal) >= -1e-12 - 2 * std::max(real(0), -c.gap));
  }
}

posed unit_box(const vec3& at, const quat& turn = quat::Identity()) { return {box{}, {at, turn}}; }

}  // namespace

TEST_CASE("a box resting on another has four exact contacts") {
  for (const real gap : {-0.01, 0., 0.004}) {
    const posed below{box{{6, 5, 1}}, pose{}};
    const posed above{box{{2, 4, 1}}, {{0.5, 0.25, 1 + gap}, quat::Identity()}};
    for (const bool swap : {false, true}) {
      const contacts c = swap ? find(above, below, 0.01) : find(below, above, 0.01);
      REQUIRE(c.size() == 4);
      std::set<std::pair<real, real>> places;
      for (const contact_geometry& k : c) {
        CHECK(k.gap == doctest::Approx(gap).epsilon(1e-12));
        CHECK(k.normal == vec3(0, 0, swap ? 1 : -1));
        CHECK(k.point[2] == doctest::Approx(0.5 + gap / 2).epsilon(1e-12));
        places.insert({std::round(k.point[0] * 1e6), std::round(k.point[1] * 1e6)});
      }
      CHECK(places == std::set<std::pair<real, real>>{
                          {-5e5, -1.75e6}, {-5e5, 2.25e6}, {1.5e6, -1.75e6}, {1.5e6, 2.25e6}});
    }
  }
}

TEST_CASE("a box hanging over an edge is held by the overlap only") {
  const contacts c = find(unit_box({0, 0, 0}), unit_box({0.75, -0.25, 0.995}), 0.01);
  REQUIRE(c.size() == 4);
  for (const contact_geometry& k : c) {
    CHECK(k.gap == doctest::Approx(-0.005));
    CHECK((std::abs(k.point[0] - 0.25) < 1e-12 || std::abs(k.point[0] - 0.5) < 1e-12));
    CHECK((std::abs(k.point[1] + 0.5) < 1e-12 || std::abs(k.point[1] - 0.25) < 1e-12));
  }
}

TEST_CASE("crossing edges meet in one point") {
  const quat roll = rotation({1, 0, 0}, pi / 4), pitch = rotation({0, 1, 0}, pi / 4);
  for (const real gap : {-0.02, -1e-9, 1e-9, 0.02}) {
    const contacts c =
        find(unit_box({0.1, 0.2, std::sqrt(2.) + gap}, pitch), unit_box({0, 0, 0}, roll), 0.03);
    REQUIRE(c.size() == 1);
    CHECK(c[0].gap == doctest::Approx(gap).epsilon(1e-6));
    CHECK((c[0].normal - vec3(0, 0, 1)).norm() < 1e-9);
    CHECK((c[0].point - vec3(0.1, 0, std::sqrt(0.5) + gap / 2)).norm() < 1e-9);
  }
}

TEST_CASE("a corner pointing at a face meets it in one point") {
  const quat up = rotation({1, -1, 0}, std::acos(std::sqrt(1 / 3.)));  // (1, 1, 1) to z
  for (const real gap : {-0.02, 0., 1e-9, 0.02})
    for (const bool swap : {false, true}) {
      const posed tip = unit_box({0.2, -0.1, 0.5 + std::sqrt(0.75) + gap}, up),
                  table = unit_box({0, 0, 0});
      const contacts c = swap ? find(table, tip, 0.03) : find(tip, table, 0.03);
      REQUIRE(c.size() == 1);
      CHECK(c[0].gap == doctest::Approx(gap).epsilon(1e-6));
      CHECK((c[0].normal - vec3(0, 0, swap ? -1 : 1)).norm() < 1e-12);
      CHECK((c[0].point - vec3(0.2, -0.1, 0.5 + gap / 2)).norm() < 1e-9);
    }
}

TEST_CASE("corners and edges apart are as far as they are, not as an axis says") {
  // Corner to corner along the diagonal; edge to edge; corner to edge.
  contacts c = find(unit_box({1.01, 1.01, 1.01}), unit_box({0, 0, 0}), 0.02);
  REQUIRE(c.size() == 1);
  CHECK(c[0].gap == doctest::Approx(0.01 * std::sqrt(3.)));
  CHECK((c[0].normal - vec3(1, 1, 1).normalized()).norm() < 1e-9);
  CHECK(find(unit_box({1.01, 1.01, 1.01}), unit_box({0, 0, 0}), 0.015).empty());

  c = find(unit_box({1.01, 0.3, 1.01}), unit_box({0, 0, 0}), 0.02);
  REQUIRE(c.size() == 1);
  CHECK(c[0].gap == doctest::Approx(0.01 * std::sqrt(2.)));
  CHECK(c[0].point[1] > -0.21);
  CHECK(c[0].point[1] < 0.51);

  const quat yaw = rotation({0, 0, 1}, pi / 4);
  c = find(unit_box({0.5 + std::sqrt(0.5) + 0.01, 0, 1.01}, yaw), unit_box({0, 0, 0}), 0.02);
  REQUIRE(c.size() == 1);
  CHECK(c[0].gap == doctest::Approx(0.01 * std::sqrt(2.)));
  CHECK((c[0].point - vec3(0.505, 0, 0.505)).norm() < 1e-12);
}

TEST_CASE("parallel edges and boxes in line do no harm") {
  for (const real angle : {0., 1e-12, 1e-9, 1e-6, 1e-5, 1e-4, 1e-3}) {
    INFO("angle " << angle);
    for (const vec3& axis : {vec3(1, 0, 0), vec3(0, 0, 1), vec3(1, 1, 1)}) {
      const posed a = unit_box({0, 0, 0.999}, rotation(axis, angle)), b = unit_box({0, 0, 0});
      const contacts c = find(a, b, 0.02);
      CHECK(c.size() == 4);
      CHECK(smallest_gap(c) == doctest::Approx(-0.001 - angle).epsilon(1).scale(1e-3));
      check_sound(a, b, c, 0.02);
    }
    // Edge above parallel edge, both standing on edge: a line of contact, two points or one.
    const quat edge = rotation({1, 0, 0}, pi / 4);
    const posed a = unit_box({0.25, 0, std::sqrt(2.) - 0.001}, rotation({0, 0, 1}, angle) * edge);
    const contacts c = find(a, unit_box({0, 0, 0}, edge), 0.02);
    CHECK(!c.empty());
    check_sound(a, unit_box({0, 0, 0}, edge), c, 0.02);
  }
  // Concentric boxes: any unit normal, the correct depth.
  const contacts same = find(unit_box({1, 2, 3}), unit_box({1, 2, 3}), 0);
  REQUIRE(same.size() == 4);
  CHECK(smallest_gap(same) == doctest::Approx(-1));
  // One edge lying on a face gives its two ends.
  const contacts line = find(unit_box({0, 0, 0.5 + std::sqrt(0.5)}, rotation({1, 0, 0}, pi / 4)),
                             unit_box({0, 0, 0}), 0.01);
  REQUIRE(line.size() == 2);
  CHECK(std::abs(line[0].point[0] - line[1].point[0]) == doctest::Approx(1));
}

TEST_CASE("random boxes: right gaps, sound points, no pair missed") {
  std::uint64_t separate = 0, overlapping = 0, touching = 0, patches = 0;
#ifdef __SANITIZE_ADDRESS__
  constexpr std::uint64_t seeds = 4000;
#else
  constexpr std::uint64_t seeds = 20000;
#endif
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const real flat = seed % 4 == 0 ? 0.05 : 0.3;
    const auto size = [&] { return vec3{random(flat, 2), random(flat, 2), random(flat, 2)}; };
    posed a{box{size()}, {random.point(4), random.turn()}};
    posed b{box{size()}, {random.point(4), random.turn()}};
    if (seed % 3 == 0) b.at.orientation = a.at.orientation * rotation(random.direction(), 0.05);
    if (seed % 7 == 0) b.at.orientation = a.at.orientation * rotation({0, 0, 1}, random(0, 3));
    // Brings a near b along a random line: bisects to touch, then shifts by a little.
    const vec3 line = random.direction();
    real near = 0, far = 8;
    for (int k = 0; k < 40; ++k) {
      const real t = (near + far) / 2;
      a.at.position = b.at.position + t * line;
      (best_axis(a, b) > 0 ? far : near) = t;
    }
    const real margin = 0.1;
    a.at.position = b.at.position + (near + random(-0.1, 0.15)) * line;

    const contacts found = find(a, b, margin);
    check_sound(a, b, found, margin);
    patches += found.size() > 2;
    const real smallest = smallest_half(a, b);
    const real best = best_axis(a, b);
    if (best > 1e-5) {
      const real distance = projected_distance(a, b);
      CHECK(distance >= best - 1e-9);
      if (distance > margin + 1e-6) {
        ++separate;
        CHECK(found.empty());
      } else if (distance < margin - 1e-6) {
        ++touching;
        REQUIRE(!found.empty());
        // Of the nearest points, or within five percent of it if a face replaces them.
        CHECK(smallest_gap(found) <= distance * 1.051 + 1e-4 * smallest + 1e-7);
        CHECK(smallest_gap(found) >= best - 1e-4 * smallest);
        if (found.size() == 1 && gap_along(a, b, found[0].normal) > best + 1e-9)
          CHECK(smallest_gap(found) == doctest::Approx(distance).epsilon(1e-4));
      }
    } else if (best < -1e-9) {
      ++overlapping;
      REQUIRE(!found.empty());
      const real slack = 0.0051 * smallest + 0.051 * std::abs(best);
      CHECK(smallest_gap(found) <= best + slack);
      CHECK(smallest_gap(found) >= best - 2.1 * slack);
      // Moving a out along the normal by the depth along it makes them just touch.
      posed out = a;
      out.at.position -= (smallest_gap(found) - slack) * found[0].normal;
      CHECK(best_axis(out, b) > -1e-9);
    }
  }
  MESSAGE("separate " << separate << ", near " << touching << ", overlapping " << overlapping
                      << ", patches " << patches);
  CHECK(separate > seeds / 20);
  CHECK(touching > 3 * seeds / 20);
  CHECK(overlapping > 3 * seeds / 20);
  CHECK(patches > 3 * seeds / 20);
}

TEST_CASE("gaps grow by h when a moves by h along the normal; moving both changes nothing") {
  int same = 0, total = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const auto size = [&] { return vec3{random(0.3, 2), random(0.3, 2), random(0.3, 2)}; };
    posed a{box{size()}, {random.point(1), random.turn()}};
    posed b{box{size()}, {random.point(1), random.turn()}};
    const real margin = 0.2;
    const contacts found = find(a, b, margin);
    const contacts again = find(a, b, margin);
    const contacts swapped = find(b, a, margin);
    CHECK(swapped.empty() == found.empty());
    if (found.empty()) continue;
    const real depth = std::abs(smallest_gap(found));
    CHECK(std::abs(smallest_gap(swapped) - smallest_gap(found)) <=
          0.011 * smallest_half(a, b) + 0.11 * depth);
    ++total;

    const real h = 1e-7;
    posed shifted = a;
    shifted.at.position += h * found[0].normal;
    const contacts after = find(shifted, b, margin);
    const pose by{random.point(5), random.turn()};
    const contacts moved =
        find({a.shape, {by.to_world(a.at.position), by.orientation * a.at.orientation}},
             {b.shape, {by.to_world(b.at.position), by.orientation * b.at.orientation}}, margin);
    REQUIRE(again.size() == found.size());
    if (feature_ids(after) != feature_ids(found) || feature_ids(moved) != feature_ids(found))
      continue;
    ++same;
    for (std::size_t k = 0; k < found.size(); ++k) {
      CHECK(again[k].point == found[k].point);
      CHECK(again[k].gap == found[k].gap);
      CHECK(again[k].feature == found[k].feature);
      CHECK(after[k].gap - found[k].gap == doctest::Approx(h).epsilon(1e-4));
      CHECK(std::abs(moved[k].gap - found[k].gap) < 1e-11);
      CHECK((moved[k].normal - by.orientation * found[k].normal).norm() < 1e-9);
      CHECK((moved[k].point - by.to_world(found[k].point)).norm() < 1e-9);
    }
  }
  CHECK(total > 1000);
  CHECK(same > 0.995 * total);
}

TEST_CASE("a resting box keeps its normal and its features while it trembles") {
  const struct {
    const char* name;
    posed below, above;
    unsigned points;
  } scenes[] = {
      {"flush", unit_box({0, 0, 0}), unit_box({0, 0, 1}), 4},
      {"flush in a row", unit_box({0, 0, 0}), unit_box({1, 0, 0}), 4},
      {"brick on brick",
       {box{{4, 2, 1.6}}, pose{}},
       {box{{4, 2, 1.6}}, {{2, 0, 1.6}, quat::Identity()}},
       4},
      {"eight corners", unit_box({0, 0, 0}), unit_box({0, 0, 1}, rotation({0, 0, 1}, pi / 4)), 4},
      {"oblique", unit_box({0, 0, 0}), unit_box({0.3, 0.2, 1}, rotation({0, 0, 1}, 0.3)), 4},
      {"small on large", {box{{9, 9, 1}}, pose{}}, unit_box({2, 1, 1}, rotation({0, 0, 1}, 1)), 4},
      {"large on small",
       unit_box({0, 0, 0}),
       {box{{9, 9, 1}}, {{2, 1, 1}, rotation({0, 0, 1}, 1)}},
       4},
  };
  for (const auto& scene : scenes)
    for (const bool swap : {false, true}) {
      INFO("scene '" << std::string(scene.name) << "', swapped " << swap << ", seed 9");
      generator random{std::mt19937_64(9)};
      const contacts still =
          swap ? find(scene.above, scene.below, 0.02) : find(scene.below, scene.above, 0.02);
      REQUIRE(still.size() == scene.points);
      for (int k = 0; k < 300; ++k) {
        posed above = scene.above;
        above.at.position += random.point(1e-4);
        above.at.orientation = rotation(random.direction(), random(0, 1e-4)) * above.at.orientation;
        const contacts now = swap ? find(above, scene.below, 0.02) : find(scene.below, above, 0.02);
        CHECK(feature_ids(now) == feature_ids(still));
        CHECK((now.at(0).normal - still[0].normal).norm() < 2e-4);
      }
    }
}

TEST_CASE(
    "a box that slides and turns on another keeps its features, so that its load is stored_entry") {
  const posed below = unit_box({0, 0, 0});
  for (const bool swap : {false, true}) {
    const auto names = [&](const posed& above) {
      return feature_ids(swap ? find(above, below, 0.02) : find(below, above, 0.02));
    };
    const auto still = names(unit_box({0, 0, 1}));
    CHECK(still.size() == 4);
    generator random{std::mt19937_64(4)};
    for (int k = 0; k < 1000; ++k) {
      const vec3 shift{random(-0.7, 0.7), random(-0.7, 0.7), 1};
      CHECK(names(unit_box(shift)) == still);
      const quat turn = rotation({0, 0, 1}, random(-0.3, 0.3));
      CHECK(names(unit_box({0.01 * shift[0], 0.01 * shift[1], 1}, turn)) == still);
    }
  }
}

TEST_CASE("no point of a meeting is named twice, parallel edges and coincident corners included") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const auto quarter = [&] { return std::round(random(-4, 4)) * pi / 8; };
    for (int k = 0; k < 30000; ++k) {
      const quat turn = rotation({1, 0, 0}, quarter()) * rotation({0, 1, 0}, quarter());
      const vec3 at = rounded(random.point(6)) / 4;
      const contacts c = find(unit_box({0, 0, 0}, rotation({0, 0, 1}, quarter())),
                              unit_box(at, turn * rotation({0, 0, 1}, quarter())), 0.05);
      CHECK(feature_ids(c).size() == c.size());
    }
  }
}

TEST_CASE("of a patch with many corners the deepest and a large area are kept") {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const vec3 axis{random(-1, 1), random(-1, 1), 0};
    const quat tilt = rotation(axis, random(0, 0.02));
    const posed above = unit_box({random(-0.1, 0.1), random(-0.1, 0.1), 1},
                                 tilt * rotation({0, 0, 1}, random(0.5, 1)));
    const contacts c = find(unit_box({0, 0, 0}), above, 0.1);
    REQUIRE(c.size() == 4);
    check_sound(unit_box({0, 0, 0}), above, c, 0.1);
    // The deepest point of the overlap along the normal, by sampling the lower face.
    real deepest = 1;
    for (int x = 0; x <= 40; ++x)
      for (int y = 0; y <= 40; ++y) {
        const vec3 p = above.at.to_world({x / 40. - 0.5, y / 40. - 0.5, -0.5});
        if (std::abs(p[0]) <= 0.5 && std::abs(p[1]) <= 0.5) deepest = std::min(deepest, p[2] - 0.5);
      }
    CHECK(smallest_gap(c) <= deepest + 1e-4);
    vec3 middle = vec3::Zero();
    for (const contact_geometry& k : c) middle += k.point / 4;
    CHECK(std::hypot(middle[0], middle[1]) < 0.3);
  }
}
