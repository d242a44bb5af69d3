// A plane may be divided into triangles in any way, thin ones among them, and its corners may have
// round-off: the contacts of a body on it are those on the plane.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <talus/detect/narrow.hpp>
#include <talus/mesh.hpp>
#include <vector>

using namespace talus;

namespace {

using triangle = triangle_mesh::triangle;
using numbers = std::mt19937;

real draw(numbers& g, real low, real high) {
  return std::uniform_real_distribution<real>(low, high)(g);
}
/// Places from -2 to 2, some of them beside each other.
std::vector<real> cuts(numbers& g, real least) {
  std::vector<real> all{-2, 2};
  for (int k = static_cast<int>(draw(g, 3, 20)); k > 0; --k) {
    all.push_back(draw(g, -2, 2));
    if (draw(g, 0, 1) < 0.4)
      all.push_back(std::min(real(2), all.back() + 0.1 * std::pow(least, draw(g, 0, 1))));
  }
  std::sort(all.begin(), all.end());
  return all;
}
/// A square of side 4, divided at random, with corners up to `rough` away from the plane.
triangle_mesh divided_square(numbers& g, real rough, surface_report* report = nullptr) {
  const std::vector<real> x = cuts(g, 1e-4), y = cuts(g, 1e-4);
  std::vector<vec3> at;
  for (const real u : x)
    for (const real v : y) at.push_back({u, v, draw(g, -rough, rough)});
  std::vector<triangle> all;
  for (std::size_t i = 0; i + 1 < x.size(); ++i)
    for (std::size_t j = 0; j + 1 < y.size(); ++j) {
      const std::size_t n = y.size();
      const vec3 &a = at[i * n + j], &b = at[(i + 1) * n + j], &c = at[(i + 1) * n + j + 1],
                 &d = at[i * n + j + 1];
      if (draw(g, 0, 1) < 0.5)
        all.push_back({a, b, c}), all.push_back({a, c, d});
      else
        all.push_back({a, b, d}), all.push_back({b, c, d});
    }
  return triangle_mesh(all, report);
}

struct found {
  std::size_t count = 0;
  real overlaps = 0;
  vec3 moment{0, 0, 0};  ///< sum of overlaps times places
};
template <class A, class B>
found contacts(const A& a, const pose& pa, const B& b, const pose& pb) {
  found all;
  collide_pair(a, pa, b, pb, 0, [&](const contact_geometry& c) {
    CHECK((c.normal - vec3(0, 0, -1)).norm() < 1e-6);
    ++all.count, all.overlaps -= c.gap, all.moment -= c.gap * c.point;
  });
  return all;
}
/// A prism of n sides around the axis z.
convex_polyhedron prism(int n, real radius, real height) {
  std::vector<vec3> corners;
  for (int k = 0; k < n; ++k) {
    const real turn = 2 * std::numbers::pi * k / n;
    for (const real z : {-0.5, 0.5})
      corners.push_back({radius * std::cos(turn), radius * std::sin(turn), z * height});
  }
  return convex_polyhedron(corners);
}

/// `stands`: from the centre to what is lowest.
template <class Shape>
void compare(const Shape& shape, real stands, const quat& lying, const triangle_mesh& surface,
             const vec3& place, real turn) {
  CAPTURE(Shape::name);
  constexpr real overlap = 1e-4;
  const pose at{place + vec3(0, 0, stands - overlap), rotation({0, 0, 1}, turn) * lying};
  const found on_plane = contacts(plane{}, pose{}, shape, at);
  const found on_triangles = contacts(surface, placed(surface, pose{}), shape, at);
  CHECK(on_triangles.count == on_plane.count);
  CHECK(on_triangles.overlaps == doctest::Approx(on_plane.overlaps).epsilon(0.02));
  CHECK((on_triangles.moment - on_plane.moment).norm() < 0.02 * on_plane.overlaps);
}

}  // namespace

TEST_CASE("contacts on a plane are those of one face, however it is divided and rounded") {
  const quat upright(1, 0, 0, 0), lying = rotation({0, 1, 0}, std::numbers::pi / 2);
  for (const real rough : {0., 1e-7, 1e-6})
    for (unsigned seed = 0; seed < 60; ++seed) {
      numbers g(seed);
      CAPTURE(rough);
      CAPTURE(seed);
      const triangle_mesh surface = divided_square(g, rough);
      const vec3 place(draw(g, -0.6, 0.6), draw(g, -0.6, 0.6), 0);
      const real turn = seed % 5 == 0 ? 0 : draw(g, 0, 6);
      compare(box{{0.8, 0.5, 0.6}}, 0.3, upright, surface, place, turn);
      compare(prism(8, 0.4, 0.6), 0.3, upright, surface, place, turn);
      compare(prism(3, 0.4, 0.6), 0.3, upright, surface, place, turn);
      compare(cylinder{0.4, 0.6}, 0.3, upright, surface, place, turn);
      compare(cylinder{0.3, 0.8}, 0.3, lying, surface, place, turn);
      compare(capsule{0.2, 0.8}, 0.2, lying, surface, place, turn);
    }
}

TEST_CASE("corners that round-off moves out of their planes are moved back, those at edges too") {
  // A step: two levels and the wall between them, in strips, with the round-off of single
  // precision far from the origin.
  numbers g(7);
  const auto in_single = [](const vec3& p) {
    return vec3(static_cast<float>(p[0] + 3), static_cast<float>(p[1] + 3),
                static_cast<float>(p[2] + 3));
  };
  std::vector<triangle> all;
  const auto strip = [&](const vec3& from, const vec3& along, const vec3& across) {
    real last = 0;
    const quat tilt = rotation(vec3(1, 2, 3).normalized(), 0.7);
    for (int k = 0; k < 40; ++k) {
      const real next = k == 39 ? 1 : last + (1 - last) * draw(g, 0, 0.1);
      const auto at = [&](real x, real y) {
        return in_single(rotated(tilt, vec3(from + x * along + y * across)));
      };
      all.push_back({at(last, 0), at(next, 0), at(next, 1)});
      all.push_back({at(last, 0), at(next, 1), at(last, 1)});
      last = next;
    }
  };
  strip({-1, 0, 0}, {1, 0, 0}, {0, 1, 0});
  strip({0, 0, 0}, {0, 0, 0.5}, {0, 1, 0});
  strip({0, 0, 0.5}, {1, 0, 0}, {0, 1, 0});
  surface_report report;
  const triangle_mesh m(all, &report);
  CHECK(report.levelled > 100);
  CHECK(report.text().find("corners moved into the plane around them") != std::string::npos);
  // Normals are those of two directions to 1e-6, though the thinnest triangles would be tilted
  // more.
  const detail::triangle_tree& tree = m.tree();
  const vec3 level = tree.normals[0];
  vec3 wall = level;
  for (const vec3& n : tree.normals)
    if (std::abs(n.dot(level)) < 0.5) wall = n;
  real worst = 0;
  for (const vec3& n : tree.normals) {
    const vec3& of = std::abs(n.dot(level)) > 0.5 ? level : wall;
    worst = std::max(worst, std::min((n - of).norm(), (n + of).norm()));
  }
  CHECK(std::abs(level.dot(wall)) < 1e-6);
  CHECK(worst < 1e-6);
}

namespace {

/// A surface over a square of side 2, of n x n squares of two triangles each.
template <class Height>
std::vector<triangle> surface_over(int n, Height&& height) {
  std::vector<triangle> all;
  const auto at = [&](int i, int j) {
    const real x = -1 + real(2) * i / n, y = -1 + real(2) * j / n;
    return vec3(x, y, height(x, y));
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      all.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      all.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return all;
}

}  // namespace

TEST_CASE("surfaces that bend little keep their corners, however fine they are") {
  surface_report report;
  for (const real bend : {1e-6, 1e-5, 1e-4, 1e-3}) {
    CAPTURE(bend);
    (void)triangle_mesh(surface_over(100, [&](real x, real y) { return bend * (x * x + y * y); }),
                        &report);
    CHECK(report.levelled == 0);
    (void)triangle_mesh(surface_over(100, [&](real x, real y) { return bend * (x * x - y * y); }),
                        &report);
    CHECK(report.levelled == 0);
    (void)triangle_mesh(surface_over(60, [&](real x, real) { return bend * std::abs(x); }),
                        &report);
    CHECK(report.levelled == 0);
  }
}

TEST_CASE("levelling turns no triangle over, though its features be as small as the round-off") {
  for (unsigned seed = 0; seed < 300; ++seed) {
    numbers g(seed);
    CAPTURE(seed);
    const real size = std::pow(10, draw(g, -5.6, -4.8)), rough = std::pow(10, draw(g, -7.5, -6));
    std::vector<real> x{-1};
    for (int k = 0; k < 3; ++k) x.push_back((k == 0 ? 0 : x.back()) + k * size * draw(g, 0.8, 1.5));
    x.push_back(1);
    std::vector<std::vector<real>> z(x.size(), std::vector<real>(x.size()));
    for (auto& row : z)
      for (real& height : row) height = draw(g, -rough, rough);
    z[2][2] += size * draw(g, 0.5, 2);
    std::vector<triangle> all;
    for (std::size_t i = 0; i + 1 < x.size(); ++i)
      for (std::size_t j = 0; j + 1 < x.size(); ++j) {
        const auto at = [&](std::size_t a, std::size_t b) { return vec3(x[a], x[b], z[a][b]); };
        all.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        all.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    const triangle_mesh m(all);
    for (const vec3& n : m.tree().normals) CHECK(n[2] > 0);
  }
}

TEST_CASE("a body beside the wall of a closed surface has no contact through its top") {
  std::vector<triangle> all;
  for (int axis = 0; axis < 3; ++axis)
    for (const real sign : {-1., 1.}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto at = [&](real a, real b) {
        vec3 p;
        p[axis] = sign, p[u] = sign * a, p[v] = b;
        return p;
      };
      all.push_back({at(-1, -1), at(1, -1), at(1, 1)});
      all.push_back({at(-1, -1), at(1, 1), at(-1, 1)});
    }
  const triangle_mesh m(all);
  for (const real turn : {0., 1e-5, 1e-3})
    for (const real overlap : {1e-9, 1e-6, 1e-4}) {
      const real half = 0.25 * (std::cos(turn) + std::sin(turn));
      const pose at{{1 + half - overlap, 0.1, 1}, rotation({0, 0, 1}, turn)};
      collide_pair(m, placed(m, pose{}), box{{0.5, 0.5, 0.5}}, at, 0,
                   [&](const contact_geometry& c) { CHECK(c.gap > -1.01 * overlap - 1e-12); });
    }
}

TEST_CASE("flat surfaces without round-off and curved ones are left as they are") {
  numbers g(3);
  surface_report report;
  const triangle_mesh flat = divided_square(g, 0, &report);
  CHECK(report.levelled == 0);
  for (const vec3& n : flat.tree().normals) CHECK(std::abs(n[2]) == 1);
  std::vector<triangle> all;
  constexpr int parts = 64;  // around a cylinder
  for (int k = 0; k < parts; ++k) {
    const auto at = [](int step, real z) {
      const real turn = 2 * std::numbers::pi * step / parts;
      return vec3(std::cos(turn), std::sin(turn), z);
    };
    all.push_back({at(k, 0), at(k + 1, 0), at(k + 1, 1)});
    all.push_back({at(k, 0), at(k + 1, 1), at(k, 1)});
  }
  (void)triangle_mesh(all, &report);
  CHECK(report.levelled == 0);
}

TEST_CASE("a lying cylinder has its two ends as contacts, however near corners of triangles are") {
  // Rows of bricks, each half a brick beside the last one.
  std::vector<triangle> all;
  for (int j = -6; j < 6; ++j)
    for (int i = -6; i < 6; ++i) {
      const real x = 0.4 * i + (j & 1 ? 0.2 : 0), y = 0.3 * j;
      const vec3 a(x, y, 0), b(x + 0.4, y, 0), c(x + 0.4, y + 0.3, 0), d(x, y + 0.3, 0);
      all.push_back({a, b, c}), all.push_back({a, c, d});
    }
  const triangle_mesh bricks(all);
  const pose surface = placed(bricks);
  const cylinder shape{0.3, 0.9};
  for (const real turn : {0.0, 0.11, -0.7})
    for (real beside = 1e-3; beside > 1e-13; beside *= real(0.3)) {
      CAPTURE(turn);
      CAPTURE(beside);
      const quat q = rotation({0, 0, 1}, turn);
      const vec3 centre = q * vec3(0.05, beside, 0);  // the line of contact leads past the origin
      const pose at{centre + vec3(0, 0, shape.radius),
                    q * rotation({0, 1, 0}, std::numbers::pi / 2)};
      int count = 0;
      collide_pair(shape, at, bricks, surface, 1e-6, [&](const contact_geometry& c) {
        ++count;
        CHECK((c.normal - vec3(0, 0, 1)).norm() < 1e-9);
        CHECK(std::abs((c.point - centre).norm() - 0.45) < 1e-6);
      });
      CHECK(count == 2);
    }
}

TEST_CASE("a cylinder whose ends lie on edges of a closed surface has these two as contacts") {
  std::vector<triangle> all;
  vec3 v[8];
  for (int k = 0; k < 8; ++k) v[k] = vec3(k & 1 ? 2 : -2, k & 2 ? 0.45 : -0.45, k & 4 ? 0 : -1);
  for (const auto& [a, b, c, d] : {std::array{4, 5, 7, 6},
                                   {0, 2, 3, 1},
                                   {0, 1, 5, 4},
                                   {2, 6, 7, 3},
                                   {0, 4, 6, 2},
                                   {1, 3, 7, 5}})
    all.push_back({v[a], v[b], v[c]}), all.push_back({v[a], v[c], v[d]});
  const triangle_mesh block(all);
  const pose surface = placed(block);
  const cylinder shape{0.3, 0.9};
  for (const real x : {-0.123, -0.1, 0.0, 0.0321, 0.7})
    for (const real gap : {-1e-9, -1e-15, 0.0, 1e-15, 1e-9})
      for (const real lean : {0.0, 1e-12, 1e-10, 1e-8}) {
        CAPTURE(x);
        CAPTURE(gap);
        CAPTURE(lean);
        const pose at{
            vec3(x, 0, shape.radius + gap),
            rotation({1, 0, 0}, std::numbers::pi / 2 + lean) * rotation({0, 0, 1}, 3 * x)};
        int count = 0;
        collide_pair(shape, at, block, surface, 1e-6, [&](const contact_geometry& c) {
          ++count;
          CHECK((c.normal - vec3(0, 0, 1)).norm() < 1e-7);
          CHECK(std::abs(c.point[0] - x) < 1e-12);
          CHECK(std::abs(std::abs(c.point[1]) - 0.45) < 1e-6);
        });
        CHECK(count == 2);
      }
}
