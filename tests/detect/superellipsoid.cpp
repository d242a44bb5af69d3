// Contacts of superellipsoids with all other shapes: the limit of ellipsoids, closed forms, nearest
// points to rounding errors, the same wherever both are moved, and no jumps while one rolls.
// timeout: 300
#include <doctest/doctest.h>

#include "solids.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/superellipsoid.hpp"

using namespace solids;

namespace {

superellipsoid random_form(generator& random) {
  const real flat = random(0, 1) < 0.2 ? 0.2 : 0.4;
  superellipsoid s{{random(flat, 1), random(flat, 1), random(flat, 1)}};
  const real kind = random(0, 1);
  s.n1 = kind < 0.1 ? 2 : kind < 0.3 ? 8 : random(2, 8);
  s.n2 = kind > 0.9 ? 2 : kind < 0.2 ? 8 : random(2, 8);
  return s;
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
/// A point of the surface has the value 1.
real level(const superellipsoid& s, const vec3& x) {
  const real across =
      std::pow(std::abs(x[0] / s.radii[0]), s.n2) + std::pow(std::abs(x[1] / s.radii[1]), s.n2);
  return std::pow(across, s.n1 / s.n2) + std::pow(std::abs(x[2] / s.radii[2]), s.n1);
}
/// The outward normal there.
vec3 normal_at(const superellipsoid& s, const vec3& x) {
  const vec3 u = x.cwiseQuotient(s.radii);
  const real across = std::pow(std::abs(u[0]), s.n2) + std::pow(std::abs(u[1]), s.n2);
  const real outer = across > 0 ? std::pow(across, s.n1 / s.n2 - 1) : 0;
  const auto along = [](real x, real n) { return std::copysign(std::pow(std::abs(x), n - 1), x); };
  return vec3(outer * along(u[0], s.n2) / s.radii[0], outer * along(u[1], s.n2) / s.radii[1],
              along(u[2], s.n1) / s.radii[2])
      .normalized();
}
vec3 support(const superellipsoid& s, const pose& at, const vec3& d) {
  return at.to_world(s.support(at.orientation.conjugate() * d));
}
real gap_along(const superellipsoid& a, const pose& pa, const superellipsoid& b, const pose& pb,
               const vec3& n) {
  return n.dot(support(a, pa, -n) - support(b, pb, n));
}
/// Two bodies near each other, often with parallel axes, often face to face.
struct couple {
  superellipsoid a, b;
  pose pa, pb;
  explicit couple(std::uint64_t seed) {
    generator random{std::mt19937_64(seed)};
    a = random_form(random), b = random_form(random);
    pa = {random.point(1), random.turn()}, pb = {{0, 0, 0}, random.turn()};
    if (seed % 3 == 0) pb.orientation = pa.orientation;
    vec3 d = random.direction();
    if (seed % 4 == 0) d = (d * 0.2 + vec3::Unit(seed % 5 % 3)).normalized();
    d = pa.orientation * d;  // from b to a
    pb.position = pa.position;
    pb.position += (gap_along(a, pa, b, pb, d) - random(-0.05, 0.05)) * d;
  }
};

}  // namespace

TEST_CASE("a superellipsoid with the exponents 2 has the contacts of an ellipsoid") {
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 6000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const ellipsoid egg{{random(0.3, 1), random(0.3, 1), random(0.3, 1)}};
    const superellipsoid same{egg.radii};
    const pose at{random.point(1), random.turn()};
    const auto compare = [&](const contacts& of_egg, const contacts& found, real smallest,
                             real tolerance = 1e-10) {
      if (of_egg.empty() || of_egg[0].gap < -0.05 * smallest) return;
      REQUIRE(found.size() == 1);
      CHECK(std::abs(found[0].gap - of_egg[0].gap) < 1e-10);
      CHECK((found[0].normal - of_egg[0].normal).norm() < tolerance);
      CHECK((found[0].point - of_egg[0].point).norm() < tolerance);
      ++compared;
    };
    const solid other{random_shape(seed % 5, random), {random.point(1.2), random.turn()}};
    INFO("seed " << seed << ", " << other.name());
    compare(find(egg, at, other, 0.2), find(same, at, other, 0.2),
            std::min(egg.inner_radius(), other.smallest()),
            // Beside the edge of a face, rounding errors decide between the two.
            other.shape.index() == 0 || other.shape.index() == 2 ? 1e-10 : 1e-6);
    const ellipsoid second{{random(0.3, 1), random(0.3, 1), random(0.3, 1)}};
    const pose there{random.point(1.2), random.turn()};
    const real smallest = std::min(egg.inner_radius(), second.inner_radius());
    const contacts of_eggs = find(egg, at, second, there, 0.2);
    compare(of_eggs, find(same, at, second, there, 0.2), smallest);
    compare(of_eggs, find(egg, at, superellipsoid{second.radii}, there, 0.2), smallest);
    compare(of_eggs, find(same, at, superellipsoid{second.radii}, there, 0.2), smallest);
    const plane wall{random.direction(), 0};
    compare(find(egg, at, wall, pose{}, 0.2), find(same, at, wall, pose{}, 0.2), 1e9);
  }
  MESSAGE(compared, " pairs");
  CHECK(compared > 5000);
}

TEST_CASE("a superellipsoid touches a plane where its normal is that of the plane") {
  generator random{std::mt19937_64(3)};
  for (int k = 0; k < 500; ++k) {
    const superellipsoid s = random_form(random);
    const pose at{random.point(2), random.turn()};
    const vec3 up = random.direction();
    for (const real sign : {1., -1.}) {
      const vec3 foot = support(s, at, -sign * up);
      const plane wall{sign * up, sign * up.dot(foot) - 0.01};
      const contacts found = find(s, at, wall, pose{}, 0.1);
      REQUIRE(found.size() == 1);
      CHECK(found[0].gap == doctest::Approx(0.01).epsilon(1e-12));
      const vec3 x = at.to_body(found[0].point + sign * 0.005 * up);
      CHECK(std::abs(level(s, x) - 1) < 1e-13);
      CHECK((at.orientation * normal_at(s, x) + sign * up).norm() < 1e-13);
    }
  }
}

TEST_CASE("the nearest points of superellipsoids lie on both surfaces, with one normal") {
  int found_pairs = 0, moved_points = 0;
  for (std::uint64_t seed = 1; seed <= 8000; ++seed) {
    INFO("seed " << seed);
    const couple c(seed);
    generator random{std::mt19937_64(seed + 1)};
    const contacts found = find(c.a, c.pa, c.b, c.pb, 0.3);
    REQUIRE(found.size() <= 1);
    if (found.empty() || found[0].gap < -0.1 * std::min(c.a.inner_radius(), c.b.inner_radius()))
      continue;
    ++found_pairs;
    const contact_geometry& g = found[0];
    const vec3 on_a = c.pa.to_body(g.point + 0.5 * g.gap * g.normal),
               on_b = c.pb.to_body(g.point - 0.5 * g.gap * g.normal);
    CHECK(std::abs(level(c.a, on_a) - 1) < 1e-11);
    CHECK(std::abs(level(c.b, on_b) - 1) < 1e-11);
    CHECK((c.pa.orientation * normal_at(c.a, on_a) + g.normal).norm() < 1e-11);
    CHECK((c.pb.orientation * normal_at(c.b, on_b) - g.normal).norm() < 1e-11);
    CHECK(std::abs(gap_along(c.a, c.pa, c.b, c.pb, g.normal) - g.gap) < 1e-12);
    // No other direction is better.
    for (int k = 0; k < 20; ++k) {
      const vec3 n = (g.normal + random(0, 1) * random.direction()).normalized();
      CHECK(gap_along(c.a, c.pa, c.b, c.pb, n) <= g.gap + 1e-12);
    }
    const pose by{random.point(3), random.turn()};
    const contacts moved =
        find(c.a, pose{by.to_world(c.pa.position), by.orientation * c.pa.orientation}, c.b,
             pose{by.to_world(c.pb.position), by.orientation * c.pb.orientation}, 0.3);
    REQUIRE(moved.size() == 1);
    CHECK(std::abs(moved[0].gap - g.gap) < 1e-12);
    CHECK((moved[0].normal - by.orientation * g.normal).norm() < 1e-11);
    const contacts swapped = find(c.b, c.pb, c.a, c.pa, 0.3);
    REQUIRE(swapped.size() == 1);
    CHECK(std::abs(swapped[0].gap - g.gap) < 1e-12);
    CHECK((swapped[0].normal + g.normal).norm() < 1e-11);
    // Where both are flat, the place is free within rounding errors.
    moved_points += (moved[0].point - by.to_world(g.point)).norm() > 1e-9 ||
                    (swapped[0].point - g.point).norm() > 1e-9;
  }
  MESSAGE(found_pairs, " pairs, of which ", moved_points, " have points that are not determined");
  CHECK(found_pairs > 4000);
  CHECK(moved_points < 0.05 * found_pairs);
}

TEST_CASE("a superellipsoid and any other shape have the gap along the best normal") {
  int all = 0;
  real worst = 0;
  for (std::uint64_t seed = 1; seed <= 8000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const superellipsoid a = random_form(random);
    const pose pa{random.point(1), random.turn()};
    const solid b{random_shape(seed % 5, random), {random.point(1.2), random.turn()}};
    INFO("seed " << seed << ", " << b.name());
    const contacts found = find(a, pa, b, 0.2);
    REQUIRE(found.size() <= 1);
    if (found.empty() || found[0].gap < -0.05 * std::min(a.inner_radius(), b.smallest())) continue;
    const contact_geometry& c = found[0];
    ++all;
    const vec3 on_a = pa.to_body(c.point + 0.5 * c.gap * c.normal),
               on_b = c.point - 0.5 * c.gap * c.normal;
    worst = std::max({worst, std::abs(level(a, on_a) - 1), std::abs(b.outside(on_b)),
                      (pa.orientation * normal_at(a, on_a) + c.normal).norm()});
    CHECK(std::abs(c.normal.dot(support(a, pa, -c.normal) - b.support(c.normal)) - c.gap) < 1e-6);
    for (int k = 0; k < 20; ++k) {
      const vec3 n = (c.normal + random(0, 0.3) * random.direction()).normalized();
      CHECK(n.dot(support(a, pa, -n) - b.support(n)) <= c.gap + 1e-6);
    }
  }
  MESSAGE(all, " pairs, points at most ", worst, " beside the surfaces");
  CHECK(all > 1000);
  CHECK(worst < 1e-11);
}

TEST_CASE("contacts of superellipsoids scale with their sizes, and sizes may be far apart") {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    INFO("seed " << seed);
    const couple c(seed);
    const contacts found = find(c.a, c.pa, c.b, c.pb, 0.3);
    for (const real scale : {1e-60, 1e60}) {
      superellipsoid a = c.a, b = c.b;
      a.radii *= scale, b.radii *= scale;
      const contacts scaled = find(a, pose{scale * c.pa.position, c.pa.orientation}, b,
                                   pose{scale * c.pb.position, c.pb.orientation}, 0.3 * scale);
      REQUIRE(scaled.size() == found.size());
      if (found.empty() || found[0].gap < -0.01) continue;
      CHECK(std::abs(scaled[0].gap / scale - found[0].gap) < 1e-12);
      CHECK((scaled[0].normal - found[0].normal).norm() < 1e-11);
    }
    superellipsoid grain = c.b;
    grain.radii *= 1e-4;
    pose at = c.pb;
    generator random{std::mt19937_64(seed)};
    const vec3 up = random.direction();
    at.position = support(c.a, c.pa, up) + 1.2e-4 * up;
    const contacts small = find(c.a, c.pa, grain, at, 1e-3);
    REQUIRE(small.size() == 1);
    CHECK(std::abs(gap_along(c.a, c.pa, grain, at, small[0].normal) - small[0].gap) < 1e-12);
    CHECK(std::abs(small[0].gap) < 3e-4);
  }
}

TEST_CASE("normals and points do not jump while a superellipsoid rolls over another one") {
  for (const real n : {2.5, 4., 8.}) {
    const superellipsoid e{{0.5, 0.4, 0.3}, n, n}, under{{0.6, 0.5, 0.5}, 2, n};
    const ellipsoid egg{{0.6, 0.5, 0.5}};
    for (const real depth : {0.01, -0.001}) {
      vec3 normal_before[2], place_before[2];
      const int steps = 4000;
      for (int k = 0; k <= steps; ++k) {
        const real x = -0.5 + 1.0 * k / steps;
        const quat turn = rotation({0, 1, 0}, 5 * x) * rotation({1, 0, 0}, 0.3);
        pose at{{x, 0.1, 2}, turn};
        const auto drop = [&](const auto& s) {
          contacts c;
          for (int i = 0; i < 200; ++i) {
            c = find(e, at, s, pose{}, 2);
            REQUIRE(c.size() == 1);
            if (std::abs(c[0].gap - depth) < 1e-13) break;
            at.position[2] -= (c[0].gap - depth) / std::max(0.7, c[0].normal[2]);
          }
          return c[0];
        };
        int m = 0;
        for (const contact_geometry& c : {drop(under), drop(egg)}) {
          INFO("n " << n << ", x " << x << ", partner " << m);
          if (k > 0 && c.normal[2] > 0.3) {
            CHECK((c.normal - normal_before[m]).norm() < 5e-3);
            // A turn by the angle w moves the point by up to w^(1/(n-1)) where a surface is flat.
            CHECK((c.point - place_before[m]).norm() < 1.5 * std::pow(1.25e-3, 1 / (n - 1)));
          }
          normal_before[m] = c.normal, place_before[m] = c.point;
          ++m;
          at.position[2] = 2;
        }
      }
    }
  }
}

namespace {

struct error_of_points {
  real worst = 0;
  int tried = 0, worse = 0;
};
/// Bodies about to touch, or just overlapping, with any other shape: how far the points of the
/// deepest contact are from a surface, or the normal from that of one of the surfaces there.
template <class Body, class Make>
error_of_points error_with_any_shape(std::uint64_t seed, const Make& make) {
  generator random{std::mt19937_64(seed)};
  error_of_points all;
  for (std::uint64_t k = 0; k < 6000; ++k) {
    const Body a = make(random);
    const solid b{random_shape(k % 5, random), {{0, 0, 0}, random.turn()}};
    const quat turn = k % 7 == 0 ? b.at.orientation : random.turn();
    const vec3 d = random.direction();
    const auto touch = [&](real way) { return deepest(find(a, pose{way * d, turn}, b, 9)); };
    real low = 0, high = 9;
    for (int n = 0; n < 30; ++n) {
      const real way = (low + high) / 2;
      (touch(way).gap > 0 ? high : low) = way;
    }
    const pose pa{(high + random(-0.005, 0.01)) * d, turn};
    const contact_geometry c = deepest(find(a, pa, b, 9));
    const vec3 on_a = pa.to_body(c.point + 0.5 * c.gap * c.normal),
               on_b = c.point - 0.5 * c.gap * c.normal;
    const surface_level l = detail::as_superellipsoid(a).level(on_a);
    const real error =
        std::max({std::abs(l.value - 1), (turn * unit(l.gradient) + c.normal).norm(),
                  std::abs(b.outside(on_b)), std::abs(c.normal.dot(b.support(c.normal) - on_b))});
    ++all.tried;
    all.worse += error > 1e-12;
    all.worst = std::max(all.worst, error);
  }
  return all;
}

}  // namespace

TEST_CASE("ellipsoids and superellipsoids touch every shape to 1e-12 of the size") {
  const auto radii = [](generator& random, real least) {
    return vec3(random(least, 1.5), random(least, 1.5), random(least, 1.5));
  };
  const auto egg = [&](generator& random) { return ellipsoid{radii(random, 0.3)}; };
  const auto grain = [&](generator& random) {
    return superellipsoid{radii(random, 0.5), random(2, 8), random(2, 8)};
  };
  const auto cube = [&](generator& random) {
    return superellipsoid{radii(random, 0.5), random(0, 1) < 0.5 ? 2. : 8., 8};
  };
  const error_of_points of[] = {error_with_any_shape<ellipsoid>(21, egg),
                                error_with_any_shape<superellipsoid>(22, grain),
                                error_with_any_shape<superellipsoid>(23, cube)};
  for (const error_of_points& e : of) {
    MESSAGE("at most ", e.worst, ", above 1e-12 ", e.worse, " of ", e.tried);
    CHECK(e.tried == 6000);
    CHECK(e.worst < 1e-9);
    CHECK(e.worse < 6);
  }
}
