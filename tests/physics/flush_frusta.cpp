// Floors of solids that grow narrower downwards and share the edges of their upper faces: frusta
// as hulls and as closed meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <talus/mesh.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

using scene =
    scenario<bodies<sphere, box, capsule, cylinder, convex_polyhedron, triangle_mesh, plane>,
             transport<serial>>;
using world_type = world<scene>;

const quat level(1, 0, 0, 0);

quat about(real angle) { return rotation({0, 0, 1}, angle); }

template <class Shape>
void put(world_type& w, const Shape& shape, const pose& at) {
  w.global([&](auto& s) {
    s.add(body<Shape>{.shape = shape, .position = at.position, .orientation = at.orientation});
  });
}
/// A frustum below a rectangle at the height 0, whose lower face is smaller by the factor `taper`.
void put_frustum(world_type& w, real x0, real x1, real y0, real y1, real taper, bool as_mesh) {
  const vec3 middle(0.5 * (x0 + x1), 0.5 * (y0 + y1), -0.3);
  std::vector<vec3> v;
  for (const real z : {0.0, -0.3})
    for (const real y : {y0, y1})
      for (const real x : {x0, x1}) {
        const vec3 above(x, y, 0), to = above - vec3(middle[0], middle[1], 0);
        v.push_back(z == 0 ? above : vec3(middle + taper * to));
      }
  if (!as_mesh) {
    const convex_polyhedron hull(v);
    return put(w, hull, placed(hull));
  }
  std::vector<triangle_mesh::triangle> all;
  for (const auto& [a, b, c, d] : {std::array{0, 1, 3, 2},
                                   {4, 6, 7, 5},
                                   {0, 4, 5, 1},
                                   {1, 5, 7, 3},
                                   {3, 7, 6, 2},
                                   {2, 6, 4, 0}})
    all.push_back({v[a], v[b], v[c]}), all.push_back({v[a], v[c], v[d]});
  const triangle_mesh mesh(all);
  put(w, mesh, placed(mesh));
}
void put_tiles(world_type& w, real taper, bool as_mesh) {
  for (int i = -2; i < 2; ++i)
    for (int j = -2; j < 2; ++j)
      put_frustum(w, 0.25 * i, 0.25 * (i + 1), 0.25 * j, 0.25 * (j + 1), taper, as_mesh);
}
/// The largest change of velocity, over the speed, and of height, over 0.06.
template <class Shape>
real error_on_tiles(const Shape& shape, real height, const quat& turn, const vec3& from, real taper,
                    bool as_mesh, real dt) {
  serial::link link;
  world_type w(link);
  w.gravity({0, 0, -9.81});
  w.material({.restitution = 0, .friction = 0});
  put_tiles(w, taper, as_mesh);
  const vec3 v(1, 0.1, 0);
  const auto one =
      w.add(body<Shape>{.shape = shape, .position = from, .velocity = v, .orientation = turn});
  real error = 0;
  for (int k = 0; k < static_cast<int>(0.6 / dt); ++k) {
    w.step(dt);
    error = std::max({error, (w[one].velocity() - v).norm() / v.norm(),
                      std::abs(w[one].position()[2] - height) / 0.06});
  }
  return error;
}

}  // namespace

TEST_CASE("bodies keep speed and height over tiles that grow narrower downwards") {
  const std::vector<vec3> wedge{{-0.03, -0.03, -0.02}, {0.03, -0.03, -0.02}, {0.03, 0.03, -0.02},
                                {-0.03, 0.03, -0.02},  {-0.03, 0, 0.04},     {0.03, 0, 0.04}};
  for (const bool as_mesh : {false, true})
    for (const real taper : {0.05, 0.5, 0.9, 1.0})
      for (const real angle : {0.0, 0.3, 0.785, 1.05})
        // Over seams, and over corners at the very steps.
        for (const real y : {0.013, 0.15, -0.21}) {
          CAPTURE(as_mesh);
          CAPTURE(taper);
          CAPTURE(angle);
          CAPTURE(y);
          const auto check = [&](const auto& shape, real height, const quat& turn) {
            return error_on_tiles(shape, height, turn, {-0.3, y, height}, taper, as_mesh,
                                  1.0 / 240);
          };
          const quat turn = about(angle), lying = turn * rotation({1, 0, 0}, pi / 2);
          // Contacts of curved bodies with triangles are tilted by 1e-7.
          const real curved = as_mesh ? 1e-5 : 1e-6;
          CHECK(check(box{{0.06, 0.06, 0.06}}, 0.03, turn) < 1e-6);
          CHECK(check(box{{0.12, 0.09, 0.06}}, 0.03, turn) < 1e-6);
          CHECK(check(cylinder{0.03, 0.06}, 0.03, turn) < curved);
          CHECK(check(cylinder{0.03, 0.12}, 0.03, lying) < curved);
          CHECK(check(capsule{0.03, 0.12}, 0.03, lying) < curved);
          CHECK(check(sphere{0.03}, 0.03, turn) < curved);
          const convex_polyhedron hull(wedge);
          const pose at = placed(hull);
          CHECK(check(hull, 0.02 + at.position[2], quat(turn * at.orientation)) < 1e-6);
        }
}

TEST_CASE("walls, ramps and steps on such tiles act on what slides against them") {
  const auto run = [](auto&& put_more, const vec3& gravity, const pose& at, const vec3& v,
                      real time, real dt) {
    serial::link link;
    world_type w(link);
    w.gravity(gravity);
    w.material({.restitution = 0, .friction = 0});
    put_more(w);
    const auto cube = w.add(body{.shape = box{{0.06, 0.06, 0.06}},
                                 .position = at.position,
                                 .velocity = v,
                                 .orientation = at.orientation});
    for (int k = 0; k < static_cast<int>(time / dt); ++k) w.step(dt);
    return std::pair(w[cube].position(), w[cube].velocity());
  };
  for (const bool as_mesh : {false, true})
    for (const real dt : {1.0 / 240, 1.0 / 60}) {
      CAPTURE(as_mesh);
      CAPTURE(dt);
      const auto stops_at = [&](real x, auto&& put_more) {
        const auto [p, v] =
            run(put_more, {8, 0, -9.81}, {.position = {-0.1, 0.1, 0.03}}, {1, 0, 0}, 2, dt);
        CHECK((p - vec3(x - 0.03, 0.1, 0.03)).norm() < 1e-4);  // upright
        CHECK(v.norm() < 1e-3);
      };
      stops_at(0.1, [&](world_type& w) {  // a wall on a tile
        put_tiles(w, 0.5, as_mesh);
        put(w, box{{0.2, 2, 1}}, {.position = {0.2, 0, 0.5}});
      });
      stops_at(0.25, [&](world_type& w) {  // one over a seam, partly in the tiles
        put_tiles(w, 0.5, as_mesh);
        put(w, box{{0.2, 2, 1}}, {.position = {0.35, 0, 0.1}});
      });
      stops_at(0.2, [&](world_type& w) {  // one that leans away from the cube, on its edge
        put_tiles(w, 0.5, as_mesh);
        std::vector<vec3> v;
        for (const real y : {-1, 1})
          for (const vec3& c :
               {vec3(0.2, y, 0), vec3(0.4, y, 0), vec3(0.2, y, 0.5), vec3(0.8, y, 0.5)})
            v.push_back(c);
        const convex_polyhedron hull(v);
        put(w, hull, placed(hull));
      });
      stops_at(0, [&](world_type& w) {  // a tile that is higher by half the cube
        put_frustum(w, -0.5, 0, -0.5, 0.5, 0.5, as_mesh);
        put_frustum(w, 0, 0.5, -0.5, 0.5, 0.5, as_mesh);
        put(w, box{{0.5, 1, 0.1}}, {.position = {0.25, 0, -0.01}});
      });
      // Down a ramp of 30 degrees, whose foot is on the seam: the cube tilts onto the floor there.
      const real sine = std::sin(pi / 6), cosine = std::cos(pi / 6);
      const quat tilt = rotation({0, 1, 0}, pi / 6);
      const auto [p, v] = run(
          [&](world_type& w) {
            put_tiles(w, 0.5, as_mesh);
            put(w, box{{1, 1, 0.2}}, {.position = tilt * vec3(-0.5, 0, -0.1), .orientation = tilt});
          },
          {0, 0, -9.81}, {.position = tilt * vec3(-0.2, 0.1, 0.03), .orientation = tilt}, {0, 0, 0},
          0.5, dt);
      const real fallen = (0.2 - 0.03) * sine;
      CHECK(p[0] > 0.05);
      CHECK(std::abs(p[2] - 0.03) < 0.01);
      // The impact on the floor leaves less than the fall gives, and more than half of what a slide
      // through the corner would.
      CHECK(v[0] < std::sqrt(2 * 9.81 * fallen));
      CHECK(v[0] > 0.5 * cosine * std::sqrt(2 * 9.81 * fallen));
    }
}
