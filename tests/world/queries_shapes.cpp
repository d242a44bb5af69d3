// Queries of bodies of every shape, on 1, 2 and 4 ranks, against brute force over all bodies.
// timeout: 300
// alone
#include <array>
#include <string>
#include <talus/mesh.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/talus.hpp>

#include "../../examples/own_shape/lens.hpp"
#include "query_check.hpp"

using namespace talus;

namespace {

using clump = union_of<sphere, box>;
using scene = scenario<bodies<sphere, box, capsule, cylinder, convex_polyhedron, ellipsoid, clump,
                              lens, triangle_mesh, plane>,
                       hard_contact<>, decomposition<grid<dynamic, dynamic>>>;

template <class World>
void fill(World& w) {
  const auto stuff = w.material({});
  generator random;
  const convex_polyhedron wedge(
      std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.2, 1}, {1, 1, 0.5}});
  const clump two({{.shape = box{{0.8, 0.5, 0.3}}, .at = {{0.3, 0, 0}, random.turn()}},
                   {.shape = sphere{0.3}, .at = {{-0.4, 0, 0.2}, {1, 0, 0, 0}}}});
  const auto hills = [](real x0, real y0) {
    std::vector<triangle_mesh::triangle> all;
    const auto p = [&](int i, int j) {
      return vec3(x0 + i, y0 + j, -2 + 0.4 * std::sin(1.3 * i + j));
    };
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        all.push_back({p(i, j), p(i + 1, j), p(i + 1, j + 1)});
        all.push_back({p(i, j), p(i + 1, j + 1), p(i, j + 1)});
      }
    return triangle_mesh(all);
  };
  const triangle_mesh valley = hills(-6, -6), hill = hills(0, -3);
  w.global([&](auto& all) {
    all.add(plane{{0, 0, 1}, -4}, stuff);
    all.add(plane{{1, 0, 0.1}, -9}, stuff);
    const pose at = placed(valley);
    all.add(body<triangle_mesh>{.shape = valley,
                                .position = at.position,
                                .material = stuff,
                                .orientation = at.orientation});
    all.add(body<box>{.shape = box{{1, 1, 3}}, .position = {7, 7, 0}, .material = stuff});
  });
  const pose at = placed(hill);
  w.add_if_local(body<triangle_mesh>{.shape = hill,
                                     .position = at.position,
                                     .material = stuff,
                                     .orientation = at.orientation,
                                     .fixed = true});
  for (int k = 0; k < 160; ++k) {
    const vec3 p = random.point(vec3(6, 6, 3));
    const quat turn = random.turn();
    const auto add = [&](const auto& shape) {
      w.add_if_local(body<std::remove_cvref_t<decltype(shape)>>{.shape = shape,
                                                                .position = p,
                                                                .material = stuff,
                                                                .orientation = turn,
                                                                .fixed = k % 5 == 0});
    };
    const real size = random(0.2, 0.6);
    switch (k % 8) {
      case 0:
        add(sphere{size});
        break;
      case 1:
        add(box{{size, 2 * size, 0.3}});
        break;
      case 2:
        add(capsule{0.2, size});
        break;
      case 3:
        add(cylinder{0.3, size});
        break;
      case 4:
        add(wedge);
        break;
      case 5:
        add(ellipsoid{{0.2, size, 0.4}});
        break;
      case 6:
        add(two);
        break;
      default:
        add(lens{.radius = size, .thickness = 0.2});
        break;
    }
  }
}

template <class Program>
void on_ranks(Program&& program) {
  for (const auto& [x, y] : {std::pair{1, 1}, {2, 1}, {2, 2}}) {
    CAPTURE(x * y);
    threads::launch({.ranks = x * y}, [&, x = x, y = y](threads::link& link) {
      world<scene> w(link,
                     grid<dynamic, dynamic>{.cells = {x, y}, .lower = {-8, -8}, .upper = {8, 8}});
      fill(w);
      program(w);
    });
  }
}

}  // namespace

TEST_CASE(
    "rays, moving shapes, nearest bodies, overlaps: as brute force on any ranks, of all shapes") {
  on_ranks([&](auto& w) {
    generator random;
    std::vector<ray> rays;
    std::vector<shape_path> paths;
    std::vector<pose> poses;
    std::vector<vec3> points;
    for (int k = 0; k < 240; ++k) {
      const vec3 from = random.point(vec3(8, 8, 4)), d = random(0.1, 9) * random.direction();
      rays.push_back({.from = from, .direction = d, .length = k % 3 == 0 ? 5 : detail::endless});
      paths.push_back({.from = from, .direction = d, .length = 20, .orientation = random.turn()});
      poses.push_back({from, random.turn()});
      points.push_back(from);
    }
    std::array<bool, 10> seen{};
    const auto compare = [&](const char* what, const std::vector<std::vector<query_hit>>& mine,
                             std::size_t count, bool single, auto&& look) {
      for (std::size_t k = 0; k < count; ++k) {
        auto expected = by_brute_force(
            w, 0, [&](const auto& s, const pose& at, const vec3&) { return look(k, s, at); });
        if (single && expected.size() > 1) expected.resize(1);
        std::size_t n = 0;
        if (!is_mine(w, k, n)) continue;
        auto found = mine[n];
        std::sort(found.begin(), found.end());
        CAPTURE(what);
        CAPTURE(k);
        check_alike(found, expected, 0);
        for (const query_hit& hit : found) {
          seen[static_cast<std::size_t>(hit.kind)] = true;
          CHECK(std::string(shape_name(w, hit)) != "");
          CHECK(handle_of<sphere>(w, hit).has_value() == (hit.kind == 0));
        }
      }
    };
    const auto one_each = [](const std::vector<query_hit>& hits) {
      std::vector<std::vector<query_hit>> lists;
      for (const query_hit& hit : hits)
        lists.push_back(hit ? std::vector<query_hit>{hit} : std::vector<query_hit>{});
      return lists;
    };
    const auto by_ray = [&](std::size_t k, const auto& s, const pose& at) {
      return detail::ray_meets(s, at, rays[k].from, unit(rays[k].direction), rays[k].length);
    };
    compare("cast_rays", one_each(cast_rays(w, share_of(w, rays))), rays.size(), true, by_ray);
    compare("cast_rays_through", cast_rays_through(w, share_of(w, rays)), rays.size(), false,
            by_ray);
    const auto sweep = [&](const char* what, const auto& shape) {
      const auto by_path = [&](std::size_t k, const auto& s, const pose& at) {
        return detail::shape_meets(shape, pose{paths[k].from, paths[k].orientation}, s, at,
                                   unit(paths[k].direction), paths[k].length);
      };
      compare(what, one_each(cast_shape(w, shape, share_of(w, paths))), paths.size(), true,
              by_path);
      compare(what, cast_shape_through(w, shape, share_of(w, paths)), paths.size(), false, by_path);
      compare(what, find_overlaps(w, shape, share_of(w, poses)), poses.size(), false,
              [&](std::size_t k, const auto& s, const pose& at) {
                return detail::overlap_probe<std::remove_cvref_t<decltype(shape)>>{shape}.meets(
                    s, at, poses[k].position, detail::question{.turn = poses[k].orientation}, 0);
              });
    };
    sweep("of a sphere", sphere{0.4});
    sweep("of a box", box{{0.5, 0.3, 0.8}});
    sweep("of a lens", lens{.radius = 0.5, .thickness = 0.3});
    sweep("of a union", clump({{.shape = box{{0.8, 0.5, 0.3}}, .at = {{0.3, 0, 0}, {1, 0, 0, 0}}},
                               {.shape = sphere{0.3}, .at = {{-0.4, 0, 0.2}, {1, 0, 0, 0}}}}));
    const auto by_point = [&](real within) {
      return [&, within](std::size_t k, const auto& s, const pose& at) {
        return detail::nearest_on_shape(s, at, points[k], within);
      };
    };
    compare("nearest_bodies", one_each(nearest_bodies(w, share_of(w, points))), points.size(), true,
            by_point(detail::endless));
    compare("nearest_bodies", one_each(nearest_bodies(w, share_of(w, points), 0.3)), points.size(),
            true, by_point(0.3));
    std::array<double, 10> all{};
    for (std::size_t k = 0; k < 10; ++k) all[k] = seen[k];
    w.link().reduce(reduction::max, std::span<double>(all));
    for (std::size_t k = 0; k < 10; ++k) {
      CAPTURE(k);
      CHECK(all[k] == 1);
    }
  });
}
