// Contacts of sharp rims: of a lens (examples/own_shape), known by its support function alone, and
// of a cylinder.
#include <doctest/doctest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "../../examples/own_shape/lens.hpp"
#include "../generator.hpp"

using namespace talus;

namespace {

const lens flat{.radius = 1, .thickness = 0.5};

contact_geometry touch(const pose& pa, const pose& pb) {
  int count = 0;
  contact_geometry found;
  collide_pair(flat, pa, flat, pb, 10, [&](const contact_geometry& c) { found = c, ++count; });
  REQUIRE(count == 1);
  return found;
}
vec3 support(const pose& at, const vec3& d) {
  return at.to_world(flat.support(at.orientation.conjugate() * d));
}
real gap_along(const pose& pa, const pose& pb, const vec3& n) {
  return n.dot(support(pa, -n) - support(pb, n));
}

}  // namespace

TEST_CASE("two lenses touch with their caps as balls do") {
  int caps = 0;
  const real R = flat.ball(), c = R - flat.thickness / 2;  // of a ball, and of its centre
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const auto leaning = [&] { return rotation(random.direction(), random(0, 0.4)); };
    const pose pa{random.point(vec3(0.5, 0.5, 0.05)) + vec3(0, 0, 0.52), leaning()},
        pb{vec3(0, 0, 0), leaning()};
    const vec3 up = pb.orientation * vec3(0, 0, 1), down = pa.orientation * vec3(0, 0, -1);
    // The upper cap of b and the lower one of a, if these face each other.
    const vec3 between = pa.position - c * down - (-c * up), n = between.normalized();
    const real cosine = c / R;
    const real gap = between.norm() - 2 * R;
    if (n.dot(up) < cosine + 0.02 || -n.dot(down) < cosine + 0.02 || gap < -0.01) continue;
    const contact_geometry found = touch(pa, pb);
    CHECK((found.normal - n).norm() < 1e-9);
    CHECK(std::abs(found.gap - gap) < 1e-12);
    ++caps;
  }
  MESSAGE(caps, " pairs");
  CHECK(caps > 200);
}

TEST_CASE("the gap of two sharp rims does not jump while one lens slides past another") {
  real worst_gap = 0, worst_vector = 0, worst_direction = 0;
  const real step = 1e-3;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    // Rims that are nearly parallel, level or upright, and any.
    const quat turn = seed % 3 == 0   ? random.turn()
                      : seed % 3 == 1 ? rotation(random.direction(), random(0, 0.02))
                                      : rotation({1, 0, 0}, pi / 2 + random(-0.02, 0.02));
    const pose pb{vec3(0, 0, 0), quat(1, 0, 0, 0)};
    const real side = random(-0.3, 0.3), height = random(-0.05, 0.05);
    contact_geometry before;
    for (int k = 0; k <= 1000; ++k) {
      const pose pa{{2.3 - k * step, side, height}, turn};
      const contact_geometry now = touch(pa, pb);
      CHECK(std::abs(now.normal.norm() - 1) < 1e-12);
      worst_direction =
          std::max(worst_direction, std::abs(gap_along(pa, pb, now.normal) - now.gap));
      if (k > 0) {
        worst_gap = std::max(worst_gap, std::abs(now.gap - before.gap) - step);
        if (now.gap > 1e-3 && before.gap > 1e-3)
          worst_vector = std::max(
              worst_vector, (now.gap * now.normal - before.gap * before.normal).norm() - step);
      }
      before = now;
    }
  }
  MESSAGE("beyond the step: the gap by ", worst_gap, ", the vector between nearest points by ",
          worst_vector, "; the gap is wrong along its normal by ", worst_direction);
  CHECK(worst_gap < 1e-6);
  CHECK(worst_vector < 1e-9);
  CHECK(worst_direction < 1e-12);
}

TEST_CASE("a cylinder's rim above a ridge by as little as round-off is pushed away from it") {
  const quat q = rotation(vec3(1, 1, 0.3).normalized(), 0.7);
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= 40000; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const real wide = std::pow(10, random(-3.5, -0.5));
    std::vector<vec3> corners;
    for (const real y : {-9, 9})
      for (const auto& [x, z] : {std::pair{-wide, -wide}, {0.0, 0.0}, {-wide, -5.0}, {0.0, -5.0}})
        corners.push_back(q * vec3(x, y, z));
    const convex_polyhedron ridge(corners);
    // The lowest point of one end of a lying cylinder.
    const real angle = random(0.1, 0.3), beside = std::pow(10, random(-12, -4));
    const vec3 axis(-std::sin(angle), std::cos(angle), 0),
        low(beside, 1, std::pow(10, random(-13, -7)));
    const pose at{vec3(q * (low - axis + vec3(0, 0, 1))),
                  quat(q * rotation({0, 0, 1}, angle) * rotation({1, 0, 0}, -pi / 2))};
    collide_pair(cylinder{1, 2}, at, ridge, placed(ridge), 1e-4, [&](const contact_geometry& c) {
      CHECK((q.conjugate() * c.normal)[2] > 0);
      ++tried;
    });
  }
  CHECK(tried >= 40000);
}
