// Contacts of ellipsoids with all other shapes: the limit of equal axes, closed forms, nearest
// points to rounding errors, the same wherever both are moved, and no jumps while one rolls.
#include <doctest/doctest.h>

#include "solids.hpp"
#include "talus/mesh.hpp"
#include "talus/shape/ellipsoid.hpp"

using namespace solids;

namespace {

ellipsoid random_ellipsoid(generator& random) {
  const real flat = random(0, 1) < 0.2 ? 0.2 : 0.4;
  return {{random(flat, 1), random(flat, 1), random(flat, 1)}};
}
template <class A, class B>
contacts find(const A& a, const pose& pa, const B& b, const pose& pb, real margin) {
  contacts found;
  collide_pair(a, pa, b, pb, margin, [&](const contact_geometry& c) { found.push_back(c); });
  return found;
}
template <class A>
contacts find(const A& a, const pose& pa, const solid& b, real margin) {
  return std::visit([&](const auto& s) { return find(a, pa, s, b.at, margin); }, b.shape);
}
/// A point of the surface of an ellipsoid has the value 1.
real level(const ellipsoid& e, const pose& at, const vec3& p) {
  const vec3 x = at.to_body(p);
  return std::sqrt((x[0] * x[0]) / (e.radii[0] * e.radii[0]) +
                   (x[1] * x[1]) / (e.radii[1] * e.radii[1]) +
                   (x[2] * x[2]) / (e.radii[2] * e.radii[2]));
}
/// The outward unit normal at a point of the surface.
vec3 outward(const ellipsoid& e, const pose& at, const vec3& p) {
  const vec3 x = at.to_body(p);
  return at.orientation * x.cwiseQuotient(e.radii.cwiseProduct(e.radii)).normalized();
}
vec3 support(const ellipsoid& e, const pose& at, const vec3& d) {
  return at.to_world(e.support(at.orientation.conjugate() * d));
}

}  // namespace

TEST_CASE("an ellipsoid with equal axes has the contacts of a sphere, with every shape") {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 6000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const real r = random(0.3, 1);
    const pose at{random.point(1), random.turn()};
    const solid other{random_shape(seed % 5, random), {random.point(1.2), random.turn()}};
    INFO("seed " << seed << ", " << other.name());
    const contacts of_ball = find(sphere{r}, at, other, 0.2);
    if (of_ball.empty() || of_ball[0].gap < -0.05 * std::min(r, other.smallest())) continue;
    const contacts of_egg = find(ellipsoid{{r, r, r}}, at, other, 0.2);
    REQUIRE(of_egg.size() == 1);
    CHECK(std::abs(of_egg[0].gap - of_ball[0].gap) < 1e-10);
    CHECK((of_egg[0].normal - of_ball[0].normal).norm() < 1e-10);
    CHECK((of_egg[0].point - of_ball[0].point).norm() < 1e-10);
    ++compared;
  }
  MESSAGE(compared, " pairs");
  CHECK(compared > 500);
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    generator random{std::mt19937_64(seed)};
    const real r = random(0.3, 1);
    const triangle_mesh tube = tube_surface({.radius = 2, .height = 3}, {.sectors = 9});
    const pose at{random.point(1) + vec3(1, 0, 1.5), random.turn()};
    const contacts of_ball = find(sphere{r}, at, tube, pose{}, 0.1);
    const contacts of_egg = find(ellipsoid{{r, r, r}}, at, tube, pose{}, 0.1);
    if (of_ball.empty() || smallest_gap(of_ball) < -0.05 * r) continue;
    CHECK(std::abs(smallest_gap(of_ball) - smallest_gap(of_egg)) < 1e-10);
    CHECK((deepest(of_ball).normal - deepest(of_egg).normal).norm() < 1e-9);
  }
}

TEST_CASE("an ellipsoid touches two planes where the closed form says") {
  generator random{std::mt19937_64(3)};
  for (int k = 0; k < 200; ++k) {
    const ellipsoid e = random_ellipsoid(random);
    const pose at{random.point(2), random.turn()};
    const vec3 up = random.direction();
    const vec3 d = at.orientation.conjugate() * up;
    const real reach = std::sqrt(d.cwiseProduct(e.radii).squaredNorm());
    for (const real sign : {1., -1.}) {
      const plane wall{sign * up, sign * up.dot(at.position) - reach - 0.01};
      const contacts found = find(e, at, wall, pose{}, 0.1);
      REQUIRE(found.size() == 1);
      const vec3 foot =
          at.to_world(vec3(-sign / reach * d.cwiseProduct(e.radii).cwiseProduct(e.radii)));
      CHECK(found[0].gap == doctest::Approx(0.01).epsilon(1e-12));
      CHECK((found[0].point + sign * 0.005 * up - foot).norm() < 1e-14);
    }
  }
}

TEST_CASE("the nearest points of ellipsoids lie on both surfaces, with one normal") {
  int found_pairs = 0;
  for (std::uint64_t seed = 1; seed <= 20000; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const ellipsoid a = random_ellipsoid(random), b = random_ellipsoid(random);
    const pose pa{random.point(1), random.turn()}, pb{random.point(1), random.turn()};
    const contacts found = find(a, pa, b, pb, 0.3);
    REQUIRE(found.size() <= 1);
    if (found.empty() || found[0].gap < -0.1 * std::min(a.inner_radius(), b.inner_radius()))
      continue;
    ++found_pairs;
    const contact_geometry& c = found[0];
    const vec3 on_a = c.point + 0.5 * c.gap * c.normal, on_b = c.point - 0.5 * c.gap * c.normal;
    CHECK(std::abs(level(a, pa, on_a) - 1) < 1e-12);
    CHECK(std::abs(level(b, pb, on_b) - 1) < 1e-12);
    CHECK(std::abs(c.normal.dot(support(a, pa, -c.normal) - support(b, pb, c.normal)) - c.gap) <
          1e-13);
    CHECK((support(a, pa, -c.normal) - on_a).norm() < 1e-12);
    CHECK((support(b, pb, c.normal) - on_b).norm() < 1e-12);
    CHECK((outward(a, pa, on_a) + c.normal).norm() < 1e-11);
    CHECK((outward(b, pb, on_b) - c.normal).norm() < 1e-11);
    // No other direction is better.
    for (int k = 0; k < 20; ++k) {
      const vec3 n = (c.normal + random(0, 1) * random.direction()).normalized();
      CHECK(n.dot(support(a, pa, -n) - support(b, pb, n)) <= c.gap + 1e-13);
    }
    const pose by{random.point(3), random.turn()};
    const contacts moved =
        find(a, pose{by.to_world(pa.position), by.orientation * pa.orientation}, b,
             pose{by.to_world(pb.position), by.orientation * pb.orientation}, 0.3);
    REQUIRE(moved.size() == 1);
    CHECK(std::abs(moved[0].gap - c.gap) < 1e-13);
    CHECK((moved[0].point - by.to_world(c.point)).norm() < 1e-12);
    CHECK((moved[0].normal - by.orientation * c.normal).norm() < 1e-12);
    const contacts swapped = find(b, pb, a, pa, 0.3);
    REQUIRE(swapped.size() == 1);
    CHECK((swapped[0].normal + c.normal).norm() < 1e-12);
    CHECK((swapped[0].point - c.point).norm() < 1e-12);
  }
  MESSAGE(found_pairs, " pairs");
  CHECK(found_pairs > 3000);
}

TEST_CASE("contacts of ellipsoids and balls of all sizes are those of usual ones, scaled") {
  int compared = 0;
  for (int power = -119; power <= 119; ++power)
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      INFO("size 1e" << power << ", seed " << seed);
      generator random{std::mt19937_64(seed)};
      const ellipsoid a = random_ellipsoid(random), b = random_ellipsoid(random);
      const sphere ball{random(0.3, 1)};
      const real size = random(1, 2) * std::pow(10, power);
      const pose at{{0, 0, 0}, random.turn()};
      pose there{3 * random.point(1).normalized(), random.turn()};
      const auto compare = [&](const auto& other, const auto& larger_one) {
        // To a gap beside the margin, or a small overlap.
        const real gap = random(-0.01, 0.1), margin = 0.05;
        for (int k = 0; k < 2; ++k)
          for (const contact_geometry& g : find(a, at, other, there, 10))
            there.position += (g.gap - gap) * g.normal;
        pose far = there;
        far.position = size * there.position;
        const contacts usual = find(a, at, other, there, margin);
        const contacts scaled = find(ellipsoid{size * a.radii}, at, larger_one, far, size * margin);
        REQUIRE(usual.size() == scaled.size());
        for (std::size_t k = 0; k < usual.size(); ++k) {
          CHECK(std::abs(scaled[k].gap / size - usual[k].gap) < 1e-10);
          CHECK((scaled[k].normal - usual[k].normal).norm() < 1e-10);
          CHECK((scaled[k].point / size - usual[k].point).norm() < 1e-10);
          ++compared;
        }
      };
      compare(b, ellipsoid{size * b.radii});
      compare(ball, sphere{size * ball.radius});
    }
  CHECK(compared > 3000);
}

TEST_CASE("the nearest points of an ellipsoid and any other shape are exact") {
  int all = 0;
  for (std::uint64_t seed = 1; seed <= 20000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const ellipsoid a = random_ellipsoid(random);
    const pose pa{random.point(1), random.turn()};
    const solid b{random_shape(seed % 5, random), {random.point(1.2), random.turn()}};
    INFO("seed " << seed << ", " << b.name());
    const contacts found = find(a, pa, b, 0.2);
    REQUIRE(found.size() <= 1);
    if (found.empty() || found[0].gap < -0.05 * std::min(a.inner_radius(), b.smallest())) continue;
    const contact_geometry& c = found[0];
    ++all;
    const vec3 on_a = c.point + 0.5 * c.gap * c.normal, on_b = c.point - 0.5 * c.gap * c.normal;
    CHECK(std::abs(c.normal.dot(support(a, pa, -c.normal) - b.support(c.normal)) - c.gap) < 1e-12);
    CHECK((support(a, pa, -c.normal) - on_a).norm() < 1e-11);
    CHECK((outward(a, pa, on_a) + c.normal).norm() < 1e-9);
    CHECK(std::abs(b.outside(on_b)) < 1e-12);
    CHECK(std::abs(c.normal.dot(b.support(c.normal) - on_b)) < 1e-12);
    // No other direction is better.
    for (int k = 0; k < 20; ++k) {
      const vec3 n = (c.normal + random(0, 0.3) * random.direction()).normalized();
      CHECK(n.dot(support(a, pa, -n) - b.support(n)) <= c.gap + 1e-12);
    }
  }
  MESSAGE(all, " pairs");
  CHECK(all > 2500);
}

TEST_CASE("normals and points do not jump while an ellipsoid rolls over a box and an ellipsoid") {
  const ellipsoid e{{0.5, 0.4, 0.3}};
  const box b{{1, 1, 1}};
  const ellipsoid under{{0.6, 0.5, 0.5}};
  for (const real depth : {0.02, -0.001}) {
    vec3 before[2], place[2];
    const int steps = 8000;
    for (int k = 0; k <= steps; ++k) {
      const real x = -0.8 + 1.6 * k / steps;
      // The path keeps the ellipsoid near the surface: over the box, round its edge.
      const quat turn = rotation({0, 1, 0}, 5 * x) * rotation({1, 0, 0}, 0.3);
      pose at{{x, 0.1, 2}, turn};
      const auto drop = [&](const auto& s) {
        for (int i = 0; i < 200; ++i) {
          const contacts c = find(e, at, s, pose{}, 2);
          REQUIRE(c.size() == 1);
          at.position[2] -= (c[0].gap - depth) / std::max(0.7, c[0].normal[2]);
          if (std::abs(c[0].gap - depth) < 1e-13) break;
        }
        return find(e, at, s, pose{}, 2)[0];
      };
      int m = 0;
      for (const contact_geometry& c : {drop(b), drop(under)}) {
        if (k > 0 && c.normal[2] > 0.3) {
          CHECK((c.normal - before[m]).norm() < 4e-3);
          CHECK((c.point - place[m]).norm() < 4e-3);
        }
        before[m] = c.normal, place[m] = c.point;
        ++m;
        at.position[2] = 2;
      }
    }
  }
}
