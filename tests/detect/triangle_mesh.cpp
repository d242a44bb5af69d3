// Surfaces of triangles: their construction, their contacts against those of planes and boxes, and
// smooth passage over inner edges.
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <random>
#include <stdexcept>
#include <talus/detect/narrow.hpp>
#include <talus/mesh.hpp>
#include <utility>
#include <vector>

#include "../landscape.hpp"
#include "../vectors.hpp"

using namespace talus;

namespace {

using triangle = triangle_mesh::triangle;

std::vector<triangle> flat(int n, real size) {
  return landscape(n, size, [](real, real) { return 0; });
}
/// The twelve triangles of a box.
std::vector<triangle> sides(const vec3& half) {
  std::vector<triangle> all;
  for (int axis = 0; axis < 3; ++axis)
    for (const real sign : {-1., 1.}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto at = [&](real a, real b) {
        vec3 p;
        p[axis] = sign * half[axis], p[u] = sign * a * half[u], p[v] = b * half[v];
        return p;
      };
      all.push_back({at(-1, -1), at(1, -1), at(1, 1)});
      all.push_back({at(-1, -1), at(1, 1), at(-1, 1)});
    }
  return all;
}
template <class Shape>
std::vector<contact_geometry> contacts(const triangle_mesh& m, const pose& at, const Shape& s,
                                       const pose& there, real margin) {
  std::vector<contact_geometry> found;
  collide_pair(s, there, m, at, margin, [&](const contact_geometry& c) { found.push_back(c); });
  return found;
}
real smallest(const std::vector<contact_geometry>& all) {
  real least = 1e9;
  for (const auto& c : all) least = std::min(least, c.gap);
  return least;
}

}  // namespace

TEST_CASE(
    "a mesh keeps its corners once, leaves out what has no area, and lies where it was given") {
  auto list = sides({1, 2, 3});
  for (auto& t : list)
    for (vec3& v : t) v += vec3(10, 0, -5);
  list.push_back({vec3(1, 1, 1), vec3(1, 1, 1), vec3(2, 2, 2)});
  const triangle_mesh m(list);
  CHECK(m.triangles() == 12);
  CHECK(m.tree().vertices.size() == 8);
  CHECK((placed(m).position - vec3(10, 0, -5)).norm() == 0);
  CHECK(m.bounding_radius() == doctest::Approx(std::sqrt(14.0)));
  CHECK(m.volume() == doctest::Approx(8 * (1 * 2 + 2 * 3 + 3 * 1)));
  CHECK((m.half_extents({}) - vec3(1, 2, 3)).norm() < 1e-14);
  for (const auto& around : m.tree().neighbours)
    for (const auto n : around) CHECK(n != detail::triangle_tree::none);
  detail::byte_buffer bytes;
  detail::byte_writer out(bytes);
  m.pack(out);
  detail::byte_reader in(bytes);
  CHECK(triangle_mesh::unpack(in) == m);

  CHECK_THROWS_WITH(triangle_mesh(std::vector<triangle>{}),
                    "a triangle_mesh has from 1 to 268435456 triangles with an area, but 0 of 0 "
                    "have one");
  list[3][1][2] = std::nan("");
  CHECK_THROWS_WITH(triangle_mesh{list}, doctest::Contains("triangle 3 of a triangle_mesh has a "
                                                           "corner at"));
}

TEST_CASE("every triangle within a box is found by the tree, and no other") {
  std::mt19937 random(1);
  std::uniform_real_distribution<real> in(-5, 5);
  const triangle_mesh m(
      landscape(30, 10, [](real x, real y) { return std::sin(x) * std::cos(y); }));
  for (int k = 0; k < 200; ++k) {
    const vec3 centre(in(random), in(random), 0.3 * in(random)), half(0.4, 0.3, 0.5);
    std::vector<bool> found(m.triangles());
    m.tree().each_within(centre - half, centre + half, [&](std::uint32_t t) {
      CHECK(!found[t]);
      found[t] = true;
    });
    for (std::uint32_t t = 0; t < m.triangles(); ++t) {
      vec3 lower = m.tree().corner(t, 0), upper = lower;
      for (std::size_t c = 1; c < 3; ++c)
        lower = lower.cwiseMin(m.tree().corner(t, c)),
        upper = upper.cwiseMax(m.tree().corner(t, c));
      const bool overlaps = at_most(lower, centre + half) && at_most(centre - half, upper);
      CHECK(found[t] == overlaps);
    }
  }
}

TEST_CASE("a sphere on a flat surface has one contact, straight up, wherever it is") {
  std::mt19937 random(2);
  std::uniform_real_distribution<real> in(-4, 4);
  const pose at{{1, 2, 3}, rotation(vec3(1, 2, 2).normalized(), 0.7)};
  const triangle_mesh m(flat(8, 10));
  const vec3 up = rotated(at.orientation, vec3(0, 0, 1));
  for (int k = 0; k < 2000; ++k) {
    // Some over edges and corners to the bit.
    vec3 place(in(random), in(random), 0);
    if (k % 3 == 1) place[0] = 1.25;
    if (k % 3 == 2) place[0] = place[1] = -2.5;
    const real height = 0.5 + 0.05 * in(random);
    const bool below = k % 2;
    place[2] = below ? -height : height;
    const auto found = contacts(m, at, sphere{0.5}, {at.to_world(place), {1, 0, 0, 0}}, 0.3);
    CAPTURE(k);
    REQUIRE(found.size() == 1);
    CHECK((found[0].normal - (below ? vec3(-up) : up)).norm() < 1e-9);
    CHECK(found[0].gap == doctest::Approx(height - 0.5).epsilon(1e-9));
  }
}

TEST_CASE("a sphere beside a box of triangles has the contact that it has with the box") {
  std::mt19937 random(3);
  std::uniform_real_distribution<real> in(-2.2, 2.2);
  const vec3 half(1, 0.7, 1.3);
  const triangle_mesh m(sides(half));
  int compared = 0;
  for (int k = 0; k < 5000; ++k) {
    const pose there{{in(random), in(random), in(random)}, {1, 0, 0, 0}};
    if (below(there.position.cwiseAbs(), half)) continue;  // the mesh is hollow
    std::vector<contact_geometry> wanted;
    collide_pair(sphere{0.4}, there, box{2 * half}, pose{}, 0.2,
                 [&](const contact_geometry& c) { wanted.push_back(c); });
    const auto found = contacts(m, {}, sphere{0.4}, there, 0.2);
    CAPTURE(k);
    REQUIRE(found.size() == wanted.size());
    if (wanted.empty() || wanted[0].gap < -0.4 + 1e-6) continue;
    ++compared;
    CHECK((found[0].normal - wanted[0].normal).norm() < 1e-9);
    CHECK((found[0].point - wanted[0].point).norm() < 1e-9);
    CHECK(found[0].gap == doctest::Approx(wanted[0].gap).epsilon(1e-9));
  }
  CHECK(compared > 500);
}

TEST_CASE_TEMPLATE("a solid on a flat surface is held as by a plane, without a push to a side",
                   Shape, box, capsule, cylinder, convex_polyhedron) {
  Shape s;
  if constexpr (std::is_same_v<Shape, box>)
    s = box{{1, 0.8, 0.6}};
  else if constexpr (std::is_same_v<Shape, convex_polyhedron>)
    s = convex_polyhedron(
        std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0.3}});
  else
    s = Shape{.radius = 0.4, .length = 0.9};
  std::mt19937 random(4);
  std::uniform_real_distribution<real> in(-3, 3);
  std::normal_distribution<real> any;
  for (const int cells : {1, 7, 40}) {
    const triangle_mesh m(flat(cells, 12));
    real worst = 0;
    for (int k = 0; k < 300; ++k) {
      pose there{{in(random), in(random), 0},
                 quat(any(random), any(random), any(random), any(random))};
      there.orientation.normalize();
      if (k % 4 == 0) there.orientation = quat(std::cos(0.1 * k), 0, 0, std::sin(0.1 * k));
      const vec3 down = rotated(quat(there.orientation.conjugate()), vec3(0, 0, -1));
      const real deep = 0.02 * in(random) / 3;
      there.position[2] = deep + (std::is_same_v<Shape, capsule> ? s.half_extents(there)[2]
                                                                 : s.support(down).dot(down));
      const auto found = contacts(m, {}, s, there, 0.05);
      CAPTURE(cells);
      CAPTURE(k);
      REQUIRE(!found.empty());
      CHECK(smallest(found) == doctest::Approx(deep).epsilon(2e-3).scale(1));
      for (const auto& c : found) {
        worst = std::max(worst, (c.normal - vec3(0, 0, 1)).norm());
        CHECK(c.gap >= deep - 2e-3);
      }
    }
    CHECK(worst < 1e-6);
  }
}

TEST_CASE("a body that enters a fine mesh has the contact points that it has with a plane") {
  std::vector<vec3> corners;
  for (int k = 0; k < 6; ++k)
    for (const real z : {-0.4, 0.4})
      corners.emplace_back(std::cos(k * pi / 3), std::sin(k * pi / 3), z);
  const auto check = [](const auto& shape, real height) {
    for (const int n : {8, 80, 133}) {
      const triangle_mesh m(flat(n, 8));
      for (const real deep : {1e-6, 1e-3, 3e-3, 6e-3})
        for (int k = 0; k < 20; ++k) {
          CAPTURE(n);
          CAPTURE(deep);
          CAPTURE(k);
          const pose at{{0.137 * (k % 7), -0.171 * (k % 11), height - deep},
                        rotation({0, 0, 1}, 0.1 * k)};
          const auto found = contacts(m, placed(m), shape, at, 0);
          std::size_t count = 0;
          collide_pair(shape, at, plane{}, pose{}, 0, [&](const contact_geometry& c) {
            ++count;
            real apart = 1;
            for (const auto& f : found) apart = std::min(apart, (f.point - c.point).norm());
            CHECK(apart < 1e-6);
          });
          CHECK(found.size() == count);
        }
    }
  };
  check(box{{2, 2, 0.8}}, 0.4), check(box{{0.4, 3, 0.8}}, 0.4);
  check(convex_polyhedron(corners), 0.4);
}

TEST_CASE("a tilted plane of corners in single precision is one face") {
  const quat tilt = rotation({0.3, 1, 0.2}, 0.37);
  for (const int n : {4, 40}) {
    auto all = flat(n, 2);
    for (triangle& t : all)
      for (vec3& v : t) {
        v = rotated(tilt, v);
        for (int k = 0; k < 3; ++k) v[k] = static_cast<real>(static_cast<float>(v[k]));
      }
    const triangle_mesh m(all);
    const box cube{{0.3, 0.3, 0.3}};
    for (const vec3& at : {vec3(0, 0, 0), vec3(0.41, -0.23, 0), vec3(-0.6, 0.55, 0)}) {
      const vec3 where = rotated(tilt, vec3(at + vec3(0, 0, 0.15 - 1e-5)));
      int points = 0;
      collide_pair(m, m.frame(), cube, pose{where, tilt}, 1e-4,
                   [&](const contact_geometry&) { ++points; });
      CAPTURE(n);
      CAPTURE(at[0]);
      CHECK(points == 4);
    }
  }
}

TEST_CASE("a surface whose corners coincide, or are too far away, is refused") {
  const vec3 p(1, 2, 3);
  CHECK_THROWS_AS(triangle_mesh({{p, p, p}}), std::invalid_argument);
  for (const real far : {1e80, 1e200, 1e308})
    CHECK_THROWS_AS(triangle_mesh({{vec3(far, 0, 0), vec3(0, far, 0), vec3(0, -far, 0)}}),
                    std::invalid_argument);
}

TEST_CASE("STL files are read as text and in binary, and what is wrong with them is said") {
  const std::string file = "/tmp/talus_stl_" + std::to_string(getpid()) + ".stl";
  const auto write = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
  };
  const auto list = sides({1, 2, 3});
  std::string text = "solid box\n", binary(80, ' ');
  const auto count = static_cast<std::uint32_t>(list.size());
  binary.append(reinterpret_cast<const char*>(&count), 4);
  for (const triangle& t : list) {
    text += " facet normal 0 0 0\n  outer loop\n";
    binary.append(12, '\0');
    for (const vec3& v : t) {
      text += "   vertex " + std::to_string(v[0]) + " " + std::to_string(v[1]) + " " +
              std::to_string(v[2]) + "\n";
      for (int k = 0; k < 3; ++k) {
        const auto x = static_cast<float>(v[k]);
        binary.append(reinterpret_cast<const char*>(&x), 4);
      }
    }
    text += "  endloop\n endfacet\n";
    binary.append(2, '\0');
  }
  text += "endsolid box\n";
  write(text);
  CHECK(read_stl(file) == triangle_mesh(list));
  write(binary);
  CHECK(read_stl(file) == triangle_mesh(list));
  CHECK(read_stl(file, 0.001).bounding_radius() == doctest::Approx(0.001 * std::sqrt(14.0)));

  for (const std::size_t more : {1, 49}) {
    write(binary + std::string(more, '\n'));
    CHECK(read_stl(file) == triangle_mesh(list));
  }

  write(binary.substr(0, 300));
  CHECK_THROWS_WITH(read_stl(file), doctest::Contains("is no STL file, or is cut off: it has 300 "
                                                      "bytes, and says that it holds 12"));
  write("\xef\xbb\xbf" + text);
  CHECK(read_stl(file) == triangle_mesh(list));
  // As other programs write it: upper case, remarks before it, other ends of lines, one line.
  const auto with = [&](auto&& change) {
    std::string changed;
    for (const char c : text) changed += change(c);
    return changed;
  };
  for (const std::string& other :
       {with([](char c) { return std::string(1, static_cast<char>(std::toupper(c))); }),
        "\n; made by a mill\n  " + text,
        with([](char c) { return c == '\n' ? "\r" : std::string(1, c); }),
        with([](char c) { return c == '\n' ? "\r\n" : std::string(1, c); }),
        with([](char c) { return c == '\n' ? " " : std::string(1, c); }),
        text.substr(text.find(" facet"))}) {
    write(other);
    CHECK(read_stl(file) == triangle_mesh(list));
  }
  write("solid a\r\nfacet\r\nvertex 1 2 x\r\n");
  CHECK_THROWS_WITH(read_stl(file), doctest::Contains("line 3 of the STL file"));
  write(
      "a picture or a table of figures: 1 2 3, but no surface; it is long enough for a binary "
      "file");
  CHECK_THROWS_WITH(read_stl(file), doctest::Contains("is no STL file: it is neither a text with"));
  CHECK_THROWS_WITH(read_stl("/tmp"), "the STL file /tmp is a folder: name the file in it");

  write(text.substr(0, 200));
  CHECK_THROWS_WITH(read_stl(file), doctest::Contains("ends without 'endsolid': it was cut off"));
  write("solid a\nfacet\nvertex 1 2 x\n");
  CHECK_THROWS_WITH(read_stl(file), doctest::Contains("line 3 of the STL file"));
  std::remove(file.c_str());
  CHECK_THROWS_WITH(read_stl(file), doctest::Contains("cannot be read: is the name right"));
}

namespace {

/// The number of edges without a neighbour.
int open_rim(const triangle_mesh& m) {
  int open = 0;
  for (const auto& n : m.tree().neighbours)
    for (const std::uint32_t t : n) open += t == detail::triangle_tree::none;
  return open;
}

}  // namespace

TEST_CASE("corners that nearly coincide are one, and those on an edge are joined with it") {
  const auto rectangle = [](real x0, real x1, real y0, real y1) {
    const vec3 a(x0, y0, 0), b(x1, y0, 0), c(x1, y1, 0), d(x0, y1, 0);
    return std::vector<triangle>{{a, b, c}, {a, c, d}};
  };
  const auto add = [](std::vector<triangle>& to, const std::vector<triangle>& more) {
    to.insert(to.end(), more.begin(), more.end());
  };
  surface_report report;
  // Corners that differ by the round-off of single precision.
  auto all = rectangle(-1, 0, -1, 1);
  add(all, rectangle(6e-8, 1, -1 - 1e-7, 1));
  const triangle_mesh welded(all, &report);
  CHECK(welded.tree().vertices.size() == 6);
  CHECK(report.merged == 3);
  CHECK(report.open_edges.size() == 6);
  CHECK(report.joined.empty());
  CHECK(open_rim(welded) == 6);
  // A triangle twice, also the other way around, and one without an area.
  all = rectangle(-1, 0, -1, 1);
  add(all, {all[0],
            {all[1][2], all[1][1], all[1][0]},
            {vec3(0, 0, 0), vec3(1, 0, 0), vec3(2, 0, 1e-8)}});
  CHECK(triangle_mesh(all, &report).triangles() == 2);
  CHECK(report.doubled == 2);
  CHECK(report.without_area == 1);
  // Five rectangles beside three, whose corners lie on each other's edges.
  all.clear();
  for (int k = 0; k < 5; ++k) add(all, rectangle(-1, 0, -1 + 0.4 * k, -0.6 + 0.4 * k));
  for (int k = 0; k < 3; ++k) add(all, rectangle(0, 1, -1 + 2 * k / 3.0, -1 + 2 * (k + 1) / 3.0));
  const triangle_mesh joined(all, &report);
  CHECK(joined.triangles() == 16 + 6);
  CHECK(joined.volume() == doctest::Approx(4));
  REQUIRE(report.joined.size() == 6);
  for (const vec3& p : report.joined) CHECK(p[0] == 0);
  CHECK(report.open_edges.size() == 12);
  CHECK(open_rim(joined) == 12);
  CHECK(report.text().find("6 corners on an edge joined (the first at (0, -") != std::string::npos);
  // A third sheet on an edge of two.
  all = rectangle(-1, 0, -1, 1);
  add(all, rectangle(0, 1, -1, 1));
  all.push_back({vec3(0, -1, 0), vec3(0, 1, 0), vec3(0, 0, 1)});
  (void)triangle_mesh(all, &report);
  REQUIRE(report.shared_edges.size() == 1);
  CHECK(report.shared_edges[0].norm() < 1e-15);
}

namespace {

/// Volume within a surface, by the divergence theorem; positive where normals point outwards.
real enclosed(const std::vector<triangle>& all) {
  real sum = 0;
  for (const triangle& t : all) sum += t[0].dot(t[1].cross(t[2])) / 6;
  return sum;
}
/// Directed edges that no triangle passes in reverse: none in a watertight surface whose normals
/// agree.
int open_edges(const triangle_mesh& m) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> passes;
  for (const auto& t : m.tree().triangles)
    for (std::size_t k = 0; k < 3; ++k)
      ++passes[{t[k], t[(k + 1) % 3]}], --passes[{t[(k + 1) % 3], t[k]}];
  int open = 0;
  for (const auto& [edge, n] : passes) open += n > 0 ? n : 0;
  return open;
}
/// Area of the polygon that approximates a circle.
real polygon(int n, real radius) { return 0.5 * n * std::sin(2 * pi / n) * radius * radius; }

}  // namespace

TEST_CASE(
    "closed tubes and cones are watertight, with normals outwards and the volume of a prism") {
  using line = std::vector<std::array<real, 2>>;
  for (const int n : {3, 7, 64}) {
    CAPTURE(n);
    const revolution closed{.sectors = n, .closed = true}, open{.sectors = n};
    const real r = 1.5, R = 2.5, h = 3;
    CHECK(enclosed(triangles_of_revolution({{r, 0}, {r, h}}, closed)) ==
          doctest::Approx(polygon(n, r) * h));
    CHECK(enclosed(triangles_of_revolution({{R, 0}, {r, h}}, closed)) ==
          doctest::Approx((polygon(n, r) + polygon(n, std::sqrt(r * R)) + polygon(n, R)) * h / 3));
    CHECK(enclosed(triangles_of_revolution({{R, 0}, {0, h}}, closed)) ==
          doctest::Approx(polygon(n, R) * h / 3));
    CHECK(enclosed(triangles_of_revolution({{0, h}, {R, 0}}, closed)) ==
          doctest::Approx(-polygon(n, R) * h / 3));  // from above: the normals point inwards
    CHECK(open_edges(tube_surface({.radius = r, .height = h}, closed)) == 0);
    CHECK(open_edges(tube_surface({.radius = r, .height = h}, open)) == 2 * n);
    CHECK(open_edges(cone_surface({.lower = R, .upper = r, .height = h}, closed)) == 0);
    CHECK(open_edges(cone_surface({.lower = R, .upper = r, .height = h}, open)) == 2 * n);
    CHECK(open_edges(cone_surface({.lower = 0, .upper = R, .height = h}, closed)) == 0);
    CHECK(open_edges(cone_surface({.lower = R, .height = h}, open)) == n);
    // A hopper with its outlet; a tube with a thick wall, which is a ring.
    const line hopper{{0.5, 0}, {R, h}, {R, 2 * h}};
    CHECK(open_edges(surface_of_revolution(hopper, open)) == 2 * n);
    CHECK(open_edges(surface_of_revolution(hopper, closed)) == 0);
    const line wall{{r, h}, {r, 0}, {R, 0}, {R, h}, {r, h}};
    CHECK(open_edges(surface_of_revolution(wall, open)) == 0);
    CHECK(open_edges(surface_of_revolution(wall, closed)) == 0);
    CHECK(enclosed(triangles_of_revolution(wall, closed)) ==
          doctest::Approx((polygon(n, R) - polygon(n, r)) * h));
  }
  // With many sectors the volumes are those of the smooth bodies.
  const revolution fine{.sectors = 2000, .closed = true};
  CHECK(enclosed(triangles_of_revolution({{2, 0}, {2, 3}}, fine)) ==
        doctest::Approx(12 * pi).epsilon(1e-5));
  line half_circle;
  for (int k = 0; k <= 400; ++k) {
    const real a = pi * k / 400 - pi / 2;
    half_circle.push_back({k % 400 == 0 ? 0 : std::cos(a), std::sin(a)});
  }
  CHECK(enclosed(triangles_of_revolution(half_circle, {.sectors = 400})) ==
        doctest::Approx(4 * pi / 3).epsilon(1e-4));
  CHECK(open_edges(surface_of_revolution(half_circle, {.sectors = 40})) == 0);
}

TEST_CASE("a tube stands on z = 0, holds bodies off from both sides, and may be a part of one") {
  const triangle_mesh tube = tube_surface({.radius = 2, .height = 5}, {.sectors = 128});
  CHECK((placed(tube).position - vec3(0, 0, 2.5)).norm() < 1e-12);
  const auto inside = contacts(tube, placed(tube), sphere{0.5}, {vec3(1.6, 0, 2), {1, 0, 0, 0}}, 0);
  REQUIRE(inside.size() > 0);
  CHECK(smallest(inside) == doctest::Approx(-0.1).epsilon(0.05));
  CHECK(inside[0].normal[0] < -0.99);
  const auto beside = contacts(tube, placed(tube), sphere{0.5}, {vec3(2.4, 0, 2), {1, 0, 0, 0}}, 0);
  REQUIRE(beside.size() > 0);
  CHECK(beside[0].normal[0] > 0.99);
  CHECK(contacts(tube, placed(tube), sphere{0.5}, {vec3(0, 0, 0), {1, 0, 0, 0}}, 0).empty());
  const triangle_mesh trough =
      tube_surface({.radius = 2, .height = 5}, {.sectors = 12, .from = -pi, .to = 0});
  CHECK(trough.triangles() == 24);
  CHECK(contacts(trough, placed(trough), sphere{0.5}, {vec3(0, 1.9, 2), {1, 0, 0, 0}}, 0).empty());
  CHECK(
      !contacts(trough, placed(trough), sphere{0.5}, {vec3(0, -1.9, 2), {1, 0, 0, 0}}, 0).empty());
}

TEST_CASE("a surface of revolution that makes no sense is refused with a sentence") {
  CHECK_THROWS_WITH(
      surface_of_revolution({{1, 0}}),
      "a surface of revolution needs a line of at least 2 points of radius and height, "
      "but got 1");
  CHECK_THROWS_WITH(surface_of_revolution({{1, 0}, {-1, 1}}),
                    "point 1 of a surface of revolution has the radius -1 and the height 1: the "
                    "radius must not be negative, and both must be finite");
  CHECK_THROWS_WITH(surface_of_revolution({{1, 0}, {1, 1}}, {.closed = true, .to = pi}),
                    "a surface of revolution is closed only where it goes around by 2 * pi, but it "
                    "goes from 0 to 3.141592653589793: leave out .closed, or .from and .to");
  CHECK_THROWS_WITH(surface_of_revolution({{1, 0}, {1, 1}}, {.sectors = 2}),
                    "a surface of revolution has from 3 to 1048576 sectors, but was given 2");
  CHECK_THROWS_WITH(
      surface_of_revolution({{1, 0}, {1, 1}}, {.from = 1, .to = 0.5}),
      "a surface of revolution goes from an angle to a larger one, by at most 2 * pi, "
      "but was given .from = 1 and .to = 0.5");
  CHECK_THROWS_WITH(
      tube_surface({.radius = 0}),
      "the radius of a tube must be positive and finite, but is 0; give a positive value");
  CHECK_THROWS_AS(cone_surface({.lower = 0, .upper = 0}), std::invalid_argument);
}
