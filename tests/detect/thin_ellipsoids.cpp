// Contacts of needles and discs with axes of up to 1 to 10,000: normals where a sharp tip or rim
// touches, overlaps on both sides of the depth beyond which a normal may not be unique, and poses
// without a normal of their own.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "../generator.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/shape/ellipsoid.hpp"

using namespace talus;

namespace {

using contacts = std::vector<contact_geometry>;

template <class A, class B>
contacts find(const A& a, const pose& pa, const B& b, const pose& pb, real margin) {
  contacts found;
  collide_pair(a, pa, b, pb, margin, [&](const contact_geometry& c) { found.push_back(c); });
  return found;
}
template <class Shape>
vec3 support(const Shape& s, const pose& at, const vec3& d) {
  return at.to_world(s.support(at.orientation.conjugate() * d));
}
/// The gap along a unit direction from b to a: the distance is the largest of all.
template <class A, class B>
real gap_along(const A& a, const pose& pa, const B& b, const pose& pb, const vec3& n) {
  return n.dot(support(a, pa, -n) - support(b, pb, n));
}
/// The pose in which a touches b, at a gap along the normal n from b to a.
template <class A, class B>
pose over(const A& a, const quat& turn, const B& b, const pose& pb, const vec3& n, real gap) {
  pose at{vec3(0, 0, 0), turn};
  at.position = support(b, pb, n) + gap * n - support(a, at, -n);
  return at;
}
/// An ellipsoid of which only the support function is known.
struct egg {
  ellipsoid inside;

  static constexpr bool finite = true;
  static constexpr bool isotropic = false;
  static constexpr const char* name = "egg";
  void validate() const { inside.validate(); }
  [[nodiscard]] real bounding_radius() const { return inside.bounding_radius(); }
  [[nodiscard]] real volume() const { return inside.volume(); }
  [[nodiscard]] vec3 inertia() const { return inside.inertia(); }
  [[nodiscard]] vec3 support(const vec3& d) const { return inside.support(d); }
  [[nodiscard]] vec3 half_extents(const pose& at) const { return inside.half_extents(at); }
  friend bool operator==(const egg&, const egg&) = default;
};
/// Axes between 1e-4 and 1, of which one is 1 and often one 1e-4.
ellipsoid thin(generator& random) {
  const auto axis = [&] { return random(0, 1) < 0.3 ? 1e-4 : std::pow(10., random(-4, 0)); };
  ellipsoid e{{1, axis(), axis()}};
  const int k = static_cast<int>(random(0, 3));
  std::swap(e.radii[0], e.radii[k]);
  return e;
}
/// The rotation that turns the direction `from` to `to`, and about it by any angle.
quat turning(const vec3& from, const vec3& to, generator& random) {
  const quat about = rotation(to, random(0, 2 * pi));
  const vec3 axis = from.cross(to);
  const real sine = axis.norm();
  if (!(sine > 1e-12))
    return about * (from.dot(to) > 0 ? quat(1, 0, 0, 0) : rotation({0, 0, 1}, pi));
  return about * rotation(axis / sine, std::atan2(sine, from.dot(to)));
}

}  // namespace

TEST_CASE("the normal of two sharp tips that touch is exact") {
  real worst = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const ellipsoid needle{{1, 1e-4, 1e-4}};
    const vec3 n = random.direction();
    const auto leaning = [&](real side) {  // a tip looks along n, or against it
      return turning({1, 0, 0}, (side * n + random(0, 0.4) * random.direction()).normalized(),
                     random);
    };
    const pose pb{random.point(1), leaning(1)};
    const real gap = seed % 2 ? 0 : 1e-9;
    const pose pa = over(needle, leaning(-1), needle, pb, n, gap);
    const contacts found = find(needle, pa, needle, pb, 1e-3);
    REQUIRE(found.size() == 1);
    worst = std::max(worst, (found[0].normal - n).norm());
    CHECK((found[0].normal - n).norm() < 1e-6);
    CHECK(std::abs(found[0].gap - gap) < 1e-14);
  }
  MESSAGE("largest error of a normal ", worst);
}

TEST_CASE("needles and discs of all kinds have the normal and the gap with which they are put") {
  real worst = 0;
  int rough = 0;
  for (std::uint64_t seed = 1; seed <= 10000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const ellipsoid a = thin(random), b = thin(random);
    const vec3 n = random.direction();
    const pose pb{random.point(1), random.turn()};
    const real unique = a.smallest_curvature_radius() + b.smallest_curvature_radius();
    const real gaps[] = {1e-2, 1e-6, 0, -0.3 * unique};
    const real gap = gaps[seed % 4];
    const pose pa = over(a, random.turn(), b, pb, n, gap);
    const contacts found = find(a, pa, b, pb, 0.1);
    CAPTURE(seed);
    CAPTURE(gap);
    REQUIRE(found.size() == 1);
    const contact_geometry& c = found[0];
    // (The squares of axes of 1e-4 and 1 are in one matrix: points are found to 1e-16 / 1e-4.)
    const real turn = 1e-14 / (0.5 * unique + std::max(real(0), gap)) + 1e-10;
    // Where the search for the normal is lost, the polytope gives the depth.
    if (!((c.normal - n).norm() < turn && std::abs(c.gap - gap) < 1e-11)) {
      ++rough;
      CHECK(std::abs(c.gap - gap) < 1e-3 * 1e-4);
      continue;
    }
    worst = std::max(worst, (c.normal - n).norm());
  }
  MESSAGE("largest error of a normal ", worst, "; of ", rough, " pairs rougher");
  CHECK(rough <= 10);
}

TEST_CASE("thin shapes known by their support functions alone are apart by no more than they are") {
  real worst = 0, turned = 0;
  int rough = 0;
  for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const egg a{thin(random)}, b{thin(random)};
    const vec3 n = random.direction();
    const pose pb{random.point(1), random.turn()};
    const real gap = seed % 2 ? 1e-2 : 1e-5;
    const pose pa = over(a, random.turn(), b, pb, n, gap);
    const contacts found = find(a, pa, b, pb, 0.1);
    CAPTURE(seed);
    REQUIRE(found.size() == 1);
    const contact_geometry& c = found[0];
    CHECK(std::abs(c.normal.norm() - 1) < 1e-12);
    // The true gap is the largest of all directions.
    CHECK(c.gap < gap + 1e-13);
    CHECK(c.gap > -1e-6);
    CHECK(gap_along(a, pa, b, pb, c.normal) > c.gap - 1e-12);
    worst = std::max(worst, gap - c.gap), turned = std::max(turned, (c.normal - n).norm());
    rough += gap - c.gap > 1e-10;
  }
  MESSAGE("gap too small by ", worst, " at most, ", rough, " by more than 1e-10; normals ", turned);
  CHECK(rough < 40);
}

TEST_CASE("overlaps of discs are the least ones, below and beyond the smallest curvature") {
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    generator random{std::mt19937_64(seed)};
    const real thickness = seed % 4 < 2 ? 0.05 : 0.01;
    const ellipsoid disc{{1, seed % 3 ? 1 : random(0.05, 1), thickness}};
    const real unique = 2 * disc.smallest_curvature_radius();
    const pose pb{random.point(1), random.turn()};
    // Rims, sides, and all between them.
    const vec3 local =
        (random.direction().cwiseProduct(vec3(1, 1, seed % 2 ? 1 : 0.02))).normalized();
    const vec3 n = pb.orientation * local;
    const real depth = std::pow(10., random(-1, 1)) * 0.5 * unique;
    const pose pa = over(disc, random.turn(), disc, pb, n, -depth);
    CAPTURE(seed);
    CAPTURE(depth / unique);
    const contacts found = find(disc, pa, disc, pb, 0.1);
    REQUIRE(found.size() == 1);
    const contact_geometry& c = found[0];
    CHECK(std::abs(c.normal.norm() - 1) < 1e-12);
    CHECK(std::abs(gap_along(disc, pa, disc, pb, c.normal) - c.gap) < 1e-13);
    // What the pair is put with is a bound, and so is every other direction.
    const real allowed = depth < 0.45 * unique ? 1e-13 : 1e-3 * thickness;
    CHECK(c.gap >= -depth - allowed);
    for (int k = 0; k < 400; ++k) {
      const vec3 m = random.direction();
      CHECK(c.gap >= gap_along(disc, pa, disc, pb, m) - allowed);
    }
  }
}

TEST_CASE("ellipsoids about one centre, and discs that lie flat on each other") {
  generator random{std::mt19937_64(5)};
  for (const ellipsoid& e : {ellipsoid{{1, 0.5, 0.3}}, ellipsoid{{1, 1, 1}},
                             ellipsoid{{1, 1, 1e-2}}, ellipsoid{{1, 1e-2, 1e-2}}}) {
    CAPTURE(e.radii[2]);
    const real least = e.radii.minCoeff();
    const quat turn = random.turn();
    const vec3 place = random.point(2);
    const contacts found = find(e, pose{place, turn}, e, pose{place, turn}, 0.1);
    REQUIRE(found.size() == 1);
    CHECK(std::abs(found[0].gap + 2 * least) < 1e-3 * least);
    CHECK(std::abs(found[0].normal.norm() - 1) < 1e-12);
    CHECK((found[0].point - place).norm() < 1.01 * e.bounding_radius());
    const contacts of_ball = find(e, pose{place, turn}, sphere{0.2}, pose{place}, 0.1);
    REQUIRE(of_ball.size() == 1);
    CHECK(std::abs(of_ball[0].gap + 0.2 + least) < 1e-3 * std::min(0.2, least));
    CHECK(std::abs(of_ball[0].normal.norm() - 1) < 1e-12);
  }
  for (const real c : {0.1, 1e-2, 1e-4})
    for (const real gap : {0.5, 0.01, 0., -0.05})
      for (const real shift : {0., 1e-9, 0.3}) {
        CAPTURE(c);
        CAPTURE(gap);
        CAPTURE(shift);
        const ellipsoid disc{{1, 1, c}};
        const quat turn = random.turn();
        const vec3 up = turn * vec3(0, 0, 1), along = turn * vec3(1, 0, 0);
        // By the shift, both normals lean: level z = c sqrt(1 - x^2) at half of the shift.
        const real x = shift / 2, height = 2 * c * std::sqrt(1 - x * x) + gap * c;
        const contacts found =
            find(disc, pose{height * up + shift * along, turn}, disc, pose{vec3(0, 0, 0), turn}, 1);
        REQUIRE(found.size() == 1);
        const contact_geometry& one = found[0];
        CHECK(std::abs(one.normal.norm() - 1) < 1e-12);
        CHECK(one.normal.dot(up) > 0.99);
        // By symmetry the middle of the two centres is a point of contact.
        CHECK((one.point - 0.5 * (height * up + shift * along)).norm() < (gap < 0 ? 1e-3 : 1e-10));
        if (gap == 0) CHECK(std::abs(one.gap) < 1e-12);
        if (shift == 0) CHECK(std::abs(one.gap - gap * c) < (gap < 0 ? 1e-3 * c : 1e-14));
      }
}
