// Tutorial: the most common mistakes, and the message for each, to the letter.
#include <doctest/doctest.h>

#include <stdexcept>
#include <talus/talus.hpp>

#include "ranks.hpp"

using namespace talus;
using namespace talus::tutorial;

using scene = scenario<bodies<sphere, plane>, decomposition<by_hand>>;
using row = scenario<bodies<sphere, plane>, decomposition<slabs<dynamic>>>;

namespace {
const half_space west(-1, 0, 0, 0), east(1, 0, 0, 0), south(0, -1, 0, 0), north(0, 1, 0, 0);
}

TEST_CASE("a one-sided connection is refused on all ranks instead of hanging the first step") {
  const auto wrong = [](auto& world) {
    world.exclusive(0, [&] { world.connect(1, half_space(1, 0, 0, 2)); });
    world.step(0.01);
  };
  refused_on<scene, std::runtime_error>(2, wrong, R"(
      rank 0 is connected to rank 1, but rank 1 is not connected to rank 0: call connect on both
      sides, each with the region of the other
  )");
  CHECK_NOTHROW(on_ranks<scene>(2, [](auto& world) {
    world.exclusive(0, [&] { world.connect(1, half_space(1, 0, 0, 2)); });
    world.exclusive(1, [&] { world.connect(0, half_space(-1, 0, 0, -2)); });
    world.step(0.01);
  }));
}

TEST_CASE("a missing connection across a corner is found, with both ranks and the corner") {
  const auto wrong = [](auto& world) {
    world.exclusive(0, [&] { world.connect(1, east), world.connect(2, north); });
    world.exclusive(1, [&] { world.connect(0, west), world.connect(3, north); });
    world.exclusive(2, [&] { world.connect(0, south), world.connect(3, east); });
    world.exclusive(3, [&] { world.connect(1, south), world.connect(2, west); });
    world.check_connections();
  };
  refused_on<scene, std::runtime_error>(4, wrong, R"(
      the domains of the ranks do not fit together:
      - ranks 0 and 3 meet at (...), where bodies can pass from one to the other, but they are not
      connected: call connect(3, ...) on rank 0 and connect(0, ...) on rank 3
      - ranks 2 and 1 meet at (...), where bodies can pass from one to the other, but they are not
      connected: call connect(1, ...) on rank 2 and connect(2, ...) on rank 1
  )");
}

TEST_CASE("two pictures of one boundary that do not fit are found, with both planes") {
  const auto wrong = [](auto& world) {
    world.exclusive(0, [&] { world.connect(1, half_space(1, 0, 0, 2)); });
    world.exclusive(1, [&] { world.connect(0, half_space(-1, 0, 0, -2.001)); });
    world.check_connections();
  };
  refused_on<scene, std::runtime_error>(2, wrong, R"(
      the domains of the ranks do not fit together:
      - ranks 0 and 1 draw their boundary differently: rank 0 gives x >= 2, rank 1 gives -x >=
      -2.001, which is 0.001 off; none of the ranks owns the point (...); use the same numbers on
      both ranks, all signs reversed
  )");
}

TEST_CASE("a normal that points the wrong way is called by its name") {
  const auto wrong = [](auto& world) {
    world.exclusive(0, [&] { world.connect(1, half_space(1, 0, 0, 2)); });
    world.exclusive(1, [&] { world.connect(0, half_space(1, 0, 0, 2)); });
    world.check_connections();
  };
  refused_on<scene, std::runtime_error>(2, wrong, R"(
      the domains of the ranks do not fit together:
      - ranks 0 and 1 place each other on the same side of a plane: rank 0 gives x >= 2, and rank 1
      gives x >= 2; ... the point (...); the normal points towards the remote rank: reverse all
      signs on one of the two
  )");
}

TEST_CASE("a second connection to a rank is refused until the first one is removed") {
  const auto wrong = [](auto& world) {
    world.exclusive(0, [&] {
      world.connect(1, east);
      world.connect(1, north);
    });
  };
  refused_on<scene, std::invalid_argument>(2, wrong, R"(
      rank 0 is connected to rank 1 already; a rank has one connection to another: call
      disconnect(1) first, or merge both regions into one geometry
  )");
}

TEST_CASE("connections changed between steps want a synchronize") {
  const auto wrong = [](auto& world) {
    world.step(0.01);
    world.exclusive(0, [&] { world.connect(1, east); });
    world.exclusive(1, [&] { world.connect(0, west); });
    world.step(0.01);
  };
  refused_on<scene, std::runtime_error>(2, wrong, R"(
      rank ... changed its connections and then called step: call synchronize() on all ranks first
  )");
}

TEST_CASE("a decomposition for another number of ranks is refused with both numbers") {
  using quarters = scenario<bodies<sphere, plane>, decomposition<grid<2, 2>>>;
  const auto wrong = [] { on_ranks<quarters>(3, [](auto& world) { world.synchronize(); }); };
  refused<std::invalid_argument>(wrong, R"(
      a grid of 2 x 2 x 1 cells needs exactly 4 ranks, but there are 3: start the program with that
      many, or use grid<dynamic>, which fits any number
  )");
}

TEST_CASE("a body created in a foreign domain is refused, with its owner and the other ways") {
  const auto wrong = [](auto& world) {
    const auto iron = world.material(materials::iron);
    world.exclusive(0, [&] {
      world.add(body{.shape = sphere{0.5}, .position = {1.2, 0, 0}, .material = iron});
    });
  };
  refused_on<row, std::invalid_argument>(2, wrong, R"(
      rank 0 cannot add a sphere at (1.2, 0, 0), which is in the domain of rank 1: ask
      world.contains(...) first, or use add_if_local or fill
  )");
}

TEST_CASE("a change of a remote body is refused, for it would be lost") {
  const auto wrong = [](auto& world) {
    const auto iron = world.material(materials::iron);
    world.add_if_local(body{.shape = sphere{0.5}, .position = {-0.1, 0, 0}, .material = iron});
    world.synchronize();
    world.for_each_known([](auto& body) { body.set_velocity({1, 0, 0}); });
  };
  refused_on<row, std::logic_error>(2, wrong, R"(
      the velocity of body ... was changed on rank 1, which holds a shadow copy only, so the change
      would be lost: change it where is_remote() is false
  )");
  on_ranks<row>(2, [](auto& world) {
    const auto iron = world.material(materials::iron);
    world.add_if_local(body{.shape = sphere{0.5}, .position = {-0.1, 0, 0}, .material = iron});
    world.synchronize();
    world.for_each_local([](auto& body) { body.set_velocity({1, 0, 0}); });
    world.synchronize();
    world.for_each_known([](auto& body) { CHECK(body.velocity()[0] == 1); });
  });
}

TEST_CASE("a plane outside of a global section is refused") {
  const auto wrong = [](auto& world) {
    const auto granite = world.material(materials::granite);
    world.exclusive(1, [&] { world.add(plane{.normal = {0, 0, 1}, .offset = 0}, granite); });
  };
  refused_on<row, std::logic_error>(2, wrong, R"(
      a plane is infinite, so it must be known on all ranks, but rank 1 added it outside of a global
      section: add it in world.global(...)
  )");
}

TEST_CASE("a global body changed on one rank only is refused") {
  const auto wrong = [](auto& world) {
    const auto granite = world.material(materials::granite);
    handle<sphere> boulder;
    world.global([&](auto& scope) { boulder = scope.add(sphere{5}, granite); });
    world.exclusive(0, [&] { world[boulder].translate({0, 0, 1}); });
  };
  refused_on<row, std::logic_error>(2, wrong, R"(
      the translation of global body ... was changed inside an exclusive section on rank 0, so the
      ranks would differ: change it on all ranks, outside of the section
  )");
}

TEST_CASE("nested sections are refused") {
  const auto twice = [](auto& world) { world.exclusive(0, [&] { world.exclusive(0, [] {}); }); };
  refused_on<row, std::runtime_error>(2, twice, R"(
      an exclusive section was opened inside another one on rank 0: close the first before the
      second
  )");
  const auto global_in_exclusive = [](auto& world) {
    world.exclusive(0, [&] { world.global([](auto&) {}); });
  };
  refused_on<row, std::logic_error>(2, global_in_exclusive, R"(
      a global section was opened inside an exclusive section on rank 0: global bodies must be made
      on all ranks, so move it behind the section
  )");
  const auto exclusive_in_global = [](auto& world) {
    world.global([&](auto& scope) { scope.exclusive(0, [] {}); });
  };
  refused_on<row, std::logic_error>(2, exclusive_in_global, R"(
      an exclusive section was opened inside a global section on rank ...: global bodies are made
      alike on all ranks, so put the section before or behind it
  )");
  const auto global_twice = [](auto& world) {
    world.global([&](auto& scope) { scope.global([](auto&) {}); });
  };
  refused_on<row, std::runtime_error>(2, global_twice, R"(
      a global section was opened inside another one on rank ...: one is enough
  )");
}

TEST_CASE("an exclusive section for a rank that does not exist is refused") {
  const auto wrong = [](auto& world) { world.exclusive(2, [] {}); };
  refused_on<row, std::invalid_argument>(2, wrong, R"(
      there is no rank 2 for an exclusive section: this job has 2 rank(s), numbered from 0
  )");
}

TEST_CASE("what needs all ranks is refused in an exclusive section, on one rank too") {
  const auto wrong = [](auto& world) { world.exclusive(0, [&] { world.step(0.01); }); };
  for (const int ranks : {1, 2})
    refused_on<row, std::runtime_error>(ranks, wrong, R"(
      step was called inside an exclusive section on rank 0, but all ranks must take part: move the
      call behind the section
    )");
  refused_on<row, std::runtime_error>(
      2, [](auto& world) { world.exclusive(1, [&] { world.synchronize(); }); }, R"(
      synchronize was called inside an exclusive section on rank 1, but ...)");
  refused_on<row, std::runtime_error>(
      2, [](auto& world) { world.exclusive(1, [&] { world.check_connections(); }); }, R"(
      check_connections was called inside an exclusive section on rank 1, but ...)");
}

TEST_CASE("a body larger than the connections cover is refused, with the reach that it needs") {
  const auto wrong = [](auto& world) {
    world.decompose({.lower = 0, .upper = 10});  // five slabs
    const auto iron = world.material(materials::iron);
    world.add_if_local(body{.shape = sphere{3.5}, .position = {5, 0, 0}, .material = iron});
  };
  refused_on<row, std::runtime_error>(5, wrong, R"(
      the sphere ... at (5, 0, 0), owned by rank 2, reaches 3.5 far, into the domain of rank 0, and
      ranks 2 and 0 are not connected, so contacts there would be lost: these ranks are 2 apart, so
      give the decomposition a reach of that length, or call connect on both
  )");
  on_ranks<row>(5, [](auto& world) {
    world.decompose({.lower = 0, .upper = 10}, reach{3.5});
    const auto iron = world.material(materials::iron);
    world.add_if_local(body{.shape = sphere{3.5}, .position = {5, 0, 0}, .material = iron});
    world.step(0.01);
    int known = 0;
    world.for_each_known([&](const auto&) { ++known; });
    CHECK(known == 1);
  });
}

TEST_CASE("a closed face keeps ranks apart, and a body that comes near it ends the run") {
  using sectors = scenario<bodies<sphere, plane>, decomposition<ring<6>>>;
  const auto wrong = [](auto& world) {
    world.decompose({.hub = 2});  // a column of radius 2 is declared but not added
    const auto iron = world.material(materials::iron);
    world.add_if_local(body{
        .shape = sphere{0.5}, .position = {4, 0.3, 0}, .material = iron, .velocity = {-10, 0, 0}});
    for (int step = 0; step < 100; ++step) world.step(0.01);
  };
  refused_on<sectors, std::runtime_error>(6, wrong, R"(
      body ... (sphere) at (...) reaches a closed face in step ...: rank 0 owns the body, and is not
      connected to rank ..., which begins at (...) (where ...); keep bodies away from there (...)...
  )");
}

namespace {
void connect_quarters_without_corners(auto& world) {
  world.exclusive(0, [&] { world.connect(1, east), world.connect(2, north); });
  world.exclusive(1, [&] { world.connect(0, west), world.connect(3, north); });
  world.exclusive(2, [&] { world.connect(0, south), world.connect(3, east); });
  world.exclusive(3, [&] { world.connect(1, south), world.connect(2, west); });
}
}  // namespace

TEST_CASE("a body passes a forgotten corner by way of a third rank") {
  on_ranks<scene>(4, [](auto& world) {
    connect_quarters_without_corners(world);  // without a check
    const auto iron = world.material(materials::iron);
    world.exclusive(0, [&] {
      world.add(body{.shape = sphere{0.1},
                     .position = {-0.3, -0.3, 0},
                     .material = iron,
                     .velocity = {1, 1, 0}});
    });
    for (int step = 0; step < 100; ++step) {
      world.step(0.01);
      CHECK(sum_of(world, world.local_bodies()) == 1);
    }
    CHECK(world.local_bodies() == (world.rank() == 3 ? 1 : 0));
  });
}

TEST_CASE("two bodies that meet in a forgotten corner end the run") {
  const auto wrong = [](auto& world) {
    connect_quarters_without_corners(world);  // without a check
    const auto iron = world.material(materials::iron);
    for (const int rank : {0, 3})
      world.exclusive(rank, [&] {
        const double side = rank == 0 ? -1 : 1;
        world.add(body{.shape = sphere{0.1},
                       .position = {0.2 * side, 0.2 * side, 0},
                       .material = iron,
                       .velocity = {-side, -side, 0}});
      });
    for (int step = 0; step < 30; ++step) world.step(0.01);
  };
  refused_on<scene, std::runtime_error>(4, wrong, R"(
      rank ... sees the sphere ... of rank 0 and the sphere ... of rank 3 meet at (...), but these
      ranks are not connected, so the contact would be lost: call connect on both
  )");
}

TEST_CASE("a gap or an overlap of two domains loses no body and doubles none") {
  for (const double seen : {-0.5, 0.5})  // the end of rank 0's domain according to rank 1
    on_ranks<scene>(2, [&](auto& world) {
      world.exclusive(0, [&] { world.connect(1, half_space(1, 0, 0, 0)); });
      world.exclusive(1, [&] { world.connect(0, half_space(-1, 0, 0, -seen)); });
      const auto iron = world.material(materials::iron);
      world.exclusive(0, [&] {
        world.add(body{
            .shape = sphere{0.1}, .position = {-1, 0, 0}, .material = iron, .velocity = {2, 0, 0}});
      });
      for (int step = 0; step < 100; ++step) {
        world.step(0.01);
        CHECK(sum_of(world, world.local_bodies()) == 1);
      }
      CHECK(world.local_bodies() == (world.rank() == 1 ? 1 : 0));
      CHECK_THROWS_AS(world.check_connections(), std::runtime_error);
    });
}
