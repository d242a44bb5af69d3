// Tutorial: connections made by hand, and those that decompositions make.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/talus.hpp>

#include "ranks.hpp"

using namespace talus;
using namespace talus::tutorial;

using scene = scenario<bodies<sphere>, decomposition<by_hand>>;
using chosen = scenario<bodies<sphere>, decomposition<any_decomposition>>;
using quarters = scenario<bodies<sphere>, decomposition<grid<2, 2>>>;

TEST_CASE("a rank knows its number and how many there are") {
  on_ranks<scene>(3, [](auto& world) {
    const int size = world.ranks();
    const int rank = world.rank();
    CHECK(size == 3);
    CHECK(sum_of(world, std::pow(10, rank)) == 111);
  });
}

TEST_CASE("two ranks at a plane, by normal and displacement") {
  on_ranks<scene>(2, [](auto& world) {
    world.exclusive(0, [&] { world.connect(1, vec3(1, 1, 0), -std::sqrt(2.0)); });
    world.exclusive(1, [&] { world.connect(0, vec3(-1, -1, 0), std::sqrt(2.0)); });
    world.check_connections();

    CHECK(world.contains({-2, -2, 0}) == (world.rank() == 0));
    CHECK(world.contains({0, 0, 0}) == (world.rank() == 1));
    near_plane({1, 1, 0}, [&](const vec3& p) {
      CHECK(owners_of(world, p - unit(vec3(1, 1, 0)) * std::sqrt(2.0)) == 1);
    });
  });
}

TEST_CASE("all forms of connect describe the same plane") {
  const auto with = [](auto&& connect_0, auto&& connect_1) {
    on_ranks<scene>(2, [&](auto& world) {
      world.rank() == 0 ? connect_0(world) : connect_1(world);
      CHECK_NOTHROW(world.check_connections());
      CHECK(world.connections()[0].geometry ==
            any_geometry(
                half_space(world.rank() == 0 ? vec3(1, 1, 0) : vec3(-1, -1, 0), vec3(-2, 0, 0))));
    });
  };
  with([](auto& world) { world.connect(1, 1, 1, 0, -2, 0, 0); },  // normal, point
       [](auto& world) { world.connect(0, -1, -1, 0, -2, 0, 0); });
  with([](auto& world) { world.connect(1, vec3(1, 1, 0), vec3(-2, 0, 0)); },
       [](auto& world) { world.connect(0, vec3(-1, -1, 0), vec3(-2, 0, 0)); });
  const double d = half_space(vec3(1, 1, 0), vec3(-2, 0, 0)).displacement();
  with([=](auto& world) { world.connect(1, 1, 1, 0, d); },  // normal, displacement
       [=](auto& world) { world.connect(0, -1, -1, 0, -d); });
  with([=](auto& world) { world.connect(1, vec3(1, 1, 0), d); },
       [=](auto& world) { world.connect(0, vec3(-1, -1, 0), -d); });
}

TEST_CASE("two ranks at a plane, by the region of the other") {
  on_ranks<scene>(2, [](auto& world) {
    const half_space beyond(vec3(1, 1, 0), -std::sqrt(2.0));
    world.exclusive(0, [&] { world.connect(1, beyond); });
    world.exclusive(1, [&] { world.connect(0, complement(beyond)); });
    world.check_connections();

    CHECK(world.contains({-2, -2, 0}) == (world.rank() == 0));
    CHECK(owners_of(world, -std::sqrt(2.0) * unit(vec3(1, 1, 0))) == 1);
  });
}

TEST_CASE("a quarter space and its complement, by hand and as cells") {
  on_ranks<scene>(2, [](auto& world) {
    const auto corner = intersect(half_space(1, 0, 0, 2), half_space(0, 1, 0, 1));
    world.exclusive(0, [&] { world.connect(1, corner); });
    world.exclusive(1, [&] { world.connect(0, complement(corner)); });
    world.check_connections();
    const auto all = merge(half_space(-1, 0, 0, -2), half_space(0, -1, 0, -1));
    CHECK(any_geometry(complement(corner)) == any_geometry(all));

    random_stream random(5);
    for (int k = 0; k < 1000; ++k) {
      const vec3 p = random.uniform(vec3(-2, -2, -2), vec3(6, 4, 2));
      CHECK(owners_of(world, p) == 1);
      CHECK(world.contains(p) == (world.rank() == (p[0] > 2 && p[1] > 1 ? 1 : 0)));
    }
  });

  on_ranks<chosen>(2, [](auto& world) {
    const auto corner = intersect(half_space(1, 0, 0, 2), half_space(0, 1, 0, 1));
    world.decompose(cells(complement(corner), corner));

    CHECK_NOTHROW(world.check_connections());
    CHECK(world.contains({3, 3, 0}) == (world.rank() == 1));
    CHECK(world.contains({3, 0, 0}) == (world.rank() == 0));
    CHECK(owners_of(world, {2, 1, 0}) == 1);
  });
}

TEST_CASE("the four domains of the well, by hand") {
  on_ranks<scene>(4, [](auto& world) {
    const half_space west(-1, 0, 0, 0), east(1, 0, 0, 0), south(0, -1, 0, 0), north(0, 1, 0, 0);
    world.exclusive(0, [&] {
      world.connect(1, east);
      world.connect(2, north);
      world.connect(3, intersect(east, north));
    });
    world.exclusive(1, [&] {
      world.connect(0, west);
      world.connect(2, intersect(west, north));
      world.connect(3, north);
    });
    world.exclusive(2, [&] {
      world.connect(0, south);
      world.connect(1, intersect(east, south));
      world.connect(3, east);
    });
    world.exclusive(3, [&] {
      world.connect(0, intersect(west, south));
      world.connect(1, south);
      world.connect(2, west);
    });
    world.check_connections();

    near_plane({1, 0, 0}, [&](const vec3& p) { CHECK(owners_of(world, p) == 1); });
    CHECK(owners_of(world, {0, 0, 0}) == 1);
  });
}

TEST_CASE("a decomposition makes the connections that one would make by hand") {
  on_ranks<quarters>(4, [](auto& world) {
    world.decompose({.cuts = {.x = {0}, .y = {0}}});
    world.check_connections();

    CHECK(world.connections().size() == 3);  // the diagonal one, too
    const int quarter = world.rank();        // 0 lower left, 1 lower right, 2 upper left
    CHECK(world.contains({-1, -1, 0}) == (quarter == 0));
    CHECK(world.contains({1, -1, 0}) == (quarter == 1));
    CHECK(world.contains({-1, 1, 0}) == (quarter == 2));
    CHECK(world.contains({0, 0, 0}) == (quarter == 3));
    for (const connection& c : world.connections())
      if (c.rank == 0) CHECK(c.geometry.contains({-1, -1, 0}));
  });
}

TEST_CASE("a connection is replaced by disconnect and connect, and bodies follow") {
  on_ranks<scene>(2, [](auto& world) {
    const auto stone = world.material(materials::granite);
    const half_space first(1, 0, 0, 0), later(1, 0, 0, 5);
    world.rank() == 0 ? world.connect(1, first) : world.connect(0, complement(first));
    world.exclusive(1, [&] {
      world.add(body{.shape = sphere{0.5}, .position = {3, 0, 0}, .material = stone});
    });
    world.synchronize();
    CHECK(world.local_bodies() == (world.rank() == 1 ? 1 : 0));

    world.exclusive(0, [&] {
      world.disconnect(1);
      world.connect(1, later);
    });
    world.exclusive(1, [&] {
      world.disconnect(0);
      world.connect(0, complement(later));
    });
    world.synchronize();

    CHECK(world.local_bodies() == (world.rank() == 0 ? 1 : 0));
  });
}

TEST_CASE("there is a decomposition for every form of a scene, and each fits together") {
  const auto neighbours_of = [](auto& world, int rank) {
    world.check_connections();
    std::vector<int> ranks;
    if (world.rank() == rank)
      for (const connection& c : world.connections()) ranks.push_back(c.rank);
    return world.rank() == rank ? ranks : std::vector<int>{-1};
  };
  const auto are = [](const std::vector<int>& found, const std::vector<int>& wanted) {
    if (found != std::vector<int>{-1}) CHECK(found == wanted);
  };
  on_ranks<chosen>(6, [&](auto& world) {
    world.decompose(grid<3, 2>{.lower = {0, 0}, .upper = {30, 20}});
    are(neighbours_of(world, 1), {0, 2, 3, 4, 5});
    world.decompose(rectilinear<3, 2>{.x = {-1, 4}, .y = {0}});
    CHECK(world.contains({-1.1, -5, 0}) == (world.rank() == 0));
    world.decompose(slabs<6>{.axis = {0, 0, 1}, .lower = 0, .upper = 12});
    are(neighbours_of(world, 2), {1, 3});
    world.decompose(ring<6>{.hub = 2});
    are(neighbours_of(world, 0), {1, 5});
  });
  on_ranks<chosen>(19, [&](auto& world) {
    world.decompose(hexagonal<2>{.spacing = 10});
    are(neighbours_of(world, 0), {1, 2, 3, 4, 5, 6});
    CHECK(world.connections().size() <= 6);
  });
  on_ranks<chosen>(64, [&](auto& world) {
    world.decompose(join(grid<9, 1, 7>{.lower = {.x = 0, .z = 0}, .upper = {.x = 18, .z = 14}},
                         within(half_space(0, 0, -1, 0), slabs<1>{})));
    are(neighbours_of(world, 23), {13, 14, 15, 22, 24, 31, 32, 33});
    CHECK(world.contains({9, 0, -1}) == (world.rank() == 63));
  });
}
