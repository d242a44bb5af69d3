// What the same bits on any ranks cost in messages, against the default solver.
#include <talus/scene/lattice.hpp>
#include <talus/scene/ring.hpp>

#include "../scenes/reproduced.hpp"
#include "../scenes/solids.hpp"
#include "reproducible.hpp"

namespace {

/// The most messages that a rank sends in a step, while spheres fall into a round wall of fixed
/// bricks and come to rest.
template <class Scenario>
std::uint64_t messages_of(const any_decomposition& how, int ranks) {
  std::uint64_t most = 0;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, how, reach{2});
    w.gravity({0, 0, -9.81});
    w.material({.friction = 0.5});
    w.global([&](auto& s) { s.add(plane{.normal = {0, 0, 1}}, {}); });
    const vec3 brick{0.6, 0.3, 0.8};
    w.fill(ring_of{.count = 40, .levels = 3, .radius = 3.9, .height = brick[2]},
           [&](const site& place) {
             return body{.shape = box{brick},
                         .position = place.position,
                         .orientation = place.orientation,
                         .fixed = true};
           });
    const auto sites = simple_cubic{.spacing = 0.75, .origin = {-3.75, -3.75, 0.5}} &
                       vertical_cylinder{.radius = 3.2};
    w.fill(sites.first(300), [](const site& place, random_stream& random) {
      return body{.shape = sphere{random.uniform(0.3, 0.37)},
                  .position = place.position,
                  .velocity = random.uniform(vec3(-1, -1, 0), vec3(1, 1, 0))};
    });
    for (int k = 0; k < 240; ++k) w.step(1.0 / 240);
    std::uint64_t messages = w.step_messages().messages_max;
    link.reduce(reduction::max, std::span(&messages, 1));
    if (link.rank() == 0) most = messages;
  });
  return most;
}

}  // namespace

TEST_CASE("the same bits on any ranks cost at most twice the messages of the default solver") {
  const auto squares = [](int x, int y) {
    return grid<dynamic, dynamic>{
        .cells = {x, y}, .lower = {.x = -4, .y = -4}, .upper = {.x = 4, .y = 4}};
  };
  const std::vector<sharing> some = {{"two halves", 2, squares(2, 1)},
                                     {"grid of 4", 4, squares(2, 2)},
                                     {"hexagons, 7", 7, hexagonal<dynamic>{.width = 8}}};
  for (const sharing& how : some) {
    CAPTURE(std::string(how.name));
    const auto least = messages_of<scenes::solids>(how.decomposition, how.ranks);
    const auto found = messages_of<scenes::reproduced>(how.decomposition, how.ranks);
    CHECK(found <= 2 * least);
    CHECK(found > least);
  }
}
