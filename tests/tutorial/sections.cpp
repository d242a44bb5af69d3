// Tutorial: code for one rank, and bodies for all.
#include <doctest/doctest.h>

#include <talus/talus.hpp>

#include "ranks.hpp"

using namespace talus;
using namespace talus::tutorial;

using scene = scenario<bodies<sphere, plane>, decomposition<grid<dynamic>>>;

TEST_CASE("an exclusive section runs on its rank, the code around it on all") {
  on_ranks<scene>(2, [](auto& world) {
    int before = 0, only = 0, after = 0;
    ++before;                             // all ranks
    world.exclusive(0, [&] { ++only; });  // rank 0
    ++after;                              // all ranks
    CHECK(sum_of(world, before + after) == 4);
    CHECK(only == (world.rank() == 0 ? 1 : 0));
  });
}

TEST_CASE("an exclusive section may be written as a condition that ends with its scope") {
  on_ranks<scene>(2, [](auto& world) {
    int only = 0;
    if (auto section = world.exclusive(1)) {
      ++only;
      CHECK_THROWS_AS(world.step(0.01), std::runtime_error);
    }
    CHECK(only == (world.rank() == 1 ? 1 : 0));
    CHECK_NOTHROW(world.step(0.01));  // the section is over
  });
}

TEST_CASE("a plain condition on the rank does for code that concerns this rank alone") {
  on_ranks<scene>(2, [](auto& world) {
    const auto oak = world.material(materials::oak);
    if (world.rank() == 0) {
      world.add(body{.shape = sphere{1}, .position = {-3, 0, 0}, .material = oak});
    }
    CHECK(sum_of(world, world.local_bodies()) == 1);
  });
}

TEST_CASE("a step on one rank alone ends as an error, not as a job that hangs") {
  const auto wrong = [](auto& world) {
    if (world.rank() == 0) {
      world.step(0.01);
    }
  };
  refused_on<scene, std::logic_error>(2, wrong, R"(
      every rank waits for another one, so none can go on: rank 0 is in a collective call, rank 1
      has ended; connect both ranks of a pair to each other (check_connections tells which) and make
      the same collective calls on all ranks
  )");
  const auto section = [](auto& world) { world.exclusive(0, [&] { world.step(0.01); }); };
  refused_on<scene, std::runtime_error>(2, section, R"(
      step was called inside an exclusive section on rank 0, but all ranks must take part: ...
  )");
}

TEST_CASE("a function of one's own refuses to be called in an exclusive section") {
  const auto count_all = [](auto& world) {
    world.require_all_ranks("count_all");
    return sum_of(world, world.local_bodies());
  };
  on_ranks<scene>(2, [&](auto& world) { CHECK(count_all(world) == 0); });
  refused_on<scene, std::runtime_error>(
      2, [&](auto& world) { world.exclusive(1, [&] { (void)count_all(world); }); }, R"(
      count_all was called inside an exclusive section on rank 1, but all ranks must take part: ...
  )");
}

TEST_CASE("bodies of one rank and bodies of all are made side by side") {
  on_ranks<scene>(2, [](auto& world) {
    const auto iron = world.material(materials::iron);
    const auto oak = world.material(materials::oak);

    const vec3 place(2, 4, -3);
    if (world.contains(place))
      world.add(body{.shape = sphere{1.2}, .position = place, .material = iron});

    world.global([&](auto& scope) {
      scope.add(sphere{5}, oak, {10, 20, -40});
      scope.add(plane{.normal = {0, 0, 1}, .offset = -50}, oak);
    });
    world.synchronize();

    CHECK(sum_of(world, world.local_bodies()) == 1);
    int global = 0;
    world.for_each_known([&](const auto& body) {
      if (body.is_global()) ++global;
    });
    CHECK(global == 2);
  });
}

TEST_CASE("a global section may be a value that ends with its scope") {
  on_ranks<scene>(2, [](auto& world) {
    const auto oak = world.material(materials::oak);
    {
      const auto section = world.global();
      const auto boulder = world.add(sphere{5}, oak, {0, 0, 0});
      CHECK(world[boulder].is_global());
      CHECK_THROWS_AS(world.add_if_local(body{.shape = sphere{1}}), std::logic_error);
    }
    const auto own = world.add_if_local(body{.shape = sphere{1}, .position = {-9, 0, 0}});
    CHECK(own.has_value() == (world.rank() == 0));
    if (own) CHECK_FALSE(world[*own].is_global());
  });
}
