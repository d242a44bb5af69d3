// The same bits on any number of ranks, however they share space.
#include <doctest/doctest.h>

#include <talus/observe/digest.hpp>
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/cells.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/hexagonal.hpp>
#include <talus/parallel/ring.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/response/coloured_gauss_seidel.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

template <class... Shapes>
using heap = scenario<bodies<Shapes..., plane>, solver<reproducible>, transport<threads>,
                      decomposition<any_decomposition>>;

/// A way to share out the square from -4 to 4 in x and y.
struct sharing {
  const char* name;
  int ranks;
  any_decomposition decomposition;
};

std::vector<sharing> sharings() {
  const auto squares = [](int x, int y) {
    return grid<dynamic, dynamic>{
        .cells = {x, y}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
  };
  return {
      {"grid", 1, squares(1, 1)},
      {"grid", 2, squares(2, 1)},
      {"grid", 4, squares(2, 2)},
      {"grid", 9, squares(3, 3)},
      {"hexagonal", 7, hexagonal<dynamic>{.width = 8}},
      {"hexagonal", 19, hexagonal<dynamic>{.width = 8}},
      {"slanting cells", 2,
       cells(half_space(0.3, 0.8, 0.2, 0.1), complement(half_space(0.3, 0.8, 0.2, 0.1)))},
      {"ring", 4, ring<dynamic>{.sectors = 4, .centre = {-6, -6, 0}, .angle = pi / 2}},
  };
}

/// The digest after `steps` steps of what set_up(world) begins; tend(world, step) comes after each.
template <class Scenario, class SetUp, class Tend>
std::string digest_of(const sharing& how, int steps, SetUp&& set_up, Tend&& tend) {
  std::string digest;
  threads::launch({.ranks = how.ranks}, [&](threads::link& link) {
    world<Scenario> w(link, how.decomposition);
    w.gravity({0, 0, -9.81});
    w.material({.restitution = 0.1, .friction = 0.5});
    w.global([&](auto& s) {
      s.add(plane{.normal = {0, 0, 1}}, {});
      for (const double side : {-1.0, 1.0}) {
        s.add(plane{.normal = {side, 0, 0}, .offset = -4}, {});
        s.add(plane{.normal = {0, side, 0}, .offset = -4}, {});
      }
    });
    set_up(w);
    for (int k = 0; k < steps; ++k) w.step(1.0 / 240), tend(w, k);
    const std::string found = state_digest(w);
    if (link.rank() == 0) digest = found;
  });
  return digest;
}

template <class Scenario, class SetUp, class Tend>
void check_same(int steps, SetUp&& set_up, Tend&& tend) {
  std::string first;
  for (const sharing& how : sharings()) {
    CAPTURE(how.name);
    CAPTURE(how.ranks);
    const std::string found = digest_of<Scenario>(how, steps, set_up, tend);
    if (first.empty()) first = found;
    CHECK(found == first);
  }
}

const auto nothing = [](auto&, int) {};

}  // namespace

TEST_CASE("a heap of spheres has the same bits on any ranks, while bodies come and go") {
  check_same<heap<sphere>>(
      400,
      [](auto& w) {
        const auto sites = simple_cubic{.spacing = 0.8, .origin = {-3.6, -3.6, 0.5}} &
                           vertical_cylinder{.radius = 3.4};
        w.fill(sites.first(400), [](const site& place, random_stream& random) {
          return body{.shape = sphere{random.uniform(0.2, 0.39)},
                      .position = place.position,
                      .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0))};
        });
      },
      [](auto& w, int k) {
        if (k % 40 == 20)
          w.add_if_local(body{.shape = sphere{0.3}, .position = {0.02 * k - 3.5, 0.1, 6}});
        if (k % 100 == 50) w.destroy_if([](const auto& b) { return b.position()[2] > 5; });
      });
}
