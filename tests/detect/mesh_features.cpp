// Contacts of a body with a surface of triangles are told apart by their features.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <talus/core/random.hpp>
#include <talus/detect/narrow.hpp>
#include <talus/mesh.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <vector>

using namespace talus;

namespace {

/// The number of contacts of two shapes, and how many of them have a feature that another has.
struct names {
  std::size_t all = 0, doubled = 0;
};
template <class Shape>
void count_names(const triangle_mesh& mesh, const Shape& shape, const pose& at, names& n) {
  std::vector<std::uint64_t> features;
  const auto note = [&](const contact_geometry& c) { features.push_back(c.feature); };
  collide_pair(mesh, pose{}, shape, at, 0.01, note);
  std::sort(features.begin(), features.end());
  n.all += features.size();
  for (std::size_t k = 1; k < features.size(); ++k) n.doubled += features[k] == features[k - 1];
}

}  // namespace

TEST_CASE("contacts of a body with triangles have different features, however it leans on edges") {
  const auto block = tube_surface({.radius = std::sqrt(0.5), .height = 0.3},
                                  {.sectors = 4, .closed = true, .from = pi / 4, .to = 9 * pi / 4});
  const triangle_mesh mesh = block;
  const pose own = placed(mesh);
  const std::uint64_t seed = 20261130;
  CAPTURE(seed);
  random_stream r(seed, 1);
  const std::vector<vec3> corners{{-0.2, -0.2, -0.2}, {0.2, -0.2, -0.2}, {0.2, 0.2, -0.2},
                                  {-0.2, 0.2, -0.2},  {-0.2, -0.2, 0.2}, {0.2, 0.2, 0.2}};
  names n;
  for (int k = 0; k < 20000; ++k) {
    const quat tilt = rotation(0.1 * r.unit_vector(), std::pow(10., -r.uniform(1, 9)));
    const quat turn = detail::after(tilt, r.integer(2) == 0 ? quat(1, 0, 0, 0) : r.rotation());
    const vec3 place = r.uniform(vec3(-0.9, -0.9, 0.1), vec3(0.9, 0.9, 0.55));
    const pose at{place - own.position, turn};
    count_names(mesh, box{{0.4, 0.4, 0.4}}, at, n);
    count_names(mesh, convex_polyhedron(corners), at, n);
    count_names(mesh, cylinder{0.2, 0.4}, at, n);
  }
  CHECK(n.all > 10000);
  CHECK(n.doubled == 0);
}
