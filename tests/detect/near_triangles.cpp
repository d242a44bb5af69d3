// Triangles kept near bodies: a body that moves over a surface meets what a search of the whole
// surface finds, in the same order.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <random>
#include <talus/detect/narrow.hpp>
#include <talus/mesh.hpp>
#include <talus/motion/integrate.hpp>
#include <talus/shape/box.hpp>
#include <vector>

#include "../landscape.hpp"

using namespace talus;

namespace {

triangle_mesh hills(int n, real phase) {
  return triangle_mesh(landscape(
      n, 10, [&](real x, real y) { return 0.3 * std::sin(x + phase) * std::cos(1.3 * y); }));
}
template <class Mesh, class Shape>
std::vector<contact_geometry> contacts(const Mesh& m, const pose& at, const Shape& s,
                                       const pose& there, real margin) {
  std::vector<contact_geometry> found;
  collide_pair(s, there, m, at, margin, [&](const contact_geometry& c) { found.push_back(c); });
  return found;
}
bool same(const std::vector<contact_geometry>& a, const std::vector<contact_geometry>& b) {
  bool equal = a.size() == b.size();
  for (std::size_t k = 0; equal && k < a.size(); ++k)
    equal = a[k].normal == b[k].normal && a[k].point == b[k].point && a[k].gap == b[k].gap &&
            a[k].feature == b[k].feature;
  return equal;
}

}  // namespace

TEST_CASE("contacts of kept triangles equal those of a whole search, bit for bit") {
  std::mt19937 random(7);
  std::uniform_real_distribution<real> uniform(-1, 1);
  const auto vector = [&](real scale) {
    return vec3(scale * uniform(random), scale * uniform(random), scale * uniform(random));
  };
  std::vector<triangle_mesh> surfaces;
  for (int k = 0; k < 6; ++k) surfaces.push_back(hills(5 + 4 * k, k));
  constexpr std::size_t bodies = 40;
  triangle_mesh::near_lists of_spheres, of_boxes;
  std::vector<vec3> places, ways;
  for (std::size_t i = 0; i < bodies; ++i) {
    places.push_back(vec3(4, 4, 0.3).cwiseProduct(vector(1)));
    ways.push_back(vector(0.02));
  }
  std::size_t met = 0;
  pose at{{0.1, 0.2, 0}, {1, 0, 0, 0}};
  for (int step = 0; step < 120; ++step) {
    at = pose{at.position + vector(0.01), detail::turned<real>(at.orientation, vector(0.01))};
    if (step == 60) surfaces[0] = hills(8, 0.5), surfaces.pop_back();
    for (std::size_t i = 0; i < bodies; ++i) {
      places[i] += ways[i];
      if (step % 30 == 0) std::swap(places[i], places[bodies - 1 - i]);
      const pose there{places[i], detail::turned<real>(quat(1, 0, 0, 0), vector(1))};
      const real size = 0.05 + 0.01 * static_cast<real>(i);
      for (std::size_t j = 0; j < surfaces.size(); ++j) {
        if ((i + j + static_cast<std::size_t>(step)) % 3 == 0) continue;
        const auto check = [&](const auto& shape, auto& lists) {
          const auto found =
              contacts(surfaces[j].near(lists, i, j, surfaces.size()), at, shape, there, 0.02);
          met += found.size();
          CHECK(same(found, contacts(surfaces[j], at, shape, there, 0.02)));
        };
        check(sphere{size}, of_spheres);
        if (i % 8 == 0) check(box{{size, 2 * size, 0.5 * size}}, of_boxes);
      }
    }
  }
  CHECK(met > 5000);
  CHECK(of_spheres.bytes() < 2000000);
}

TEST_CASE("a body over more triangles than are kept meets them all") {
  const triangle_mesh floor(landscape(60, 10, [](real, real) { return 0; }));
  triangle_mesh::near_lists lists;
  const pose at{}, there{{0.3, 0.2, 2.45}, {1, 0, 0, 0}};
  for (int k = 0; k < 2; ++k) {
    const auto found = contacts(floor.near(lists, 0, 0, 1), at, sphere{2.5}, there, 0);
    CHECK(found.size() == 1);
    CHECK(same(found, contacts(floor, at, sphere{2.5}, there, 0)));
  }
}
