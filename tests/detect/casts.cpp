// Rays, moving shapes and nearest points against definitions: signed distances of the shapes,
// support functions, and each triangle of a surface.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "../../examples/own_shape/lens.hpp"
#include "solids.hpp"
#include "talus/detect/pairs/mesh_any.hpp"
#include "talus/detect/ray_cast.hpp"
#include "talus/shape/superellipsoid.hpp"
#include "talus/shape/union_of.hpp"

using namespace talus;
using detail::endless;
using detail::surface_hit;

namespace {

using solids::outside;
real outside(const ellipsoid& s, const vec3& p) { return p.cwiseQuotient(s.radii).norm() - 1; }
real outside(const lens& s, const vec3& p) {
  const real c = s.ball() - s.thickness / 2;
  return std::max((p - vec3(0, 0, c)).norm(), (p + vec3(0, 0, c)).norm()) - s.ball();
}
real outside(const superellipsoid& s, const vec3& p) { return s.level(p).value - 1; }
real outside(const plane& s, const vec3& p) { return s.distance(p); }
/// Convex along each line for all convex shapes.
template <class Shape>
real outside_at(const Shape& s, const pose& at, const vec3& p) {
  if constexpr (Shape::finite)
    return outside(s, at.to_body(p));
  else
    return outside(s, p);
}

/// Where a function that is convex falls to zero first, from 0 to `end`; `lowest` is its least
/// value.
template <class F>
real first_zero(F&& f, real end, real& lowest) {
  real a = 0, b = end;
  for (int k = 0; k < 200; ++k) {
    const real x = a + (b - a) / 3, y = b - (b - a) / 3;
    (f(x) <= f(y) ? b : a) = f(x) <= f(y) ? y : x;
  }
  lowest = f(a);
  if (f(0) <= 0) return 0;
  if (lowest > 0) return endless;
  real low = 0, high = a;
  for (int k = 0; k < 200; ++k) {
    const real middle = (low + high) / 2;
    (f(middle) > 0 ? low : high) = middle;
  }
  return high;
}

/// A ray that may hit a body of radius r at a place, from near or far.
struct shot {
  vec3 from, direction;
};
shot random_shot(generator& random, const pose& at, real r, bool far) {
  const vec3 target = at.position + 1.1 * random.point(r);
  const vec3 from = target + (far ? 1e4 : random(0, 4)) * r * random.direction();
  const vec3 way = target - from;
  return {from, way.norm() > 0 ? unit(way) : vec3(0, 0, 1)};
}

template <class Shape>
void test_rays(const Shape& s, const pose& at, generator& random, real size, int& met) {
  const bool far = random(0, 1) < 0.1;
  const shot one = random_shot(random, at, size, far);
  const auto f = [&](real t) { return outside_at(s, at, one.from + t * one.direction); };
  const real length = 2e4 * size, scale = [&] {
    constexpr bool closed = !Shape::finite || detail::cut_by_rays<Shape>;
    return (far ? 1e-10 : closed ? 1e-12 : 1e-9) * size;
  }();
  real lowest = 0;
  const real expected = first_zero(f, length, lowest);
  if (std::abs(lowest) < 1e-5 || std::abs(f(0)) < 1e-7) return;  // grazes, or begins on the surface
  const surface_hit hit = detail::ray_meets(s, at, one.from, one.direction, length);
  REQUIRE(hit.found() == (expected < endless));
  if (!hit.found()) return;
  CAPTURE(hit.distance);
  CAPTURE(expected);
  CHECK(std::abs(hit.distance - expected) < scale * 100);
  CHECK(vec3(hit.point - one.from - hit.distance * one.direction).norm() < 10 * scale);
  CHECK(hit.inside == (expected == 0));
  ++met;
  // A shorter ray ends before.
  if (expected > 0)
    CHECK_FALSE(
        detail::ray_meets(s, at, one.from, one.direction, expected * (1 - 1e-6) - 1e-6).found());
  if (hit.inside) {
    CHECK(hit.normal == -one.direction);
    return;
  }
  CHECK(hit.normal.dot(one.direction) <= 1e-9);
  CHECK(hit.normal.norm() == doctest::Approx(1).epsilon(1e-12));
  // The gradient of the signed distance, away from edges.
  const real h = 1e-6 * size;
  vec3 up(0, 0, 0), down(0, 0, 0);
  for (int k = 0; k < 3; ++k) {
    const vec3 e = h * vec3::Unit(k);
    up[k] = outside_at(s, at, hit.point + e) - outside_at(s, at, hit.point);
    down[k] = outside_at(s, at, hit.point) - outside_at(s, at, hit.point - e);
  }
  if (unit(up).dot(unit(down)) > 1 - 1e-6) CHECK(unit(vec3(up + down)).dot(hit.normal) > 1 - 1e-6);
}

template <class Shape>
void test_nearest(const Shape& s, const pose& at, generator& random, real size) {
  const vec3 p = at.position + random(0, 3) * size * random.direction();
  const real away = outside_at(s, at, p);
  if (std::abs(away) < 1e-6) return;
  const surface_hit hit = detail::nearest_on_shape(s, at, p, endless);
  REQUIRE(hit.found());
  CHECK(hit.inside == (away < 0));
  if (away < 0) {
    CHECK(hit.distance == 0);
    return;
  }
  CHECK(vec3(p - hit.point - hit.distance * hit.normal).norm() < 1e-7 * size);
  CHECK(std::abs(outside_at(s, at, hit.point)) < 1e-7);
  // The plane through the point separates the body from p: nothing of it is nearer.
  if constexpr (Shape::finite) {
    const pose turn{{0, 0, 0}, at.orientation};
    const vec3 furthest = at.to_world(s.support(turn.to_body(hit.normal)));
    CHECK(hit.normal.dot(furthest - hit.point) < 1e-6 * size);
  }
  CHECK_FALSE(detail::nearest_on_shape(s, at, p, hit.distance * (1 - 1e-6)).found());
  CHECK(detail::nearest_on_shape(s, at, p, hit.distance * (1 + 1e-6)).found());
}

/// The answer of a cast proves itself: the surfaces meet at the point, and a plane separates them.
template <class A, class B>
void test_cast(const A& a, const pose& from, const B& b, const pose& at, const vec3& d, real length,
               generator& random, int& met) {
  const surface_hit hit = detail::shape_meets(a, from, b, at, d, length);
  const auto overlaps = [&](real t, real deep) {
    bool deeper = false;
    collide_pair(a, pose{from.position + t * d, from.orientation}, b, at, 0,
                 [&](const contact_geometry& c) { deeper = deeper || c.gap < -deep; });
    return deeper;
  };
  for (int k = 0; k < 20; ++k) {
    const real t = random(0, std::min(length, hit.distance));
    CAPTURE(t - hit.distance);
    if (!hit.inside) CHECK_FALSE(overlaps(t, 1e-6));
  }
  if (!hit.found()) return;
  CAPTURE(hit.distance);
  ++met;
  if (hit.inside) {
    CHECK(overlaps(0, -1e-6));
    return;
  }
  CHECK(std::abs(outside_at(b, at, hit.point)) < 1e-6);
  CHECK(std::abs(outside_at(a, pose{from.position + hit.distance * d, from.orientation},
                            hit.point)) < 2e-6);
  CHECK(hit.normal.dot(d) <= 1e-9);
  const pose turn{{0, 0, 0}, from.orientation};
  const vec3 lowest =
      from.position + hit.distance * d + turn.to_world(a.support(turn.to_body(-hit.normal)));
  CHECK(hit.normal.dot(lowest - hit.point) > -1e-6);
}

convex_polyhedron grain(generator& random) {
  return std::get<convex_polyhedron>(solids::random_shape(4, random));
}
std::vector<triangle_mesh::triangle> hills(int n) {
  std::vector<triangle_mesh::triangle> all;
  const auto p = [&](int i, int j) {
    return vec3(i - n / 2., j - n / 2., 0.6 * std::sin(1.3 * i) + 0.5 * std::cos(0.9 * j + i));
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      all.push_back({p(i, j), p(i + 1, j), p(i + 1, j + 1)});
      all.push_back({p(i, j), p(i + 1, j + 1), p(i, j + 1)});
    }
  return all;
}
template <class F>
void each_convex_shape(generator& random, F&& f) {
  f(sphere{random(0.2, 1)});
  f(box{{random(0.1, 2), random(0.1, 2), random(0.1, 2)}});
  f(capsule{random(0.1, 1), random(0.1, 2)});
  f(cylinder{random(0.1, 1), random(0.1, 2)});
  f(ellipsoid{{random(0.2, 1), random(0.2, 1), random(0.2, 1)}});
  f(lens{.radius = 1, .thickness = random(0.3, 1.5)});
  f(grain(random));
}

}  // namespace

TEST_CASE("a ray meets each convex shape where its signed distance falls to zero") {
  generator random;
  int met = 0;
  for (int k = 0; k < 2000; ++k)
    each_convex_shape(random, [&](const auto& s) {
      const pose at{random.point(5), random.turn()};
      CAPTURE(std::string(s.name));
      CAPTURE(k);
      test_rays(s, at, random, s.bounding_radius(), met);
      test_nearest(s, at, random, s.bounding_radius());
    });
  CHECK(met > 5000);
  for (int k = 0; k < 500; ++k) {
    const plane s{random.direction(), random(-2, 2)};
    test_rays(s, pose{}, random, 1, met);
    test_nearest(s, pose{}, random, 1);
  }
}

TEST_CASE("a ray that starts on a surface and leaves it meets nothing, and one that enters does") {
  generator random;
  const auto test = [&](const auto& s, int k) {
    CAPTURE(std::string(s.name));
    CAPTURE(k);
    const pose at{random.point(5), random.turn()};
    const pose turn{{0, 0, 0}, at.orientation};
    const real r = s.bounding_radius();
    const vec3 n = random.direction(), d = random.direction();
    // On the surface, in front of it and behind it, by round-off.
    const vec3 p = s.support(n) * (1 + (k % 3 - 1) * 1e-13);
    const real slope = n.dot(d);
    const surface_hit hit = detail::ray_meets(s, at, at.to_world(p), turn.to_world(d), endless);
    if (slope >= 0) {
      CHECK_FALSE(hit.found());
      return;
    }
    // Through the body, if it goes in and not past an edge.
    if (!(outside(s, p + 1e-3 * r * d) < -1e-5 * r)) return;
    REQUIRE(hit.found());
    CHECK_FALSE(hit.inside);
    CHECK(hit.distance < 1e-8 * r);
    CHECK(hit.normal.dot(turn.to_world(d)) < 0);
    // From deeper inside.
    const surface_hit deep =
        detail::ray_meets(s, at, at.to_world(p * (1 - 1e-6)), turn.to_world(d), endless);
    CHECK(deep.inside);
  };
  for (int k = 0; k < 1000; ++k) {
    each_convex_shape(random, [&](const auto& s) { test(s, k); });
    test(
        superellipsoid{
            {random(0.2, 1), random(0.2, 1), random(0.2, 1)}, random(2, 8), random(2, 8)},
        k);
    const plane floor{random.direction(), random(-2, 2)};
    const vec3 p = floor.normal * floor.offset + 3 * random.direction().cross(floor.normal);
    const vec3 d = random.direction();
    const surface_hit hit = detail::ray_meets(floor, pose{}, p, d, endless);
    CHECK(hit.found() == (d.dot(floor.normal) < 0));
    if (hit.found()) CHECK_FALSE(hit.inside);
  }
  // Of triangles: a start on the surface is in front of it.
  const triangle_mesh m(hills(12));
  for (int k = 0; k < 1000; ++k) {
    const auto t = static_cast<std::uint32_t>(random(0, double(m.triangles())));
    const vec3 p = (m.tree().corner(t, 0) + m.tree().corner(t, 1) + m.tree().corner(t, 2)) / 3;
    const vec3 d = random.direction();
    const surface_hit hit = detail::ray_meets(m, pose{}, p, d, endless);
    if (d.dot(m.tree().normals[t]) < 0)
      CHECK(hit.distance < 1e-9);
    else
      CHECK(hit.distance > 1e-9);
  }
  // Along a flat face, and a union whose second part the ray enters as it leaves the first.
  const box cube{{2, 2, 2}};
  for (const real off : {-1e-15, 0., 1e-15})
    CHECK_FALSE(detail::ray_meets(cube, pose{}, {0.3, 0.2, 1 + off}, {1, 0, 0}, endless).found());
  const union_of<box> two({{.shape = cube}, {.shape = cube, .at = {{0, 0, 2}}}});
  CHECK(detail::ray_meets(two, pose{}, {0.3, 0.2, 0}, {0, 0, 1}, endless).found());
  CHECK_FALSE(detail::ray_meets(two, pose{}, {0.3, 0.2, 2}, {0, 0, 1}, endless).found());
}

TEST_CASE("a ray meets a union where it meets its first part, and a surface as each triangle") {
  generator random;
  const union_of<sphere, box> u({{.shape = box{{1, 2, 0.3}}, .at = {{0.3, 0, 0}, random.turn()}},
                                 {.shape = sphere{0.6}, .at = {{-0.8, 0, 0.2}, {1, 0, 0, 0}}}});
  const triangle_mesh m(hills(12));
  int of_union = 0, of_mesh = 0;
  for (int k = 0; k < 4000; ++k) {
    const pose at{random.point(5), random.turn()};
    const shot one = random_shot(random, at, k % 2 == 0 ? 1.5 : 6, k % 10 == 0);
    if (k % 2 == 0) {
      real expected = endless;
      u.each_part([&](const auto& part, const pose& of) {
        expected = std::min(expected, detail::ray_meets(part, detail::combined(at, of), one.from,
                                                        one.direction, endless)
                                          .distance);
      });
      const surface_hit hit = detail::ray_meets(u, at, one.from, one.direction, endless);
      CHECK(hit.distance == expected);
      of_union += hit.found();
      continue;
    }
    const vec3 p = at.to_body(one.from), d = pose{{0, 0, 0}, at.orientation}.to_body(one.direction);
    real expected = endless, nearest = endless;
    for (std::uint32_t t = 0; t < m.triangles(); ++t) {  // Möller and Trumbore 1997
      const vec3 &a = m.tree().corner(t, 0), &b = m.tree().corner(t, 1), &c = m.tree().corner(t, 2);
      nearest = std::min(nearest, (detail::nearest_on_triangle(p, a, b, c).at - p).norm());
      const vec3 x = b - a, y = c - a, n = d.cross(y), s = p - a, q = s.cross(x);
      const real volume = x.dot(n), u1 = s.dot(n) / volume, v1 = d.dot(q) / volume,
                 way = y.dot(q) / volume;
      if (u1 >= 0 && v1 >= 0 && u1 + v1 <= 1 && way >= 0) expected = std::min(expected, way);
    }
    const surface_hit hit = detail::ray_meets(m, at, one.from, one.direction, endless);
    const real scale = 1 + p.norm();
    if (expected == endless || !hit.found())
      CHECK(expected == hit.distance);
    else
      CHECK(std::abs(hit.distance - expected) < 1e-10 * scale);
    of_mesh += hit.found();
    if (hit.found()) CHECK(hit.normal.dot(one.direction) < 0);
    const surface_hit near = detail::nearest_on_shape(m, at, one.from, endless);
    CHECK(std::abs(near.distance - nearest) < 1e-10 * scale);
    CHECK(std::abs((one.from - near.point).norm() - nearest) < 1e-10 * scale);
  }
  CHECK(of_union > 300);
  CHECK(of_mesh > 500);
}

TEST_CASE("no ray slips between two triangles of a surface") {
  const triangle_mesh m(hills(12));
  generator random;
  for (int k = 0; k < 5000; ++k) {
    // Through a point of an inner edge, or a corner.
    const auto t = static_cast<std::uint32_t>(random(0, double(m.triangles())));
    const std::size_t c = static_cast<std::size_t>(random(0, 3));
    const vec3 &a = m.tree().corner(t, c), &b = m.tree().corner(t, (c + 1) % 3);
    const vec3 target = a + (k % 5 == 0 ? 0 : random(0, 1)) * (b - a);
    if (std::max(std::abs(target[0]), std::abs(target[1])) > 5) continue;
    const vec3 d = unit(vec3(random(-0.3, 0.3), random(-0.3, 0.3), -1));
    CHECK(detail::ray_meets(m, pose{}, target - 3 * d, d, endless).found());
  }
}

TEST_CASE("a moving shape meets convex shapes and planes where a plane still separates the two") {
  generator random;
  int met = 0, all = 0;
  for (int k = 0; k < 40; ++k)
    each_convex_shape(random, [&](const auto& a) {
      each_convex_shape(random, [&](const auto& b) {
        const pose at{random.point(2), random.turn()};
        const pose from{at.position + random(0, 6) * random.direction(), random.turn()};
        const vec3 target = at.position + random.point(1.2);
        CAPTURE(std::string(a.name));
        CAPTURE(std::string(b.name));
        CAPTURE(k);
        ++all;
        test_cast(a, from, b, at, unit(vec3(target - from.position)), 20, random, met);
      });
      const plane floor{random.direction(), 0};
      const pose from{random(-1, 4) * floor.normal + random.point(1), random.turn()};
      test_cast(a, from, floor, pose{}, random.direction(), 20, random, met);
    });
  CHECK(met > all / 2);
}

TEST_CASE(
    "a moving shape meets the nearest of the triangles of a surface, and of the parts of unions") {
  generator random;
  const triangle_mesh m(hills(6));
  const union_of<sphere, box> u({{.shape = box{{1, 0.5, 0.3}}, .at = {{0.4, 0, 0}, random.turn()}},
                                 {.shape = sphere{0.4}, .at = {{-0.5, 0, 0.2}, {1, 0, 0, 0}}}});
  for (int k = 0; k < 400; ++k) {
    const pose at{random.point(1), random.turn()};
    const pose from{at.position + 6. * random.direction(), random.turn()};
    const vec3 d = unit(vec3(at.position + random.point(2) - from.position));
    // A small ball: the distance of its centre from the surface at the place is its radius.
    const sphere ball{0.3};
    const surface_hit hit = detail::shape_meets(ball, from, m, at, d, 30);
    const surface_hit to_union = detail::shape_meets(ball, from, u, at, d, 30);
    for (const auto& [found, what] : {std::pair(hit, 0), std::pair(to_union, 1)}) {
      const auto gap = [&, w = what](real t) {
        const vec3 p = from.position + t * d;
        return (w == 0 ? detail::nearest_on_shape(m, at, p, endless)
                       : detail::nearest_on_shape(u, at, p, endless))
                   .distance -
               ball.radius;
      };
      if (found.found()) CHECK(std::abs(gap(found.distance)) < 1e-7);
      for (int n = 0; n < 20; ++n)
        CHECK(gap(random(0, std::min(real(30), found.distance))) > -1e-7);
    }
    // A union that moves: the first of its parts.
    real expected = endless;
    u.each_part([&](const auto& part, const pose& of) {
      expected = std::min(
          expected, detail::shape_meets(part, detail::combined(from, of), m, at, d, 30).distance);
    });
    CHECK(detail::shape_meets(u, from, m, at, d, 30).distance == expected);
  }
}
