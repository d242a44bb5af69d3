// The faces of a shape in pictures enclose it, and point outwards.
#include <doctest/doctest.h>

#include <map>
#include <talus/io/detail/shape_surface.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/triangle_mesh.hpp>
#include <utility>
#include <vector>

using namespace talus;

namespace {

/// Each edge runs once in each direction; the volume inside; no point outside the shape.
template <class Shape>
void check_closed(const Shape& shape, double part_of_volume) {
  CAPTURE(Shape::name);
  detail::surface_faces faces;
  add_surface(faces, shape);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::map<std::uint32_t, int> used;
  double volume = 0;
  std::uint32_t begin = 0;
  for (const std::uint32_t end : faces.ends) {
    REQUIRE(end >= begin + 3);
    for (std::uint32_t c = begin; c < end; ++c) {
      const std::uint32_t from = faces.corners[c], to = faces.corners[c + 1 < end ? c + 1 : begin];
      REQUIRE(from < faces.points.size());
      ++edges[{from, to}];
      ++used[from];
      volume +=
          faces.points[faces.corners[begin]].cross(faces.points[from]).dot(faces.points[to]) / 6;
    }
    begin = end;
  }
  CHECK(begin == faces.corners.size());
  CHECK(used.size() == faces.points.size());
  for (const auto& [edge, times] : edges) {
    CHECK(times == 1);
    CHECK(edges.contains({edge.second, edge.first}));
  }
  CHECK(volume > part_of_volume * shape.volume());
  CHECK(volume < 1.000001 * shape.volume());
  for (const vec3& p : faces.points)
    CHECK(p.norm() < 1.000001 * shape.support(p).dot(p) / p.norm());
}

}  // namespace

TEST_CASE("the faces of a shape close, look outwards and enclose its volume") {
  check_closed(box{{1, 2, 3}}, 0.999999);
  check_closed(cylinder{.radius = 0.5, .length = 2}, 0.97);
  check_closed(capsule{.radius = 0.5, .length = 2}, 0.95);
  check_closed(capsule{.radius = 0.5, .length = 1e-3}, 0.93);
  check_closed(convex_polyhedron(
                   std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.3, 0.4, 1}}),
               0.999999);
}

TEST_CASE("a wall of triangles keeps its triangles") {
  detail::surface_faces faces;
  add_surface(faces, triangle_mesh({{vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0)},
                                    {vec3(0, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0)}}));
  CHECK(faces.ends == std::vector<std::uint32_t>{3, 6});
  CHECK(faces.points.size() == 4);
}
