// Soft contacts with walls: flat walls have no curvature, and bodies on several contact points are
// stable at a fifth of the critical time step.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <talus/detect/narrow.hpp>
#include <talus/interaction/stiffening.hpp>
#include <talus/mesh.hpp>
#include <talus/observe/critical_dt.hpp>
#include <talus/observe/force.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/triangle_mesh.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>
#include <utility>
#include <vector>

using namespace talus;

namespace {

constexpr real g = 9.81;

using linear = soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>;
using hertz = soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>;
using clump = union_of<sphere, box>;
template <class Law, class Integrator = semi_implicit_euler>
using walled =
    scenario<bodies<sphere, box, capsule, cylinder, convex_polyhedron, clump, triangle_mesh, plane>,
             Law, integrator<Integrator>, transport<serial>>;

/// A square in the plane z = 0, of n x n pairs of triangles.
triangle_mesh square(real side, int n) {
  std::vector<triangle_mesh::triangle> all;
  const auto at = [&](int i, int j) {
    return vec3(side * (i - 0.5 * n) / n, side * (j - 0.5 * n) / n, 0);
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      all.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      all.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return triangle_mesh(all);
}

convex_polyhedron cube_hull(real edge) {
  std::vector<vec3> corners;
  for (const real x : {-0.5, 0.5})
    for (const real y : {-0.5, 0.5})
      for (const real z : {-0.5, 0.5}) corners.emplace_back(x * edge, y * edge, z * edge);
  return convex_polyhedron(corners);
}

/// The force on a sphere at rest that overlaps a wall by `overlap`.
template <class AddWall>
real force_on_sphere(real radius, real overlap, AddWall&& add_wall,
                     const vec3& at = {0.03, -0.11, 0}) {
  serial::link link;
  world<walled<hertz>> w(link);
  w.material({.youngs_modulus = 1e7, .poisson_ratio = 0.3});
  add_wall(w);
  const auto ball =
      w.add(body{.shape = sphere{radius}, .position = at + vec3(0, 0, radius - overlap)});
  w.synchronize();
  return contact_force(w, ball)[2];
}

/// The largest height above z = 0 that a body reaches which is put down at `height` of its centre,
/// over its start, in units of its size.
template <class Law, class Integrator, class Shape, class AddWall>
real thrown_up(const Shape& shape, real height, AddWall&& add_wall) {
  serial::link link;
  world<walled<Law, Integrator>> w(link);
  w.gravity({0, 0, -g});
  w.material({.density = 1000,
              .restitution = 0.05,
              .friction = 0.5,
              .stiffness = 1e6,
              .youngs_modulus = 1e7,
              .poisson_ratio = 0.3});
  add_wall(w);
  const auto h = w.add(body{.shape = shape, .position = {0.013, 0.021, height}});
  const real dt = critical_dt(w) / 5, size = shape.bounding_radius();
  real highest = 0;
  const int steps = std::min(10'000, static_cast<int>(0.2 / dt));
  for (int k = 0; k < steps; ++k) {
    w.step(dt);
    highest = std::max(highest, w[h].position()[2] - height);
  }
  return highest / size;
}

}  // namespace

TEST_CASE("a flat wall of any shape repels a Hertzian sphere like a plane") {
  const real radius = 0.25, overlap = 1e-3;
  const real modulus = 1e7 / (1 - 0.09) / 2;
  const real right = 4. / 3 * modulus * std::sqrt(radius * overlap) * overlap;
  const auto global = [](const auto& shape, const vec3& at) {
    return [=](auto& w) { w.global([&](auto& scope) { scope.add(shape, material_id{}, at); }); };
  };
  const auto fixed = [](const auto& shape, const vec3& at) {
    return [=](auto& w) { w.add(body{.shape = shape, .position = at, .fixed = true}); };
  };
  const auto check = [&](const std::string& name, auto&& add_wall) {
    CAPTURE(name);
    CHECK(force_on_sphere(radius, overlap, add_wall) == doctest::Approx(right).epsilon(1e-9));
  };
  check("plane", [](auto& w) { w.global([](auto& scope) { scope.add(plane{}, {}); }); });
  for (const int n : {1, 7}) check("square", global(square(2, n), {0, 0, 0}));
  check("global box", global(box{{2, 2, 1}}, {0, 0, -0.5}));
  check("fixed box", fixed(box{{2, 2, 1}}, {0, 0, -0.5}));
  check("global hull", global(cube_hull(2), {0, 0, -1}));
  check("fixed hull", fixed(cube_hull(2), {0, 0, -1}));
  check("fixed mesh", fixed(square(2, 1), {0, 0, 0}));
}

TEST_CASE("a fine mesh repels a sphere beside its vertices and edges like a plane") {
  std::vector<triangle_mesh::triangle> wedges;  // with T-junctions, blunt corners and slivers
  for (int i = -4; i < 4; ++i) {
    const real x = 0.1 * i, right = x + 0.1;
    const vec3 a(x, -1, 0), b(right, -1, 0), c(right, 1, 0), d(x, 1, 0), m(right - 5e-5, 0, 0);
    for (const auto& t : {triangle_mesh::triangle{a, b, m}, {b, c, m}, {c, d, m}, {d, a, m}})
      wedges.push_back(t);
  }
  wedges.push_back({vec3(0.4, -1, 0), vec3(1, 0, 0), vec3(0.4, 0.1, 0)});
  wedges.push_back({vec3(0.4, 0.1, 0), vec3(1, 0, 0), vec3(0.4, 1, 0)});
  const auto put = [](const triangle_mesh& mesh) {
    return [=](auto& w) { w.global([&](auto& scope) { scope.add(mesh, material_id{}); }); };
  };
  const auto beside = [](real x, real side) {
    return [=](auto& w) {
      w.global([&](auto& s) { s.add(box{{side, 2, 1}}, {}, {x + side / 2, 0, -0.5}); });
    };
  };
  const auto tiles = [&](auto& w) {
    for (const real x : {-0.5, 0.0, 0.02}) beside(x, x < 0 ? 0.5 : x > 0 ? 0.5 : 0.02)(w);
  };
  const auto on_plane = [](auto& w) { w.global([](auto& s) { s.add(plane{}, {}); }); };
  for (const real radius : {0.003, 0.25}) {
    const real overlap = 1e-3 * radius, right = force_on_sphere(radius, overlap, on_plane);
    for (const real off : {0.0, 1e-16, 1e-12, 1e-10, 3e-9, 1e-8, 1e-7, 1e-6, 1e-4})
      for (const vec3& way : {vec3(1, 0, 0), vec3(0, 1, 0), vec3(-0.6, 0.8, 0)}) {
        CAPTURE(radius);
        CAPTURE(off);
        CAPTURE(way[0]);
        const auto check = [&](auto&& add_wall, const vec3& at) {
          CHECK(force_on_sphere(radius, overlap, add_wall, at + off * way) ==
                doctest::Approx(right).epsilon(1e-6));
        };
        check(put(square(2, 20)), {0, 0, 0});
        check(put(square(2, 20)), {0, 0.04, 0});
        check(put(square(2, 20)), {0.04, 0.04, 0});
        check(put(triangle_mesh(wedges)), {0.4, 0.1, 0});
        check(put(triangle_mesh(wedges)), {0, 0, 0});
        check(tiles, {0, 0.1, 0}), check(tiles, {0.02, 0, 0});
      }
  }
}

TEST_CASE("a sphere rolls over the triangles of a mesh as over a plane") {
  const auto rolled = [](auto&& add_wall) {
    serial::link link;
    world<walled<hertz>> w(link);
    const real r = 0.05, dt = 2e-4;
    w.gravity({0, 0, -g});
    w.material({.density = 1000,
                .restitution = 0.5,
                .friction = 0.5,
                .youngs_modulus = 1e6,
                .poisson_ratio = 0.3,
                .rolling_friction = 0.02});
    add_wall(w);
    const vec3 v(0.3, 0.4, 0);
    const auto ball = w.add(body{.shape = sphere{r},
                                 .position = {-0.1, 0.003, r},
                                 .velocity = v,
                                 .angular_velocity = vec3(0, 0, 1 / r).cross(v)});
    for (int k = 0; k < 2500; ++k) w.step(dt);
    return std::pair(w[ball].position(), vec3(r * w[ball].angular_velocity()));
  };
  const auto [right, spin] = rolled([](auto& w) { w.global([](auto& s) { s.add(plane{}, {}); }); });
  for (const int n : {1, 50, 200}) {
    CAPTURE(n);
    const auto [at, turn] =
        rolled([&](auto& w) { w.global([&](auto& s) { s.add(square(2, n), material_id{}); }); });
    CHECK((at - right).norm() < 1e-9);
    CHECK((turn - spin).norm() < 1e-9);
  }
}

TEST_CASE("bodies at rest on soft walls stay there at a fifth of the critical time step") {
  const auto on_plane = [](auto& w) { w.global([](auto& s) { s.add(plane{}, {}); }); };
  const auto on_triangles = [](int n) {
    return [n](auto& w) { w.global([&](auto& scope) { scope.add(square(4, n), material_id{}); }); };
  };
  const auto on_box = [](auto& w) {
    w.global([](auto& scope) { scope.add(box{{4, 4, 1}}, material_id{}, vec3(0, 0, -0.5)); });
  };
  const auto check = [&](const std::string& name, const auto& shape, real height) {
    CAPTURE(name);
    const auto over = [&](const std::string& wall, auto&& add_wall) {
      CAPTURE(wall);
      CHECK(thrown_up<linear, semi_implicit_euler>(shape, height, add_wall) < 1e-3);
      CHECK(thrown_up<linear, velocity_verlet>(shape, height, add_wall) < 1e-3);
      CHECK(thrown_up<hertz, velocity_verlet>(shape, height, add_wall) < 1e-3);
    };
    over("plane", on_plane);
    over("two triangles", on_triangles(1));
    over("fine mesh", on_triangles(40));
    over("box", on_box);
  };
  const real e = 0.3;
  check("cube", box{{e, e, e}}, e / 2);
  check("plate", box{{e, 2 * e, 0.1 * e}}, 0.05 * e);
  check("hull", cube_hull(e), e / 2);
  check("cylinder", cylinder{e / 2, e}, e / 2);
  check("clump",
        clump({{.shape = sphere{e / 2}, .at = {{-e / 3, 0, 0}, {1, 0, 0, 0}}},
               {.shape = sphere{e / 2}, .at = {{e / 3, 0, 0}, {1, 0, 0, 0}}}}),
        e / 2);
}

TEST_CASE("the corners of two faces on each other are counted") {
  std::vector<vec3> corners;
  for (int k = 0; k < 6; ++k)
    for (const real z : {-0.2, 0.2})
      corners.emplace_back(std::cos(k * pi / 3), std::sin(k * pi / 3), z);
  const convex_polyhedron prism(corners);
  const auto check = [](const auto& shape, real half, real turn, int expected) {
    int points = 0;
    collide_pair(shape, pose{{0, 0, half - 1e-4}, rotation({0, 0, 1}, turn)}, shape,
                 pose{{0, 0, -half}}, 1e-3, [&](const contact_geometry&) { ++points; });
    CHECK(points == expected);
    CHECK(points <= detail::most_contact_points(shape, detail::most_corners_of_face(shape)));
  };
  check(cube_hull(1), 0.5, pi / 4, 8);
  check(prism, 0.2, pi / 6, 12);
}

TEST_CASE("the critical time step is the least of those of the bodies, not of a mixture of them") {
  const auto step = [](bool ball, bool cube) {
    serial::link link;
    world<walled<linear>> w(link);
    w.material({.density = 1000, .restitution = 0.3, .friction = 0.5, .stiffness = 1e6});
    if (ball) w.add(body{.shape = sphere{0.01}});
    if (cube) w.add(body{.shape = box{{2, 2, 2}}, .position = {5, 0, 0}});
    return critical_dt(w, 0);
  };
  CHECK(step(true, true) == std::min(step(true, false), step(false, true)));
}
