// A layer between two planes, with periodic boundaries.
#include <talus/parallel/periodic.hpp>
#include <variant>

#include "digest_of.hpp"

namespace {

using gravel = scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction>,
                        solver<reproducible>, precision<mixed_precision>,
                        decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>,
                        transport<threads>, features<driven>>;

// A sheared layer that is periodic along both axes, its contacts solved in float.
void set_up_shear(world<gravel>& w) {
  const auto stone = w.material({.density = 1, .friction = 0.5});
  const auto rough = w.material({.density = 1, .friction = 2});
  w.gravity({0, 0, -g});
  handle<plane> lower, upper;
  w.global([&](auto& scope) {
    lower = scope.add(plane{.normal = {0, 0, 1}}, rough);
    upper = scope.add(plane{.normal = {0, 0, -1}, .offset = -4.5}, rough);
  });
  w.drive(lower, belt{{1, 0, 0}});
  w.hold_force(upper, {.force = 70, .max_speed = 0.5});
  w.fill(
      simple_cubic{.spacing = 1, .origin = {-3.5, -2.5, 0.5}} & box_region{{-4, -3, 0}, {4, 3, 4}},
      [&](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
        const real r = random.uniform(0.38, 0.5);
        if (random.integer(2) == 0)
          return body{.shape = sphere{r}, .position = at.position, .material = stone};
        return body{.shape = box{{1.1 * r, r, 1.2 * r}},
                    .position = at.position,
                    .material = stone,
                    .orientation = random.rotation()};
      });
}

}  // namespace

std::string shear(const course& how) {
  const int cells = how.ranks == 1 ? 1 : 2;
  return digest_of(
      how,
      [=](threads::link& link) {
        return world<gravel>(
            link, {{.cells = {cells, cells, 1}, .lower = {-4, -3}, .upper = {4, 3}}}, reach{1.2});
      },
      set_up_shear);
}
