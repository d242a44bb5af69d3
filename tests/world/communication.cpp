// The messages of a step: to neighbours only, for any number of ranks, and no global communication.
#include <doctest/doctest.h>

#include <map>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/world/world.hpp>

#include "../scenes/spheres.hpp"

using namespace talus;
using layer = scenes::spheres;

namespace {

struct sent {
  std::uint64_t messages = 0, bytes = 0, collectives = 0;
};

/// A settled layer of spheres on a plane, 3 x 3 of them for each of n x n ranks: the messages of
/// the busiest rank in one step.
sent busiest_rank(int n, real restitution = 0, real speed = 1) {
  sent result;
  threads::launch({.ranks = n * n}, [&](threads::link& link) {
    const double size = 3.0 * n;
    world<layer> w(link, grid<dynamic, dynamic>{.lower = {0, 0}, .upper = {size, size}});
    const auto stuff = w.material({.restitution = restitution, .friction = 0.4});
    w.gravity({0, 0, -9.81});
    w.global([&](auto& scope) { scope.add(plane{}, stuff); });
    w.fill(simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} &
               box_region{{0, 0, 0}, {size, size, 1}},
           [&](const site& s, random_stream& random) {
             return body{.shape = sphere{0.5},
                         .position = s.position,
                         .material = stuff,
                         .velocity = speed * random.uniform(vec3(-1, -1, 0), vec3(1, 1, 0))};
           });
    for (int k = 0; k < 20; ++k) w.step(0.005);
    const auto& s = w.step_messages();
    std::array<std::uint64_t, 3> most{s.messages_max, s.bytes_max, s.collectives};
    link.reduce(reduction::max, most);
    if (link.rank() == 0) result = {most[0], most[1], most[2]};
  });
  return result;
}

}  // namespace

TEST_CASE(
    "messages per rank and step do not grow with the number of ranks, and no call is global") {
  const auto few = busiest_rank(3), some = busiest_rank(5), many = busiest_rank(10);
  MESSAGE("messages of the busiest rank: 9 ranks ", few.messages, ", 25 ranks ", some.messages,
          ", 100 ranks ", many.messages);
  CHECK(few.messages > 0);
  CHECK(many.messages <= few.messages);
  CHECK(some.messages <= few.messages);
  CHECK(many.bytes < 1.5 * few.bytes);
  CHECK(few.collectives + some.collectives + many.collectives == 0);
}

TEST_CASE("a step needs one message per neighbour and iteration, and few besides") {
  // Notification, counts with the first velocities, migration, copies; corrections after the first.
  const solver_settings s;
  const auto per_neighbour =
      static_cast<std::uint64_t>(s.iterations + s.correction_iterations - 1 + 3);
  CHECK(busiest_rank(3).messages <= 8 * per_neighbour);
}

TEST_CASE("restitution needs no further message, and no global call") {
  for (const real speed : {0.0, 5.0}) {
    CAPTURE(speed);
    const auto plastic = busiest_rank(3, 0, speed), elastic = busiest_rank(3, 0.9, speed);
    CHECK(elastic.collectives == 0);
    CHECK(elastic.messages <= plastic.messages);
  }
}
