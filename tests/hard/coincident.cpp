// Bodies whose centres coincide exactly, of all shapes: no direction is better than another, but
// they separate slowly, and end without overlap.
#include <doctest/doctest.h>

#include <talus/shape/capsule.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>

#include "../validation/record.hpp"
#include "ranks.hpp"

using namespace talus;
using namespace talus::hard;
using namespace talus::validation;

namespace {

using all_shapes = scene<sphere, box, capsule, cylinder, convex_polyhedron>;

convex_polyhedron octahedron() {
  return convex_polyhedron(
      {{0.6, 0, 0}, {-0.6, 0, 0}, {0, 0.6, 0}, {0, -0.6, 0}, {0, 0, 0.6}, {0, 0, -0.6}});
}
template <class Shape>
void add_two(world<all_shapes>& w, const Shape& a, const auto& b, const vec3& at) {
  w.add_if_local(body<Shape>{.shape = a, .position = at});
  w.add_if_local(body<std::remove_cvref_t<decltype(b)>>{.shape = b, .position = at});
}

}  // namespace

TEST_CASE("two bodies of any shapes with one centre part without speed, and no longer overlap") {
  for (const int ranks : {1, 4}) {
    const cuts domains{.cells = {ranks == 1 ? 1 : 2, ranks == 1 ? 1 : 2, 1}};
    const auto o = run<all_shapes>(
        domains, 1.0 / 240, 240,
        [](world<all_shapes>& w) {
          w.material({.restitution = 0.5, .friction = 0.5});
          const sphere ball{0.5};
          const box cube{{1, 1, 1}};
          const capsule pill{.radius = 0.3, .length = 0.6};
          const cylinder can{.radius = 0.4, .length = 0.8};
          const convex_polyhedron stone = octahedron();
          int place = 0;
          const auto next = [&]() -> vec3 {
            const int k = place++;
            return 4.0 * vec3(k % 4 - 2, k / 4 - 2, 0);  // the third is at the origin's column
          };
          add_two(w, ball, ball, next()), add_two(w, ball, cube, next());
          add_two(w, ball, pill, next()), add_two(w, ball, can, next());
          add_two(w, ball, stone, next()), add_two(w, cube, cube, next());
          add_two(w, cube, pill, next()), add_two(w, cube, can, next());
          add_two(w, cube, stone, next()), add_two(w, pill, pill, next());
          add_two(w, pill, can, next()), add_two(w, pill, stone, next());
          add_two(w, can, can, next()), add_two(w, can, stone, next());
          add_two(w, stone, stone, next());
        },
        1);
    const std::string name = "coincident centres, " + std::to_string(ranks) + " rank(s)";
    CHECK(o.finite);
    CHECK(o.bodies.size() == 30);
    check_error(name, "fastest point of a body at any time", o.fastest(), 1e-12);
    check_error(name, "overlap left, over the mean radius", o.overlap.max, 1e-3);
    check_error(name, "furthest move, over the mean radius", o.furthest() / o.overlap.mean_radius,
                3);
  }
}
