#pragma once
// Ground of triangles.
#include <talus/mesh.hpp>
#include <vector>

namespace {

/// A square of n by n cells from -size/2 to size/2 at the height f(x, y), two triangles each.
template <class F>
std::vector<talus::triangle_mesh::triangle> landscape(int n, talus::real size, F&& f) {
  using talus::real;
  std::vector<talus::triangle_mesh::triangle> all;
  const auto at = [&](int i, int j) {
    const real x = size * (real(i) / n - 0.5), y = size * (real(j) / n - 0.5);
    return talus::vec3(x, y, f(x, y));
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      all.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      all.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return all;
}

}  // namespace
