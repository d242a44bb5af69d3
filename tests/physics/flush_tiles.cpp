// Bodies keep their speed and height on closed meshes side by side, and on a plane, tilted or not,
// with a box in it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <talus/core/random.hpp>
#include <talus/mesh.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/ellipsoid.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

using clump = union_of<sphere>;
using scene =
    scenario<bodies<sphere, box, capsule, cylinder, ellipsoid, clump, triangle_mesh, plane>,
             transport<serial>>;
using world_type = world<scene>;

/// The surface of a block with these corners, turned by q.
void put_closed_mesh(world_type& w, const quat& q, const vec3& lower, const vec3& upper) {
  vec3 v[8];
  for (int k = 0; k < 8; ++k)
    v[k] = q * vec3(k & 1 ? upper[0] : lower[0], k & 2 ? upper[1] : lower[1],
                    k & 4 ? upper[2] : lower[2]);
  std::vector<triangle_mesh::triangle> all;
  for (const auto& [a, b, c, d] : {std::array{4, 5, 7, 6},
                                   {0, 2, 3, 1},
                                   {0, 1, 5, 4},
                                   {2, 6, 7, 3},
                                   {0, 4, 6, 2},
                                   {1, 3, 7, 5}})
    all.push_back({v[a], v[b], v[c]}), all.push_back({v[a], v[c], v[d]});
  const triangle_mesh mesh(all);
  const pose at = placed(mesh);
  w.global([&](auto& s) {
    s.add(
        body<triangle_mesh>{.shape = mesh, .position = at.position, .orientation = at.orientation});
  });
}

/// The largest change of velocity, over the speed, and of height. The body moves without friction
/// over the surface through the origin with the normal q z.
template <class Shape, class Floor>
real error_of(const quat& q, const Floor& put_floor, const Shape& shape, real height,
              const quat& turn, const vec3& along, real dt, int steps) {
  serial::link link;
  world_type w(link);
  w.gravity(q * vec3(0, 0, -9.81));
  w.material({.restitution = 0, .friction = 0});
  put_floor(w);
  const vec3 v = q * along, up = q * vec3(0, 0, 1);
  const auto one = w.add(body<Shape>{.shape = shape,
                                     .position = height * up - (0.5 * steps * dt) * v,
                                     .velocity = v,
                                     .orientation = q * turn});
  real error = 0;
  for (int k = 0; k < steps; ++k) {
    w.step(dt);
    error = std::max({error, (w[one].velocity() - v).norm() / v.norm(),
                      std::abs(w[one].position().dot(up) - height) / 0.06});
  }
  return error;
}

const quat level(1, 0, 0, 0);

}  // namespace

TEST_CASE("bodies keep speed and height on tiles that are closed meshes") {
  for (const quat& q : {level, rotation(vec3(1, 2, 0.5).normalized(), 0.37)})
    for (const real dt : {1.0 / 50, 1.0 / 500})
      for (const vec3& v : {vec3(1.3, 0.2, 0), vec3(0.03, -0.05, 0)}) {
        const auto tiles = [&](world_type& w) {
          for (int i = -4; i < 4; ++i)
            for (int j = -3; j < 3; ++j)
              put_closed_mesh(w, q, 0.07 * vec3(i, j + 0.2, -1), 0.07 * vec3(i + 1, j + 1.2, 0));
        };
        const auto check = [&](const auto& shape, real height, const quat& turn) {
          const int steps = static_cast<int>(std::min(0.15 / (v.norm() * dt), 300.0));
          return error_of(q, tiles, shape, height, turn, v, dt, steps);
        };
        CAPTURE(dt);
        CAPTURE(v[0]);
        const auto about = [](real angle) { return rotation({0, 0, 1}, angle); };
        const quat lying = about(0.7) * rotation({1, 0, 0}, pi / 2);
        CHECK(check(box{{0.06, 0.06, 0.06}}, 0.03, about(0.2)) < 1e-6);
        CHECK(check(box{{0.12, 0.05, 0.02}}, 0.01, about(0.9)) < 1e-6);
        CHECK(check(cylinder{0.03, 0.06}, 0.03, about(0.2)) < 1e-6);
        CHECK(check(cylinder{0.02, 0.05}, 0.02, lying) < 1e-6);
        CHECK(check(capsule{0.02, 0.05}, 0.02, lying) < 1e-6);
        CHECK(check(ellipsoid{{0.04, 0.03, 0.02}}, 0.02, level) < 1e-6);
        CHECK(check(sphere{0.03}, 0.03, level) < 1e-6);
        const clump two({{.shape = sphere{0.025}, .at = {{-0.02, 0, 0}}},
                         {.shape = sphere{0.025}, .at = {{0.02, 0, 0}}}});
        const clump three({{.shape = sphere{0.02}, .at = {{-0.03, 0, 0}}},
                           {.shape = sphere{0.02}, .at = {{0.03, 0, 0}}},
                           {.shape = sphere{0.02}, .at = {{0, 0.04, 0}}}});
        CHECK(check(two, 0.025, about(0.4)) < 1e-6);
        CHECK(check(three, 0.02, level) < 1e-6);
      }
}

TEST_CASE("bodies keep speed and height on closed plates far thinner than they are") {
  for (const real thickness : {1e-3, 1e-4, 1e-5})
    for (const real dt : {1.0 / 240, 1.0 / 1000})
      for (const vec3& v : {vec3(2, 0, 0), vec3(0.05, 0.015, 0)}) {
        const auto plates = [&](world_type& w) {
          put_closed_mesh(w, level, {-1, -1, -thickness}, {0.001, 1, 0});
          put_closed_mesh(w, level, {0.001, -1, -thickness}, {1, 1, 0});
        };
        const auto check = [&](const auto& shape, real height, const quat& turn) {
          const int steps = static_cast<int>(std::min(0.12 / (v.norm() * dt), 600.0));
          return error_of(level, plates, shape, height, turn, v, dt, steps);
        };
        CAPTURE(thickness);
        CAPTURE(dt);
        CAPTURE(v[0]);
        CHECK(check(box{{0.06, 0.06, 0.06}}, 0.03, level) < 1e-6);
        CHECK(check(box{{0.06, 0.06, 0.02}}, 0.01, rotation({0, 0, 1}, 0.4)) < 1e-6);
        CHECK(check(cylinder{0.03, 0.06}, 0.03, level) < 1e-6);
        CHECK(check(sphere{0.03}, 0.03, level) < 1e-6);
      }
}

TEST_CASE("a cylinder that rolls over tiles without slip keeps speed and height") {
  const real radius = 0.03, tile = 0.1;
  for (const bool meshes : {false, true})
    for (const real dt : {1.0 / 60, 1.0 / 240})
      for (const real speed : {0.05, 0.5, 2.0})
        for (const real angle : {0.0, 0.2}) {
          serial::link link;
          world_type w(link);
          w.gravity({0, 0, -9.81});
          w.material({.restitution = 0, .friction = 0.3});
          for (int i = -3; i < 3; ++i)
            for (int j = -2; j < 2; ++j)
              if (const vec3 low = tile * vec3(i, j + 0.3, -1); meshes)
                put_closed_mesh(w, level, low, low + vec3(tile, tile, tile));
              else
                w.global([&](auto& s) {
                  s.add(body<box>{.shape = box{{tile, tile, tile}},
                                  .position = low + 0.5 * vec3(tile, tile, tile)});
                });
          const vec3 along(std::cos(angle), std::sin(angle), 0), v = speed * along;
          const auto one = w.add(body<cylinder>{
              .shape = cylinder{radius, 0.055},
              .position = -0.12 * along + vec3(0, 0, radius),
              .velocity = v,
              .angular_velocity = vec3(0, 0, 1 / radius).cross(v),
              .orientation = rotation({0, 0, 1}, angle) * rotation({1, 0, 0}, pi / 2)});
          real error = 0;
          for (int k = 0; k < static_cast<int>(0.24 / (speed * dt)); ++k) {
            w.step(dt);
            error = std::max({error, (w[one].velocity() - v).norm() / speed,
                              std::abs(w[one].position()[2] - radius) / radius});
          }
          CAPTURE(meshes);
          CAPTURE(dt);
          CAPTURE(speed);
          CAPTURE(angle);
          CHECK(error < 1e-6);
        }
}

TEST_CASE("a cylinder whose ends lie on edges of tiles keeps speed, spin and height") {
  const real radius = 0.03, dt = 1.0 / 240;
  const vec3 x(1, 0, 0), z(0, 0, 1);
  enum kind { boxes, meshes, mixed };
  for (const kind below : {boxes, meshes, mixed})
    for (const real tile : {0.03, 0.06})
      for (const real shift : {0.0, 0.5})
        for (const real speed : {0.028, 0.06, 0.1186, 0.1386})
          for (const bool rolls : {false, true}) {
            serial::link link;
            world_type w(link);
            w.gravity(-9.81 * z);
            w.material({.restitution = 0, .friction = rolls ? 0.5 : 0.0});
            for (int i = -1; i < 1; ++i)
              for (int j = -4; j < 4; ++j) {
                const vec3 edges(0.24, tile, 0.06), low(0.24 * i, tile * (j + shift), -0.06);
                if (below == meshes || (below == mixed && (i + j) % 2 == 0))
                  put_closed_mesh(w, level, low, low + edges);
                else
                  w.global([&](auto& s) {
                    s.add(body<box>{.shape = box{edges}, .position = low + 0.5 * edges});
                  });
              }
            const vec3 v = speed * x, spin = rolls ? vec3(z.cross(v) / radius) : vec3(0, 0, 0);
            const int steps = static_cast<int>(0.6 * radius / (speed * dt)) + 4;
            const auto one = w.add(body<cylinder>{.shape = cylinder{radius, 0.06},
                                                  .position = radius * z - 0.5 * steps * dt * v,
                                                  .velocity = v,
                                                  .angular_velocity = spin,
                                                  .orientation = rotation(x, pi / 2)});
            real error = 0;
            for (int k = 0; k < steps; ++k) {
              w.step(dt);
              error = std::max({error, (w[one].velocity() - v).norm() / speed,
                                (w[one].angular_velocity() - spin).norm() * radius / speed,
                                std::abs(w[one].position()[2] - radius) / radius});
            }
            CAPTURE(static_cast<int>(below));
            CAPTURE(tile);
            CAPTURE(shift);
            CAPTURE(speed);
            CAPTURE(rolls);
            CHECK(error < 1e-6);
          }
}

TEST_CASE("a sphere keeps speed and height over a box in a plane, at any tilt") {
  constexpr std::uint64_t seed = 7;
  random_stream random(seed, 1);
  CAPTURE(seed);
  for (int k = 0; k < 40; ++k) {
    const vec3 axis = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
    const quat q = rotation(axis.normalized(), 3 * random.uniform());
    const auto floor = [&](world_type& w) {
      w.global([&](auto& s) {
        s.add(plane{.normal = q * vec3(0, 0, 1)}, {});
        s.add(body<box>{
            .shape = box{{0.4, 0.4, 0.1}}, .position = q * vec3(0.2, 0, -0.05), .orientation = q});
      });
    };
    CHECK(error_of(q, floor, sphere{0.03}, 0.03, level, {0.5, 0, 0}, 1.0 / 240, 60) < 1e-6);
    CHECK(error_of(q, floor, ellipsoid{{0.04, 0.03, 0.02}}, 0.02, level, {0.03, -0.05, 0},
                   1.0 / 1000, 400) < 1e-6);
  }
}
