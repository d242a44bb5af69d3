#pragma once
// Floors of fixed bodies that lie flush beside each other, and what slides over them.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/mesh.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>

namespace {

using namespace talus;

template <class World>
void put_box(World& w, const vec3& size, const vec3& at, bool fixed = false) {
  if (fixed)
    w.add_if_local(body<box>{.shape = box{size}, .position = at, .fixed = true});
  else
    w.global([&](auto& scope) { scope.add(body<box>{.shape = box{size}, .position = at}); });
}
/// A mesh of two triangles at the height 0, from x0 to x1.
template <class World>
void put_rectangle(World& w, real x0, real x1) {
  const vec3 a(x0, -1, 0), b(x1, -1, 0), c(x1, 1, 0), d(x0, 1, 0);
  const triangle_mesh m({{a, b, c}, {a, c, d}});
  const pose at = placed(m);
  w.global([&](auto& scope) {
    scope.add(
        body<triangle_mesh>{.shape = m, .position = at.position, .orientation = at.orientation});
  });
}

template <class World>
void without_friction(World& w) {
  w.gravity({0, 0, -9.81});
  w.material({.restitution = 0, .friction = 0});
}
/// Four tiles of boxes, which meet at the origin; fixed ones are bodies of their ranks.
template <class World>
void put_tiles(World& w, bool fixed) {
  for (const real x : {-0.25, 0.25})
    for (const real y : {-0.5, 0.5}) put_box(w, {0.5, 1, 0.2}, {x, y, -0.1}, fixed);
}
/// A mesh on either side of them.
template <class World>
void put_rims(World& w) {
  put_rectangle(w, 0.5, 1.5), put_rectangle(w, -1.5, -0.5);
}
/// Rows of cubes and spheres that slide against each other, and are over the seam x = 0 after 0.3.
template <class World>
void put_sliders(World& w) {
  for (int k = 0; k < 8; ++k) {
    const real y = -0.7 + 0.2 * k;
    w.add_if_local(body{.shape = box{{0.06, 0.06, 0.06}},
                        .position = {-0.3 + 0.01 * k, y, 0.03},
                        .velocity = {1, 0.1, 0}});
    w.add_if_local(body{.shape = sphere{0.03},
                        .position = {0.3 - 0.01 * k, y + 0.1, 0.03},
                        .velocity = {-1, 0.1, 0}});
  }
}
/// The sliders of this rank keep their velocity and, relative to their size, their height.
template <class World>
void check_sliders(World& w, real within) {
  w.for_each_local([&](const auto& b) {
    if (b.is_fixed()) return;
    const real ahead = b.velocity()[0] > 0 ? 1 : -1;
    CHECK((b.velocity() - vec3(ahead, 0.1, 0)).norm() < within);
    CHECK(std::abs(b.position()[2] - 0.03) < within * 0.06);
  });
}

}  // namespace
