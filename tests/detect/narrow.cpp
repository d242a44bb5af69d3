// Contacts of spheres, planes and boxes (except box with box) against closed forms and symmetries.
#include "talus/detect/narrow.hpp"
#include "../generator.hpp"

#include <doctest/doctest.h>

#include <random>
#include <vector>

namespace {

using namespace talus;
using contacts = std::vector<contact_geometry>;

static_assert(collidable<sphere, sphere> && collidable<box, box>);
static_assert(collidable<sphere, plane> && collidable<plane, sphere>);
static_assert(collidable<sphere, box> && collidable<box, sphere>);
static_assert(collidable<box, plane> && collidable<plane, box>);
static_assert(!collidable<plane, plane>);

template <class A, class B>
contacts find(const A& a, const pose& pa, const B& b, const pose& pb, real margin) {
  contacts found;
  collide_pair(a, pa, b, pb, margin, [&](const contact_geometry& c) { found.push_back(c); });
  return found;
}

pose moved(const pose& by, const pose& p) {
  return {by.to_world(p.position), by.orientation * p.orientation};
}
plane moved(const pose& by, const plane& p) {
  const vec3 n = by.orientation * p.unit_normal();
  return {n, p.offset + n.dot(by.position)};
}
template <class Shape>
Shape moved(const pose&, const Shape& s) {
  return s;
}

void check_near(const vec3& a, const vec3& b, real tolerance) {
  INFO("vector " << a[0] << " " << a[1] << " " << a[2]);
  INFO("wanted " << b[0] << " " << b[1] << " " << b[2]);
  CHECK((a - b).norm() <= tolerance);
}

// Laws of every pair: bitwise repeatable, unit normals, gaps within the margin, distinct features,
// equal after exchanging the bodies and after moving both; and the gap grows by h as a moves by h
// along the normal, the others following.
template <class A, class B>
contacts check_laws(const A& a, const pose& pa, const B& b, const pose& pb, real margin,
                    const pose& by) {
  const contacts found = find(a, pa, b, pb, margin);
  const contacts again = find(a, pa, b, pb, margin);
  const contacts swapped = find(b, pb, a, pa, margin);
  const contacts elsewhere = find(moved(by, a), moved(by, pa), moved(by, b), moved(by, pb), margin);
  REQUIRE(again.size() == found.size());
  REQUIRE(swapped.size() == found.size());
  REQUIRE(elsewhere.size() == found.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const contact_geometry& c = found[k];
    CHECK(c.normal.norm() == doctest::Approx(1).epsilon(1e-14));
    CHECK(c.gap <= margin);
    for (std::size_t m = 0; m < k; ++m) CHECK(found[m].feature != c.feature);

    CHECK(again[k].normal == c.normal);
    CHECK(again[k].point == c.point);
    CHECK(again[k].gap == c.gap);

    CHECK(swapped[k].feature == c.feature);
    CHECK(std::abs(swapped[k].gap - c.gap) <= 1e-14);
    check_near(swapped[k].normal, -c.normal, 1e-13);
    check_near(swapped[k].point, c.point, 1e-13);

    CHECK(elsewhere[k].feature == c.feature);
    CHECK(std::abs(elsewhere[k].gap - c.gap) <= 1e-12);
    check_near(elsewhere[k].normal, by.orientation * c.normal, 1e-11);
    check_near(elsewhere[k].point, by.to_world(c.point), 1e-11);

    const real h = 1e-6;
    pose shifted = pb;  // b is the finite one in all pairs below
    shifted.position -= h * c.normal;
    for (const contact_geometry& d : find(a, pa, b, shifted, margin + 1))
      if (d.feature == c.feature) CHECK(d.gap - c.gap == doctest::Approx(h).epsilon(1e-5));
  }
  return found;
}

}  // namespace

TEST_CASE("two spheres touch on the line of centres") {
  const contacts c = find(sphere{2}, pose{{0, 0, 6.5}}, sphere{4}, pose{}, 0.6);
  REQUIRE(c.size() == 1);
  CHECK(c[0].normal == vec3(0, 0, 1));
  CHECK(c[0].gap == 0.5);
  CHECK(c[0].point == vec3(0, 0, 4.25));
  CHECK(c[0].feature == 0);
  CHECK(find(sphere{2}, pose{{0, 0, 6.5}}, sphere{4}, pose{}, 0.4).empty());
  CHECK(find(sphere{2}, pose{{0, 0, 6.5}}, sphere{4}, pose{}, 0.5).size() == 1);

  const contacts same = find(sphere{2}, pose{{1, 2, 3}}, sphere{1}, pose{{1, 2, 3}}, 0);
  REQUIRE(same.size() == 1);
  CHECK(same[0].normal.norm() == 1);
  CHECK(same[0].gap == -3);
  const contacts tiny = find(sphere{2}, pose{{1e-170, 0, 0}}, sphere{1}, pose{}, 0);
  REQUIRE(tiny.size() == 1);
  CHECK(tiny[0].normal.norm() == 1);
}

TEST_CASE("spheres never read an orientation") {
  const real nan = std::numeric_limits<real>::quiet_NaN();
  const quat none{nan, nan, nan, nan};
  CHECK(find(sphere{}, pose{{0, 0, 1.9}, none}, sphere{}, pose{{0, 0, 0}, none}, 0).at(0).gap < 0);
  CHECK(find(sphere{}, pose{{0, 0, 0.9}, none}, plane{}, pose{{0, 0, 0}, none}, 0).at(0).gap < 0);
  CHECK(find(sphere{}, pose{{0, 0, 1.4}, none}, box{}, pose{}, 0).at(0).gap < 0);
  CHECK(sphere{}.half_extents(pose{{0, 0, 0}, none}) == vec3(1, 1, 1));
}

TEST_CASE("random spheres, planes and boxes keep the laws and the closed forms") {
  const std::uint64_t seed = 20240613;
  INFO("seed " << seed);
  generator random{std::mt19937_64(seed)};
  int met[4] = {};
  for (int k = 0; k < 3000; ++k) {
    INFO("round " << k);
    const pose by{random.point(3), random.turn()};
    const real margin = random(0, 0.3);
    const sphere s{random(0.2, 1)}, t{random(0.2, 1)};
    const pose ps{random.point(1.2), random.turn()}, pt{random.point(1.2), random.turn()};
    const real apart = (ps.position - pt.position).norm() - s.radius - t.radius;
    const contacts ss = check_laws(s, ps, t, pt, margin, by);
    CHECK(ss.size() == (apart <= margin));
    if (!ss.empty()) {
      ++met[0];
      CHECK(std::abs(ss[0].gap - apart) < 1e-14);
    }

    const plane floor{random.point(1), random(-1, 1)};
    const contacts fs = check_laws(floor, pose{}, s, ps, margin, by);
    const real above = floor.distance(ps.position) - s.radius;
    CHECK(fs.size() == (above <= margin));
    if (!fs.empty()) {
      ++met[1];
      check_near(fs[0].normal, -floor.unit_normal(), 1e-15);
      CHECK(floor.distance(fs[0].point) == doctest::Approx(above / 2));
    }

    const box b{random.point(0.8).cwiseAbs() + vec3(0.2, 0.2, 0.2)};
    const pose pb{random.point(1), random.turn()};
    const contacts bs = check_laws(b, pb, s, ps, margin, by);
    // Closed form: distance of the centre from the box, or depth in it.
    const vec3 q = pb.to_body(ps.position).cwiseAbs() - b.half();
    const real distance =
        q.cwiseMax(vec3::Zero()).norm() + std::min(q.maxCoeff(), real(0)) - s.radius;
    CHECK(bs.size() == (distance <= margin));
    if (!bs.empty()) {
      ++met[2];
      CHECK(std::abs(bs[0].gap - distance) < 1e-14);
      const vec3 on_box = pb.to_body(bs[0].point + 0.5 * bs[0].gap * bs[0].normal);
      CHECK((on_box.cwiseAbs() - b.half()).maxCoeff() == doctest::Approx(0).epsilon(1e-12));
    }

    const contacts fb = check_laws(floor, pose{}, b, pb, margin, by);
    real lowest = 1e9;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const vec3 local{corner & 1 ? b.half()[0] : -b.half()[0],
                       corner & 2 ? b.half()[1] : -b.half()[1],
                       corner & 4 ? b.half()[2] : -b.half()[2]};
      const real gap = floor.distance(pb.to_world(local));
      lowest = std::min(lowest, gap);
      for (const contact_geometry& c : fb)
        if (c.feature == corner) {
          CHECK(std::abs(c.gap - gap) < 1e-13);
          check_near(c.point, pb.to_world(local) - floor.unit_normal() * gap / 2, 1e-13);
        }
    }
    CHECK(fb.size() <= 4);
    CHECK(fb.empty() == (lowest > margin));
    if (!fb.empty()) {
      ++met[3];
      const auto deepest = std::min_element(
          fb.begin(), fb.end(), [](const auto& x, const auto& y) { return x.gap < y.gap; });
      CHECK(std::abs(deepest->gap - lowest) < 1e-13);
    }
  }
  for (const int n : met) CHECK(n > 300);
}

TEST_CASE("a box lying on a plane stands on its four corners") {
  const contacts c = find(plane{}, pose{}, box{{2, 4, 6}}, pose{{7, 8, 2.99}}, 0.1);
  REQUIRE(c.size() == 4);
  for (unsigned k = 0; k < 4; ++k) {
    CHECK(c[k].feature == k);
    CHECK(c[k].normal == vec3(0, 0, -1));
    CHECK(c[k].gap == doctest::Approx(-0.01));
    check_near(c[k].point, {7 + (k & 1 ? 1. : -1.), 8 + (k & 2 ? 2. : -2.), -0.005}, 1e-14);
  }
  // A plate thinner than the margin still has four.
  CHECK(find(plane{}, pose{}, box{{2, 2, 0.01}}, pose{{0, 0, 0.005}}, 0.1).size() == 4);
}

TEST_CASE("a sphere whose centre is in a box leaves by the nearest face") {
  const pose at{{1, 2, 3}, rotation({1, 1, 0}, 0.7)};
  const box b{{2, 4, 6}};
  for (int axis = 0; axis < 3; ++axis)
    for (const real side : {-1., 1.}) {
      vec3 local{0.01, -0.02, 0.03};
      local[axis] = side * (b.half()[axis] - 0.25);
      const contacts c = find(sphere{0.5}, pose{at.to_world(local)}, b, at, 0);
      REQUIRE(c.size() == 1);
      CHECK(c[0].gap == doctest::Approx(-0.75));
      check_near(c[0].normal, at.orientation * vec3(side * vec3::Unit(axis)), 1e-14);
    }
  // Exactly at the centre, on a face and on a corner there is still one correct normal.
  for (const vec3& local : {vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 2, 3), vec3(-1, -2, 0)}) {
    const contacts c = find(sphere{0.5}, pose{local}, b, pose{}, 0);
    REQUIRE(c.size() == 1);
    CHECK(c[0].normal.norm() == doctest::Approx(1));
    CHECK(c[0].gap == doctest::Approx(-0.5 - (local.norm() == 0)));
  }
}

TEST_CASE("the gap of a sphere and a box is continuous through the surface") {
  const box b{{2, 4, 6}};
  for (const vec3& start : {vec3(0.9, 0.3, 0.2), vec3(0.2, 1.9, -1), vec3(-0.2, 0.9, 2.95)}) {
    real last = 0;
    for (int k = 0; k <= 400; ++k) {
      const vec3 p = start * (0.9 + 0.001 * k);
      const contacts c = find(b, pose{}, sphere{1}, pose{p}, 5);
      REQUIRE(c.size() == 1);
      if (k > 0) CHECK(std::abs(c[0].gap - last) <= 0.0011 * start.norm());
      last = c[0].gap;
    }
  }
}
