// Faults that were reported of other engines, with solids of all kinds, meshes and moving floors:
// docs/validation/faults_elsewhere.md.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <talus/mesh.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/shape/union_of.hpp>
#include <vector>

#include "elsewhere.hpp"

using namespace talus;
using namespace talus::validation;

namespace {

using clump = union_of<box, capsule>;
using scene = elsewhere<
    scenario<bodies<sphere, box, cylinder, capsule, convex_polyhedron, clump, triangle_mesh, plane>,
             features<driven>, transport<serial>>>;
using triangles = std::vector<triangle_mesh::triangle>;

/// A floor of triangles, from x = -1 in `along` strips of that width and `across` ones of 1 m about
/// y = 0, that falls by `slope` along x.
void mesh_floor(scene& s, int along, int across, real width, real slope = 0) {
  triangles all;
  const auto corner = [&](int i, int j) {
    const real x = -1 + width * i;
    return vec3(std::cos(slope) * x, j - 0.5 * across, -std::sin(slope) * x);
  };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < across; ++j) {
      all.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
      all.push_back({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  const triangle_mesh mesh(all);
  const pose at = placed(mesh);
  (void)s.wall(mesh, at.position, at.orientation);
}
std::vector<vec3> corners_of_cube(const vec3& centre) {
  std::vector<vec3> all;
  for (int k = 0; k < 8; ++k)
    all.push_back(centre + vec3(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5));
  return all;
}
const quat upright{1, 0, 0, 0};

}  // namespace

// Masses.

TEST_CASE("three cubes above each other have the inertia of the box that they make") {
  std::vector<clump::part> parts;
  for (const real z : {-1., 0., 1.}) parts.push_back({.shape = box{{1, 1, 1}}, .at = {{0, 0, z}}});
  const clump tower(parts);
  vec3 i = 3 * tower.inertia();
  std::sort(i.data(), i.data() + 3);
  check_absolute("parry #334", "least moment of inertia, kg m^2", 0.5, i[0], 1e-12);
  check_absolute("parry #334", "largest moment of inertia, kg m^2", 2.5, i[2], 1e-12);
}

TEST_CASE("the inertia of a hull does not depend on where its points are") {
  const convex_polyhedron cube(corners_of_cube({3, -2, 5}));
  check_absolute("newton-dynamics #22", "least moment of inertia, kg m^2", 1.0 / 6,
                 cube.inertia().minCoeff(), 1e-12);
  check_absolute("newton-dynamics #22", "largest moment of inertia, kg m^2", 1.0 / 6,
                 cube.inertia().maxCoeff(), 1e-12);
}

TEST_CASE("the mass of a hull is that of the hull, not of the points given") {
  std::vector<vec3> points = corners_of_cube({0, 0, 0});
  for (const real x : {-0.3, 0., 0.2}) points.push_back({x, 0.4 * x, 0.1});  // inside
  for (const vec3& p : corners_of_cube({0, 0, 0})) points.push_back(0.5 * p);
  const convex_polyhedron cube(points);
  check_absolute("mujoco #2152", "volume, m^3", 1, cube.volume(), 1e-12);
  check_absolute("mujoco #2152", "largest moment of inertia per mass, m^2", 1.0 / 6,
                 cube.inertia().maxCoeff(), 1e-12);
}

TEST_CASE("the inertia of a rotated part is that of the part") {
  const vec3 size(1, 2, 0.3);
  const clump one(std::vector<clump::part>{
      {.shape = box{size}, .at = {{1, 2, 3}, rotation(vec3(1, 2, 3), 0.7)}}});
  vec3 i = one.inertia(), expected = box{size}.inertia();
  std::sort(i.data(), i.data() + 3), std::sort(expected.data(), expected.data() + 3);
  check_absolute("godot #7426", "largest error of a moment per mass, m^2", 0, (i - expected).norm(),
                 1e-12);
}

TEST_CASE("a capsule whose origin is not its centre of mass falls over") {
  scene s({.friction = 0.5});
  const clump stick(std::vector<clump::part>{
      {.shape = capsule{.radius = 0.25, .length = 0.5}, .at = {{0, 0, 0.5}}}});
  const pose at = placed(stick, {{0, 0, 0}, rotation(vec3::UnitY(), 3 * degree)});
  const auto h = s.floor().add(stick, at.position, {0, 0, 0}, at.orientation);
  s.run(4);
  check_absolute("avian #108", "height of the centre at the end, m", 0.25, s.w[h].position()[2],
                 1e-3);
}

// Meshes and seams.

TEST_CASE("a ball rolls straight down a ramp of six triangles") {
  const real slope = 20 * degree;
  scene s({.friction = 0.5});
  mesh_floor(s, 3, 1, 3, slope);
  const auto h = s.add(sphere{0.3}, 0.3 * vec3(std::sin(slope), 0, std::cos(slope)));
  s.run(1.8);
  check_absolute("rapier #95", "drift across the ramp, m", 0, s.w[h].position()[1], 1e-6);
  check_absolute("rapier #95", "acceleration, m/s^2", 5.0 / 7 * earth * std::sin(slope),
                 down(s.w[h].velocity(), slope) / 1.8, 1e-4);
}

TEST_CASE("a ball does not jump where it rolls over an edge inside a floor") {
  scene s({.restitution = 0.5, .friction = 0.5});
  mesh_floor(s, 12, 1, 1);
  const auto h = s.add(sphere{0.5}, {0, 0.1, 0.5}, {3, 0, 0}, upright, {0, 6, 0});
  check_absolute("JoltPhysics #1155", "largest change of the height, m", 0,
                 s.most(3, [&] { return std::abs(s.w[h].position()[2] - 0.5); }), 1e-9);
}

TEST_CASE("a ball rolls over the edges of a mesh at constant speed") {
  scene s({.restitution = 0, .friction = 0.5});
  mesh_floor(s, 40, 2, 0.3);
  const auto h = s.add(sphere{0.5}, {0, 0.1, 0.5}, {3, 0, 0}, upright, {0, 6, 0});
  s.run(3);
  check_absolute("bullet3 #92", "velocity after 3 s, m/s", 3, s.w[h].velocity()[0], 1e-6);
}

TEST_CASE("a box does not get stuck on a dense flat mesh") {
  scene s({.friction = 0.1});
  mesh_floor(s, 60, 4, 0.25);
  const auto h = s.add(box{{0.5, 0.5, 0.5}}, {0, 0.1, 0.25}, {4, 0, 0});
  s.run(2);
  check_absolute("godot #102544", "velocity after 2 s, m/s", 4 - 2 * 0.1 * earth,
                 s.w[h].velocity()[0], 1e-2);
}

TEST_CASE("a cylinder slides over a flat mesh without a jump") {
  scene s({.restitution = 0.5, .friction = 0});
  mesh_floor(s, 20, 4, 0.5);
  const auto h = s.add(cylinder{.radius = 0.3, .length = 0.4}, {0, 0.1, 0.2}, {3, 0, 0});
  check_absolute("ammo.js #383", "largest change of the height, m", 0,
                 s.most(2, [&] { return std::abs(s.w[h].position()[2] - 0.2); }), 1e-5);
  check_absolute("ammo.js #383", "velocity after 2 s, m/s", 3, s.w[h].velocity()[0], 1e-4);
}

TEST_CASE("a box slides over flush cuboids at constant speed") {
  scene s({.restitution = 0.5, .friction = 0});
  for (int k = 0; k < 10; ++k) (void)s.wall(box{{1, 2, 0.5}}, {real(k), 0, -0.25});
  const auto h = s.add(box{{0.6, 0.6, 0.6}}, {0, 0, 0.3}, {3, 0, 0});
  s.run(2.5);
  check_absolute("avian #612", "velocity after 2.5 s, m/s", 3, s.w[h].velocity()[0], 1e-6);
}

// Cylinders, capsules, polyhedra.

TEST_CASE("a cylinder lies and stands on a plane at the right height") {
  scene s({.friction = 0.5});
  s.floor();
  const cylinder c{.radius = 0.3, .length = 1};
  const auto stands = s.add(c, {0, 0, 0.5});
  const auto lies = s.add(c, {3, 0, 0.3}, {0, 0, 0}, rotation(vec3::UnitX(), pi / 2));
  s.run(2);
  check_absolute("newton #826", "height of the standing one, m", 0.5, s.w[stands].position()[2],
                 1e-6);
  check_absolute("newton #826", "height of the lying one, m", 0.3, s.w[lies].position()[2], 1e-6);
}

TEST_CASE("a cylinder that stands on its end does not creep") {
  scene s({.density = 1000, .friction = 0.5}, earth, 0.005);
  const auto h = s.floor().add(cylinder{.radius = 0.02, .length = 0.06}, {0, 0, 0.03});
  s.run(10);
  const vec3 x = s.w[h].position();
  check_absolute("genesis-world #3245", "way across the floor in 10 s, m", 0,
                 std::hypot(x[0], x[1]), 1e-6);
}

TEST_CASE("a slender cylinder that stands on its end does not twitch") {
  scene s({.friction = 0.5});
  const auto h = s.floor().add(cylinder{.radius = 0.05, .length = 1}, {0, 0, 0.5});
  s.run(1);
  check_absolute("NTRTsim #216", "largest angular velocity in the second to fifth second, rad/s", 0,
                 s.most(4, [&] { return s.w[h].angular_velocity().norm(); }), 1e-5);
  check_absolute("NTRTsim #216", "tilt after 5 s, rad", 0,
                 std::acos(std::min<real>(1, rotated(s.w[h].orientation(), vec3::UnitZ())[2])),
                 1e-6);
}

TEST_CASE("a pushed capsule ends up rolling without slip") {
  scene s({.friction = 0.3});
  const capsule c{.radius = 0.5, .length = 1};
  // Its axis is z: it lies along y.
  const auto h = s.floor().add(c, {0, 0, 0.5}, {3, 0, 0}, rotation(vec3::UnitX(), pi / 2));
  s.run(2);
  const real k = c.inertia()[2] / 0.25;
  check_absolute("brax #78", "velocity, m/s", 3 / (1 + k), s.w[h].velocity()[0], 1e-6);
  check_absolute("brax #78", "slip, m/s", 0,
                 s.w[h].velocity()[0] - 0.5 * s.w[h].angular_velocity()[1], 1e-9);
}

TEST_CASE("a tetrahedron that is thrown over a floor does not sink into it") {
  const convex_polyhedron body({{1, 0, -0.4}, {-0.6, 0.9, -0.4}, {-0.6, -0.9, -0.4}, {0, 0, 0.9}});
  scene s({.friction = 0.3});
  const auto h =
      s.floor().add(body, {0, 0, 1.5}, {10, 2, 0}, rotation(vec3(1, 2, 3), 1), {3, 1, 2});
  check_absolute("siconos #106", "largest depth of a corner in 5 s, m", 0,
                 s.most(5,
                        [&] {
                          real depth = 0;
                          for (const vec3& v : body.vertices())
                            depth =
                                std::max(depth, -(s.w[h].position() + s.w[h].orientation() * v)[2]);
                          return depth;
                        }),
                 1e-2);
}

// Moving floors.

TEST_CASE("a platform that starts to move carries a box after V / (mu g)") {
  scene s({.friction = 0.5}, earth, 1e-3);
  const auto deck = s.wall(box{{20, 20, 1}}, {0, 0, -0.5});
  const auto h = s.add(box{{1, 1, 0.2}}, {0, 0, 0.1});
  s.w.drive(deck, gliding{{1, 0, 0}});
  s.run(1);
  check_absolute("phy #13", "velocity, m/s", 1, s.w[h].velocity()[0], 1e-9);
  check_absolute("phy #13", "way behind the platform, m", 1 / (2 * 0.5 * earth),
                 1 - s.w[h].position()[0], 2e-3);
}

TEST_CASE("a box follows a platform that reverses") {
  scene s({.friction = 0.5}, earth, 1e-3);
  const auto deck = s.wall(box{{20, 20, 1}}, {0, 0, -0.5});
  const oscillation motion{.amplitude = {0.1, 0, 0}, .frequency = 1, .phase = pi / 2};
  const auto h = s.add(box{{1, 1, 0.2}}, {0, 0, 0.1});
  s.w.drive(deck, motion);
  check_absolute(
      "box2d #117", "largest way on the platform in 10 s, m", 0,
      s.most(10, [&] { return std::abs(s.w[h].position()[0] - motion(s.w.time()).shift[0]); }),
      1e-3);
}

TEST_CASE("a ball on a moving platform rolls with 2/7 of its velocity") {
  scene s({.friction = 0.5}, earth, 1e-3);
  const auto deck = s.wall(box{{20, 20, 1}}, {0, 0, -0.5});
  const auto h = s.add(sphere{0.5}, {0, 0, 0.5});
  s.w.drive(deck, gliding{{1, 0, 0}});
  s.run(1);
  check_absolute("cannon.js #327", "velocity, m/s", 2.0 / 7, s.w[h].velocity()[0], 1e-9);
}

TEST_CASE("a turntable carries a box along its circle") {
  scene s({.friction = 0.5}, earth, 1e-3);
  const auto deck = s.wall(box{{4, 4, 1}}, {0, 0, -0.5});
  const auto h = s.add(box{{0.2, 0.2, 0.2}}, {0.5, 0, 0.1}, {0, 1, 0}, {1, 0, 0, 0}, {0, 0, 1});
  s.w.drive(deck, turning{.speed = 1});
  s.run(20);
  check_absolute("FUDGE #340", "distance from its place on the table after 20 s, m", 0,
                 (s.w[h].position() - vec3(0.5 * std::cos(20.), 0.5 * std::sin(20.), 0.1)).norm(),
                 0.03);
}
