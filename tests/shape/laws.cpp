// The laws of every finite shape: support, bounds, volume and inertia are of one and the same body.
// A new shape is added by one line at the end.
#include <doctest/doctest.h>

#include <random>

#include "../generator.hpp"
#include "../vectors.hpp"
#include "talus/body/body.hpp"
#include "talus/concepts.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/capsule.hpp"
#include "talus/shape/convex_polyhedron.hpp"
#include "talus/shape/cylinder.hpp"
#include "talus/shape/ellipsoid.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"
#include "talus/shape/superellipsoid.hpp"

namespace {

using namespace talus;

static_assert(concepts::finite_shape<sphere> && concepts::finite_shape<box>);
static_assert(concepts::finite_shape<capsule> && concepts::finite_shape<cylinder>);
static_assert(concepts::finite_shape<convex_polyhedron>);
static_assert(concepts::shape<plane> && !concepts::finite_shape<plane>);
static_assert(!concepts::shape<int> && !concepts::shape<vec3>);
static_assert(sphere::isotropic && !box::isotropic);

pose place(generator& random) { return {random.point(9), random.turn()}; }

// Directions from which the shape is cut out again: a point is inside if no support plane has it in
// front. As fine as the directions, which the tolerance allows for.
template <class Shape, class Inside>
void check_laws(const Shape& s, Inside inside, std::uint64_t seed) {
  INFO(std::string(Shape::name) << ", seed " << seed);
  generator random{std::mt19937_64(seed)};
  CHECK_NOTHROW(s.validate());
  CHECK(s == Shape(s));

  real furthest = 0;
  for (int k = 0; k < 500; ++k) {
    const vec3 d = random.direction();
    const vec3 p = s.support(d);
    INFO("direction " << d[0] << " " << d[1] << " " << d[2]);
    CHECK(inside(p * (1 - 1e-12)));
    CHECK_FALSE(inside(p * (1 + 1e-9)));
    CHECK(p.norm() <= s.bounding_radius() * (1 + 1e-12));
    CHECK((s.support(1000 * d) - p).norm() <= 1e-12 * s.bounding_radius());
    CHECK((s.support(1e-200 * d) - p).norm() <= 1e-12 * s.bounding_radius());
    for (int m = 0; m < 20; ++m) CHECK(d.dot(s.support(random.direction())) <= d.dot(p) + 1e-12);
    furthest = std::max(furthest, p.norm());
  }
  CHECK(furthest > s.bounding_radius() * 0.999);

  for (int k = 0; k < 50; ++k) {
    const pose at = place(random);
    const vec3 half = s.half_extents(at);
    for (int axis = 0; axis < 3; ++axis) {
      real reach = 0;
      for (const real sign : {-1., 1.}) {
        const vec3 d = at.orientation.conjugate() * vec3(sign * vec3::Unit(axis));
        reach = std::max(reach, (at.orientation * vec3(s.support(d)))[axis] * sign);
      }
      CHECK(reach == doctest::Approx(half[axis]));
    }
    if constexpr (requires { s.reach_from(at.position); }) {
      real furthest = 0;
      for (int m = 0; m < 2000; ++m)
        furthest = std::max(furthest, (s.support(random.direction()) - at.position).norm());
      CHECK(furthest <= s.reach_from(at.position) * (1 + 1e-12));
      CHECK(furthest >= s.reach_from(at.position) - 0.02 * s.bounding_radius());
    }
  }

  // Volume and moments by jittered sampling of the bounding box.
  const vec3 half = s.half_extents(pose{});
  const int n = 60;
  real count = 0;
  vec3 centre = vec3::Zero(), square = vec3::Zero(), mixed = vec3::Zero();
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const vec3 p =
            (vec3(x + random(0, 1), y + random(0, 1), z + random(0, 1)) * (2. / n) - vec3(1, 1, 1))
                .cwiseProduct(half);
        if (!inside(p)) continue;
        count += 1;
        centre += p;
        square += p.cwiseProduct(p);
        mixed += vec3(p[1] * p[2], p[2] * p[0], p[0] * p[1]);
      }
  const real volume = 8 * product_of(half) * count / (real(n) * n * n);
  CHECK(volume == doctest::Approx(s.volume()).epsilon(2e-3));
  const vec3 m = square / count;
  const vec3 inertia = s.inertia();
  for (int i = 0; i < 3; ++i) {
    CHECK(inertia[i] == doctest::Approx(m[(i + 1) % 3] + m[(i + 2) % 3]).epsilon(3e-3));
    CHECK(std::abs(centre[i] / count) < 1.5e-3 * s.bounding_radius());
    CHECK(std::abs(mixed[i] / count) < 1e-3 * s.bounding_radius() * s.bounding_radius());
    if (Shape::isotropic) CHECK(inertia[i] == inertia[0]);
  }
}

template <class Shape>
void check_refused(const Shape& s, const char* what) {
  try {
    s.validate();
    FAIL("accepted");
  } catch (const std::invalid_argument& error) {
    INFO(std::string(error.what()));
    CHECK(std::string(error.what()).find(what) != std::string::npos);
  }
}

const real nan_ = std::numeric_limits<real>::quiet_NaN(), inf_ = 1 / real(0);

}  // namespace

TEST_CASE("support, bounds, volume and inertia of a shape agree") {
  for (const real r : {0.3, 1., 70.})
    check_laws(
        sphere{.radius = r}, [r](const vec3& p) { return p.norm() <= r; }, 1);
  for (const vec3& size : {vec3(1, 1, 1), vec3(4.7, 2.3, 1.9), vec3(0.1, 3, 20)}) {
    const auto inside = [&](const vec3& p) { return at_most((2 * p).cwiseAbs(), size); };
    check_laws(box{.size = size}, inside, 2);
  }
  for (const vec3& r : {vec3(1, 1, 1), vec3(1, 2, 0.5), vec3(0.1, 0.3, 4)})
    check_laws(
        ellipsoid{r}, [r](const vec3& p) { return p.cwiseQuotient(r).norm() <= 1; }, 7);
  for (const auto& [n1, n2] : {std::pair(2., 2.), std::pair(2., 8.), std::pair(8., 2.),
                               std::pair(3.7, 2.6), std::pair(8., 8.)})
    for (const vec3& r : {vec3(1, 1, 1), vec3(1, 2, 0.5), vec3(0.1, 0.3, 4)}) {
      const superellipsoid s{r, n1, n2};
      const auto in_superellipsoid = [&](const vec3& p) {
        const vec3 u = p.cwiseQuotient(s.radii).cwiseAbs();
        return std::pow(std::pow(u[0], s.n2) + std::pow(u[1], s.n2), s.n1 / s.n2) +
                   std::pow(u[2], s.n1) <=
               1;
      };
      check_laws(s, in_superellipsoid, 8);
    }
  for (const auto& [r, l] : {std::pair(1., 1.), std::pair(0.3, 4.), std::pair(5., 0.1)}) {
    const auto in_capsule = [r = r, l = l](const vec3& p) {
      return std::hypot(p[0], p[1], std::max(0., std::abs(p[2]) - l / 2)) <= r;
    };
    check_laws(capsule{.radius = r, .length = l}, in_capsule, 3);
    const auto in_cylinder = [r = r, l = l](const vec3& p) {
      return std::hypot(p[0], p[1]) <= r && std::abs(p[2]) <= l / 2;
    };
    check_laws(cylinder{.radius = r, .length = l}, in_cylinder, 4);
  }
}

TEST_CASE("a superellipsoid with the exponents 2 is an ellipsoid") {
  generator random{std::mt19937_64(9)};
  for (int k = 0; k < 200; ++k) {
    const vec3 r(random(0.1, 3), random(0.1, 3), random(0.1, 3));
    const ellipsoid e{r};
    const superellipsoid s{r}, nearly{r, 2 + 1e-12, 2 + 1e-12};
    CHECK(s.volume() == doctest::Approx(e.volume()).epsilon(1e-14));
    CHECK(s.bounding_radius() == e.bounding_radius());
    CHECK(nearly.bounding_radius() == doctest::Approx(e.bounding_radius()).epsilon(1e-11));
    const pose at = place(random);
    const vec3 d = random.direction();
    for (int i = 0; i < 3; ++i) {
      CHECK(s.inertia()[i] == doctest::Approx(e.inertia()[i]).epsilon(1e-14));
      CHECK(s.half_extents(at)[i] == doctest::Approx(e.half_extents(at)[i]).epsilon(1e-14));
    }
    CHECK((s.support(d) - e.support(d)).norm() < 1e-14 * r.norm());
    CHECK((nearly.support(d) - e.support(d)).norm() < 1e-11 * r.norm());
    for (const vec3& way : {d, vec3(0, 0, 1), vec3(0, -1, 0), vec3(1, 0, 0)}) {
      const mat3 a = s.bend(way), b = e.bend(way);
      const real most = 10 * e.bounding_radius();
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          if (b(0, 0) + b(1, 1) + b(2, 2) < most)
            CHECK(std::abs(a(i, j) - b(i, j)) <
                  1e-12 * e.bounding_radius() * r.maxCoeff() / r.minCoeff());
    }
    const vec3 p = random.point(2);
    const chord of_s = s.chord(p, d), of_e = e.chord(p, d);
    CHECK(of_s.empty() == of_e.empty());
    if (!of_e.empty()) {
      CHECK(std::abs(of_s.from - of_e.from) < 1e-11);
      CHECK(std::abs(of_s.to - of_e.to) < 1e-11);
    }
  }
}

TEST_CASE("a superellipsoid has its support where directions have no or tiny components") {
  const superellipsoid s{{1, 2, 3}, 8, 5};
  for (int k = 0; k < 3; ++k)
    for (const real sign : {1., -1.}) {
      const vec3 axis = vec3::Unit(k);
      for (const real length : {1., 1e-300, 1e300, 5e-324}) {
        const vec3 p = s.support(sign * length * axis);
        CHECK(p == sign * s.radii[k] * axis);
      }
      for (const real tiny : {1e-320, 1e-200, 1e-30, 1e-12}) {
        const vec3 d = axis + tiny * vec3::Unit((k + 1) % 3), p = s.support(d);
        CHECK(p.allFinite());
        CHECK(p[k] == doctest::Approx(s.radii[k]));
        CHECK(p[(k + 1) % 3] >= 0);
        CHECK(p[(k + 2) % 3] == 0);
        CHECK((s.bend(d) * vec3(1, 1, 1)).allFinite());
      }
    }
  CHECK(s.support({0, 0, 0}) == vec3(0, 0, 0));
}

TEST_CASE("a superellipsoid bends as its support function moves") {
  generator random{std::mt19937_64(10)};
  for (int k = 0; k < 300; ++k) {
    const superellipsoid s{
        {random(0.3, 1), random(0.3, 1), random(0.3, 1)}, random(2, 8), random(2, 8)};
    vec3 d = random.direction();
    if (d.cwiseAbs().minCoeff() < 0.1) continue;  // where it is not flat
    const mat3 m = s.bend(d);
    const vec3 t = d.cross(random.direction()).normalized();
    constexpr real step = 1e-5;
    const vec3 moved = (s.support(d + step * t) - s.support(d - step * t)) / (2 * step);
    CHECK((m * t - moved).norm() < 1e-5 * (1 + moved.norm()));
    CHECK((m * d).norm() < 1e-12 * (1 + moved.norm()));
  }
}

TEST_CASE("the chord of a line in a superellipsoid ends on its surface") {
  generator random{std::mt19937_64(11)};
  int hits = 0, misses = 0;
  for (int k = 0; k < 3000; ++k) {
    const superellipsoid s{{random(0.3, 1), random(0.3, 1), random(0.3, 1)},
                           k % 5 == 0 ? 8 : random(2, 8),
                           k % 7 == 0 ? 8 : random(2, 8)};
    const vec3 p = random.point(1), d = random(0.5, 2) * random.direction();
    const chord c = s.chord(p, k % 11 == 0 ? vec3(0, 0, -2) : d);
    const vec3 way = k % 11 == 0 ? vec3(0, 0, -2) : d;
    real least = 1e9;
    for (int m = -300; m <= 300; ++m) least = std::min(least, s.level(p + (0.02 * m) * way).value);
    if (c.empty()) {
      CHECK(least > 1 - 1e-4);
      ++misses;
      continue;
    }
    ++hits;
    CHECK(std::abs(s.level(p + c.from * way).value - 1) < 1e-12);
    CHECK(std::abs(s.level(p + c.to * way).value - 1) < 1e-12);
    CHECK(s.level(p + 0.5 * (c.from + c.to) * way).value < 1);
  }
  CHECK(hits > 500);
  CHECK(misses > 500);
}

TEST_CASE("support, bounds, volume and inertia of polyhedra agree") {
  std::vector<std::vector<vec3>> forms{
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},                                   // a corner
      {{5, 5, 5}, {7, 5, 5}, {5, 8, 5}, {7, 8, 5}, {5, 5, 6}, {7, 5, 6}},             // a wedge
      {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {0.5, 0.3, 2}, {0, 0, 0.5}}};  // a pyramid
  generator random{std::mt19937_64(5)};
  for (int k = 0; k < 4; ++k) {
    forms.emplace_back();
    for (int n = 0; n < 6 + 5 * k; ++n)
      forms.back().push_back(random.direction().cwiseProduct(vec3(2, 1, 3)) + vec3(1, 2, 3));
  }
  for (const auto& points : forms) {
    const convex_polyhedron p(points);
    const auto inside = [&](const vec3& x) {
      for (std::size_t f = 0; f < p.mesh().faces(); ++f)
        if (p.mesh().normals[f].dot(x) > p.mesh().offsets[f] * (1 + 1e-14)) return false;
      return true;
    };
    check_laws(p, inside, 6);
    // It contains all given points, and those on its hull are its vertices.
    const pose frame = p.frame();
    for (const vec3& x : points) CHECK(inside(frame.to_body(x) * (1 - 1e-12)));
    for (const vec3& v : p.vertices()) {
      real nearest = 1e9;
      for (const vec3& x : points) nearest = std::min(nearest, (frame.to_world(v) - x).norm());
      CHECK(nearest < 1e-12);
    }
  }
}

TEST_CASE("polyhedra of known form have the volume, the centre and the inertia of the textbook") {
  const convex_polyhedron corner({{0, 0, 0}, {6, 0, 0}, {0, 6, 0}, {0, 0, 6}});
  CHECK(corner.volume() == doctest::Approx(36));
  CHECK((corner.frame().position - vec3(1.5, 1.5, 1.5)).norm() < 1e-12);
  // Covariance of the corner of edge a about its centre: 3/80 a^2 beside -1/80 a^2, so the axis
  // (1, 1, 1) has 1/80 a^2 and those across 4/80 a^2.
  vec3 inertia = corner.inertia();
  std::sort(inertia.data(), inertia.data() + 3);
  CHECK((inertia - vec3(5, 5, 8) * 36 / 80).norm() < 1e-12);

  // A box, with points on its faces, its edges and inside, and every corner twice.
  const box b{{2, 3, 4}};
  std::vector<vec3> points;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 5; ++z)
        for (int twice = 0; twice < 2; ++twice) points.push_back(vec3(x, y, z) + vec3(7, -8, 9));
  const convex_polyhedron mesh(points);
  CHECK(mesh.vertices().size() == 8);
  CHECK(mesh.mesh().faces() == 6);
  CHECK(mesh.mesh().edges.size() == 12);
  CHECK(mesh.volume() == doctest::Approx(b.volume()));
  CHECK((mesh.inertia() - b.inertia()).norm() < 1e-12);
  CHECK(mesh.bounding_radius() == doctest::Approx(b.bounding_radius()));
  CHECK((mesh.frame().position - vec3(8, -6.5, 11)).norm() < 1e-12);
  CHECK(mesh.frame().orientation.w() == 1);  // its axes are those it was given in
  CHECK(mesh.mesh().measured.half_width == doctest::Approx(1));
}

TEST_CASE("points that lie very close on a curved surface have a hull, with each as a corner") {
  for (const real width : {0.3, 0.1, 0.03, 0.01}) {
    CAPTURE(width);
    generator random{std::mt19937_64(500)};
    std::vector<vec3> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, -1}};
    for (int k = 0; k < 500; ++k)
      points.push_back(vec3(random(-width, width), random(-width, width), 1).normalized());
    const convex_polyhedron p(points);
    CHECK(p.vertices().size() == points.size());
    CHECK(p.mesh().vertices.size() + p.mesh().faces() == p.mesh().edges.size() + 2);
  }
}

TEST_CASE("hulls of many points close, whatever the points") {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    const quat turn = rotation(random.direction(), random(0, 2 * pi));
    std::vector<vec3> points;
    if (seed % 2 == 0) {
      for (int n = 0; n < 4 + int(seed) % 60; ++n) points.push_back(random.direction());
    } else {  // a prism with points between its corners, as coarse as floats would make them
      const int corners = 3 + int(seed) % 20;
      for (int n = 0; n < 2 * corners; ++n)
        for (const real z : {0., 0.5, 1.}) {
          const real a = pi * n / corners, r = n % 2 == 0 ? 1 : std::cos(pi / corners);
          const vec3 p = turn * vec3(r * std::cos(a), r * std::sin(a), z);
          points.push_back(p.cast<float>().cast<real>());
        }
    }
    const convex_polyhedron p(points);
    const polyhedron_mesh& m = p.mesh();
    CHECK(m.vertices.size() + m.faces() == m.edges.size() + 2);
    if (seed % 2 == 1) CHECK(m.faces() == 3 + seed % 20 + 2);
    for (const auto& e : m.edges) CHECK(e.left != e.right);
    for (const vec3& v : m.vertices)
      for (std::size_t f = 0; f < m.faces(); ++f) CHECK(m.normals[f].dot(v) <= m.offsets[f] + 1e-6);
  }
}

namespace {

/// Faces of a hull found by testing every plane through three points: for each the indices of the
/// points in it.
std::vector<std::vector<std::uint32_t>> planes_by_force(const std::vector<vec3>& p,
                                                        real tolerance) {
  std::vector<std::vector<std::uint32_t>> found;
  const auto n = static_cast<std::uint32_t>(p.size());
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = i + 1; j < n; ++j)
      for (std::uint32_t k = j + 1; k < n; ++k) {
        const vec3 area = (p[j] - p[i]).cross(p[k] - p[i]);
        if (area.norm() < 1e-3) continue;
        for (const real side : {-1., 1.}) {
          const vec3 normal = side * area.normalized();
          std::vector<std::uint32_t> in_plane;
          bool outer = true;
          for (std::uint32_t m = 0; m < n && outer; ++m) {
            const real height = normal.dot(p[m] - p[i]);
            outer = height < tolerance;
            if (height > -tolerance) in_plane.push_back(m);
          }
          if (outer) found.push_back(in_plane);
        }
      }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace

TEST_CASE("hulls have the faces that a look at every plane finds") {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    generator random{std::mt19937_64(seed)};
    // In general position, on a coarse grid (many in a plane, on a line, twice), and nearly so.
    const real size = std::pow(10., random(-90, 90));
    std::vector<vec3> points;
    for (int n = 0; n < 8 + int(seed) % 25; ++n) {
      vec3 p(random(0, 3), random(0, 3), random(0, 3));
      if (seed % 3 != 0)
        for (int k = 0; k < 3; ++k) p[k] = std::floor(p[k]);
      if (seed % 3 == 2)
        for (int k = 0; k < 3; ++k) p[k] += 1e-8 * random(-1, 1);
      points.push_back(p);
    }
    const auto planes = planes_by_force(points, 1e-5);
    if (planes.size() < 4) continue;
    std::vector<vec3> scaled;
    for (const vec3& p : points) scaled.push_back(size * p);
    const convex_polyhedron h(scaled);
    CHECK(h.mesh().faces() == planes.size());
    CHECK(h.mesh().vertices.size() + h.mesh().faces() == h.mesh().edges.size() + 2);
    for (const auto& plane : planes)
      for (const std::uint32_t m : plane) {
        real height = -1e9;
        for (std::size_t f = 0; f < h.mesh().faces(); ++f)
          height = std::max(
              height, h.mesh().normals[f].dot(h.frame().to_body(scaled[m])) - h.mesh().offsets[f]);
        CHECK(std::abs(height) < 1e-5 * size);
      }
  }
}

TEST_CASE("hulls of many points are measured alike whatever is inside them") {
  generator random{std::mt19937_64(11)};
  std::vector<vec3> shell, both;
  for (int n = 0; n < 8000; ++n) shell.push_back(random.direction());
  both = shell;
  for (int n = 0; n < 40000; ++n) both.push_back(0.9 * random(0, 1) * random.direction());
  const convex_polyhedron a(shell), b(both);
  CHECK(a.vertices().size() == 8000);
  CHECK(a == b);
  CHECK(a.volume() == doctest::Approx(4 * pi / 3).epsilon(2e-3));
  CHECK(a.mesh().vertices.size() + a.mesh().faces() == a.mesh().edges.size() + 2);

  std::vector<vec3> evenly;  // the points of a spiral from pole to pole
  for (int n = 0; n < 20000; ++n) {
    const real z = 1 - 2 * (n + 0.5) / 20000, r = std::sqrt(1 - z * z), turn = 2.399963 * n;
    evenly.push_back({r * std::cos(turn), r * std::sin(turn), z});
  }
  CHECK(convex_polyhedron(evenly).vertices().size() == 20000);
}

TEST_CASE("polyhedra are equal by their form and cost a reference each") {
  const std::vector<vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const convex_polyhedron a(points), copy = a, again(points);
  CHECK(&copy.mesh() == &a.mesh());
  CHECK(again == a);
  CHECK_FALSE(convex_polyhedron({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}}) == a);
  CHECK_FALSE(convex_polyhedron() == a);
  CHECK(convex_polyhedron() == convex_polyhedron());

  detail::byte_buffer bytes;
  detail::byte_writer out(bytes);
  out.put(a);
  detail::byte_reader in(bytes);
  const auto received = in.get<convex_polyhedron>();
  CHECK(in.empty());
  CHECK(received == a);
  CHECK(&received.mesh() != &a.mesh());
  CHECK(received.mesh().vertices == a.mesh().vertices);
  CHECK(received.mesh().corners == a.mesh().corners);
  CHECK(received.inertia() == a.inertia());
  CHECK(received.frame().position == a.frame().position);
}

TEST_CASE("a plane is solid below, its normal of any length") {
  CHECK(plane{.normal = {0, 0, 5}, .offset = 2}.distance({7, 8, 3}) == 1);
  CHECK(plane{.normal = {1e-300, 0, 0}, .offset = 2}.distance({7, 8, 3}) == 5);
  CHECK(plane{.normal = {0, -1e300, 0}, .offset = -2}.distance({7, 8, 3}) == -6);
  const vec3 n = vec3(1, 2, 3).normalized();
  CHECK(plane{.normal = n}.unit_normal() == n);
}

TEST_CASE("impossible shapes are refused by name") {
  for (const real r : {0., -1., nan_, inf_}) {
    check_refused(sphere{r}, "radius of a sphere");
    check_refused(box{{r, 1, 1}}, "x edge of a box");
    check_refused(box{{1, r, 1}}, "y edge of a box");
    check_refused(box{{1, 1, r}}, "z edge of a box");
  }
  for (const real r : {0., -1., nan_, inf_}) {
    check_refused(capsule{r, 1}, "radius of a capsule");
    check_refused(capsule{1, r}, "length of a capsule");
    check_refused(cylinder{r, 1}, "radius of a cylinder");
    check_refused(cylinder{1, r}, "length of a cylinder");
  }
  for (const real r : {0., -1., nan_, inf_, 1e-121, 1e121}) {
    check_refused(superellipsoid{{r, 1, 1}}, "x radius of a superellipsoid");
    check_refused(superellipsoid{{1, r, 1}}, "y radius of a superellipsoid");
    check_refused(superellipsoid{{1, 1, r}}, "z radius of a superellipsoid");
  }
  check_refused(superellipsoid{{1, 1, 1}, 1.99, 3}, "but are 1.99 and 3");
  check_refused(superellipsoid{{1, 1, 1}, 3, 8.5}, "but are 3 and 8.5");
  check_refused(superellipsoid{{1, 1, 1}, nan_, 3}, "but are nan and 3");
  check_refused(superellipsoid{{1, 1, 1}, 3, inf_}, "but are 3 and inf");
  for (const real r : {1e-300, 1e-121, 1e121, 1e300}) {
    const char* what = "beyond what numbers can hold";
    check_refused(sphere{r}, what);
    for (const vec3& size : {vec3(r, 1, 1), vec3(1, r, 1), vec3(1, 1, r)})
      check_refused(box{size}, what);
    check_refused(capsule{r, 1}, what);
    check_refused(capsule{1, r}, what);
    check_refused(cylinder{r, 1}, what);
    check_refused(cylinder{1, r}, what);
    CHECK_THROWS_WITH_AS(convex_polyhedron({{0, 0, 0}, {r, 0, 0}, {0, r, 0}, {0, 0, r}}),
                         doctest::Contains(what), std::invalid_argument);
  }
  for (const real r : {1e-100, 1e-60, 1e60, 1e100}) {
    CHECK_NOTHROW((box{{r, 1, 1}}.validate()));
    const convex_polyhedron p({{0, 0, 0}, {r, 0, 0}, {0, r, 0}, {0, 0, r}});
    CHECK(std::isnormal(p.volume()));
    CHECK(p.volume() == doctest::Approx(r * r * r / 6));
    for (int k = 0; k < 3; ++k) CHECK(std::isnormal(p.inertia()[k]));
    CHECK(p.bounding_radius() == doctest::Approx(r * std::sqrt(11.) / 4));
    CHECK(p.mesh().measured.half_width > 0.1 * r);
  }
  check_refused(convex_polyhedron{}, "without vertices");
  CHECK_THROWS_AS(convex_polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), std::invalid_argument);
  CHECK_THROWS_AS(convex_polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {3, 4, 0}}),
                  std::invalid_argument);
  CHECK_THROWS_AS(convex_polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, nan_}}),
                  std::invalid_argument);
  check_refused(plane{{0, 0, 0}, 0}, "normal of a plane");
  check_refused(plane{{0, nan_, 1}, 0}, "normal of a plane");
  check_refused(plane{{0, inf_, 1}, 0}, "normal of a plane");
  check_refused(plane{{0, 0, 1}, nan_}, "offset of a plane");
  CHECK_NOTHROW(plane{}.validate());
}

TEST_CASE(
    "a convex polyhedron lies where its corners were given, at the pose that placed() returns") {
  const convex_polyhedron wedge({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}});
  const pose at = placed(wedge);  // of the body, when its corners lie as given
  const body stone{.shape = wedge, .position = at.position, .orientation = at.orientation};
  CHECK(stone.shape.volume() == doctest::Approx(1));
  CHECK((stone.position - vec3(2. / 3, 0.5, 1. / 3)).norm() < 1e-12);
  vec3 lower(9, 9, 9), upper(-9, -9, -9);
  for (const vec3& v : stone.shape.vertices()) {
    const vec3 p = stone.position + rotated(stone.orientation, v);
    lower = lower.cwiseMin(p), upper = upper.cwiseMax(p);
  }
  CHECK((lower - vec3(0, 0, 0)).norm() < 1e-12);
  CHECK((upper - vec3(2, 1, 1)).norm() < 1e-12);
}
