// Every shape, sizes up to 1 : 10,000, and poses in which faces, edges or centres coincide.
#include <talus/mesh.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/ellipsoid.hpp>
#include <talus/shape/superellipsoid.hpp>

#include "family.hpp"

namespace fuzz {

namespace {

using two_parts = union_of<box, ellipsoid>;

/// Draws among the shapes of a list; spheres take the place of the others.
template <class Shapes>
struct drawn_shapes {
  static constexpr bool degenerate = true;
  template <class Shape>
  static constexpr bool has = detail::contains_type<Shapes, Shape>;

  /// Calls add(shape) for a shape within a ball of that radius about its centre of mass. One in ten
  /// is thin, to 1 : 10,000.
  template <class Add>
  static void add_shape(random_stream& r, real radius, Add&& add) {
    const vec3 ratios = r.uniform(vec3(0.2, 0.2, 0.2), vec3(1, 1, 1));
    vec3 size = r.integer(3) ? vec3(ratios * radius) : vec3(radius, radius, radius);
    if (r.integer(10) == 0)
      size[static_cast<int>(r.integer(3))] *= std::pow(10.0, -r.uniform(1, 4));
    const real n1 = r.uniform(2, 8), n2 = r.uniform(2, 8);
    const auto kind = r.integer(9);
    if (kind == 1) return add(box{1.15 * size});
    if (kind == 2) return add(ellipsoid{size});
    if constexpr (has<convex_polyhedron>)
      if (kind == 3) return add(polyhedron(r, size));
    if constexpr (has<capsule>)
      if (kind == 4) return add(capsule{0.4 * size[0], 1.1 * size[2]});
    if constexpr (has<cylinder>)
      if (kind == 5) return add(cylinder{0.65 * size[0], 1.4 * size[2]});
    if constexpr (has<superellipsoid>)
      if (kind == 6) return add(superellipsoid{0.57 * size, n1, n2});
    if constexpr (has<two_parts>) {
      if (kind == 7) return add(drop_and_brick(size));
      if (kind == 8) return add(angle(size));
    }
    add(sphere{radius});
  }
  static two_parts drop_and_brick(const vec3& size) {
    return two_parts(std::vector<two_parts::part>{
        {.shape = box{0.5 * size}, .at = {vec3(-0.3 * size[0], 0, 0), {1, 0, 0, 0}}},
        {.shape = ellipsoid{vec3(0.3, 0.4, 0.2).cwiseProduct(size)},
         .at = {vec3(0.35 * size[0], 0, 0), {1, 0, 0, 0}}}});
  }
  /// An L of two boxes: two of their faces meet inside it.
  static two_parts angle(const vec3& size) {
    return two_parts(std::vector<two_parts::part>{
        {.shape = box{vec3(0.7, 0.3, 0.4).cwiseProduct(size)}},
        {.shape = box{vec3(0.3, 0.5, 0.4).cwiseProduct(size)},
         .at = {vec3(0.2 * size[0], 0.4 * size[1], 0), {1, 0, 0, 0}}}});
  }
  /// A brick, an octahedron, a wedge, or the hull of random points.
  static convex_polyhedron polyhedron(random_stream& r, const vec3& size) {
    std::vector<vec3> points;
    const auto kind = r.integer(4);
    const auto add = [&](real x, real y, real z) {
      points.push_back(vec3(x, y, z).cwiseProduct(size));
    };
    if (kind < 2)
      for (const real x : {-0.5, 0.5})
        for (const real y : {-0.5, 0.5})
          for (const real z : {-0.5, 0.5})
            if (kind == 0 || x + z < 0.75) add(x, y, kind == 0 ? z : std::min(z, -x));
    if (kind == 2)
      for (const real s : {-0.9, 0.9}) add(s, 0, 0), add(0, s, 0), add(0, 0, s);
    if (kind == 3)
      for (int k = 0; k < 12; ++k) {
        const vec3 p = 0.45 * r.unit_vector();
        add(p[0], p[1], p[2]);
      }
    return convex_polyhedron(points);
  }

  /// A square block flush with the box of the floor, and a pyramid, of triangles.
  template <class Scope>
  static void add_walls(Scope& scope, material_id stuff, real floor) {
    if constexpr (has<triangle_mesh>) {
      const auto add = [&](const triangle_mesh& mesh, const vec3& at) {
        const pose p = placed(mesh);
        scope.add(mesh, stuff, p.position + at, p.orientation);
      };
      add(tube_surface({.radius = std::sqrt(0.5), .height = 0.3},
                       {.sectors = 4, .closed = true, .from = pi / 4, .to = 9 * pi / 4}),
          {1, 0, floor - 0.15});
      add(cone_surface({.lower = 0.5, .height = 0.15}, {.sectors = 6, .closed = true}),
          {-1.2, 0, floor});
    }
  }
};

}  // namespace

outcome run_shapes(const plan& p) {
#ifdef TALUS_FUZZ_ALL
  using shapes = bodies<sphere, box, capsule, cylinder, convex_polyhedron, ellipsoid,
                        superellipsoid, two_parts, triangle_mesh, plane>;
#else
  using shapes = bodies<sphere, box, ellipsoid, plane>;
#endif
  using scene = scenario<shapes, transport<threads>, decomposition<any_decomposition>,
                         features<energy_ledger>>;
  return run_family<scene, drawn_shapes<scene::shapes>>(p);
}

}  // namespace fuzz
