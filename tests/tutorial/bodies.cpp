// Tutorial: small bodies, large bodies and global bodies.
#include <doctest/doctest.h>

#include <atomic>
#include <cmath>
#include <set>
#include <talus/talus.hpp>

#include "ranks.hpp"

using namespace talus;
using namespace talus::tutorial;

using clump = union_of<sphere>;
using row = scenario<bodies<sphere, clump, plane>, decomposition<slabs<dynamic>>>;

TEST_CASE("a body is no copy on exactly one of the ranks that know it") {
  on_ranks<row>(2, [](auto& world) {
    const auto iron = world.material(materials::iron);
    world.add_if_local(body{.shape = sphere{0.5}, .position = {0.2, 0, 0}, .material = iron});
    world.synchronize();

    int known = 0, owned = 0;
    world.for_each_known([&](const auto& body) {
      ++known;
      if (!body.is_remote()) ++owned;
    });
    CHECK(sum_of(world, known) == 2);
    CHECK(sum_of(world, owned) == 1);
    CHECK(owned == (world.rank() == 1 ? 1 : 0));  // its centre lies at x > 0
  });
}

TEST_CASE("a body has one system id on all ranks, and no other body has it") {
  on_ranks<row>(2, [](auto& world) {
    const auto iron = world.material(materials::iron);
    const double side = world.rank() == 0 ? -0.2 : 0.2;
    const auto mine =
        world.add(body{.shape = sphere{0.5}, .position = {side, side, 0}, .material = iron});
    world.synchronize();

    std::set<system_id> ids;
    world.for_each_known([&](const auto& body) { ids.insert(body.id()); });
    CHECK(ids.size() == 2);
    CHECK(ids.contains(mine.id));
    double sum = 0;  // of all ids, alike on both ranks
    for (const system_id id : ids) sum += static_cast<double>(value_of(id));
    CHECK(sum_of(world, sum) == 2 * sum);

    auto view = world.find(mine);  // null if the body is unknown
    REQUIRE(view.has_value());
    CHECK(view->id() == mine.id);
    CHECK_FALSE(view->is_remote());
  });
}

TEST_CASE("a body is created where its centre is, by asking first or by add_if_local") {
  on_ranks<row>(2, [](auto& world) {
    const auto iron = world.material(materials::iron);
    const vec3 place(1.2, -2.4, 3.5);
    if (world.contains(place))
      world.add(body{.shape = sphere{2}, .position = place, .material = iron});
    CHECK(world.local_bodies() == (world.rank() == 1 ? 1 : 0));

    world.add_if_local(body{.shape = sphere{2}, .position = {-1.2, -2.4, 3.5}, .material = iron});
    CHECK(world.local_bodies() == 1);
  });
}

TEST_CASE("a loop that all ranks run alike makes the same bodies on any number of ranks") {
  const auto digest = [](int ranks) {
    std::string result;
    on_ranks<row>(ranks, [&](auto& world) {
      world.decompose({.lower = -6, .upper = 6});
      const auto iron = world.material(materials::iron);
      for (int i = 0; i < 12; ++i) {
        random_stream random(42, i);
        world.add_if_local(body{.shape = sphere{random.uniform(0.3, 0.5)},
                                .position = {i - 5.5, 0, 0},
                                .material = iron,
                                .velocity = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1))});
      }
      const std::string text = state_digest(world);
      if (world.rank() == 0) result = text;
    });
    return result;
  };
  CHECK(digest(1) == digest(2));
  CHECK(digest(1) == digest(5));
}

TEST_CASE("fill visits a rank's own sites, with the same bodies on any number of ranks") {
  const auto digest = [](int ranks, int& most) {
    std::string result;
    std::atomic<int> largest = 0;
    on_ranks<row>(ranks, [&](auto& world) {
      world.decompose({.lower = -6, .upper = 6});
      const auto iron = world.material(materials::iron);
      int calls = 0;
      const auto sites = simple_cubic{.spacing = 1.5} & box_region{{-6, -6, 0}, {6, 6, 3}};
      world.fill(sites, [&](const site& place, random_stream& random) {
        ++calls;
        return body{.shape = sphere{random.uniform(0.3, 0.7)},
                    .position = place.position,
                    .material = iron};
      });
      CHECK(sum_of(world, calls) == 9 * 9 * 3);
      for (int seen = largest; seen < calls && !largest.compare_exchange_weak(seen, calls);) {
      }
      const std::string text = state_digest(world);
      if (world.rank() == 0) result = text;
    });
    most = largest;
    return result;
  };
  int alone, of_three;
  CHECK(digest(1, alone) == digest(3, of_three));
  CHECK(alone == 243);
  CHECK(of_three < 100);  // a rank does not visit the sites of others
}

TEST_CASE("bodies are moved anywhere after their creation, and synchronize brings them there") {
  on_ranks<row>(5, [](auto& world) {
    world.decompose({.lower = 0, .upper = 10});
    const auto iron = world.material(materials::iron);
    const auto ball =
        world.add_if_local(body{.shape = sphere{0.5}, .position = {1, 0, 0}, .material = iron});
    if (ball) world[*ball].translate({8, 0, 0});
    world.synchronize();

    CHECK(world.local_bodies() == (world.rank() == 4 ? 1 : 0));
  });
}

TEST_CASE("bodies come and go while time runs, and their number always adds up") {
  on_ranks<row>(3, [](auto& world) {
    world.decompose({.lower = 0, .upper = 9});
    world.gravity({4, 0, 0});
    const auto iron = world.material(materials::iron);
    double emitted = 0, removed = 0;

    for (int step = 0; step < 600; ++step) {
      if (step % 20 == 0)
        world.exclusive(0, [&] {
          const vec3 place(1, 0, 0);
          if (world.overlaps(sphere{0.4}, place)) return;
          world.add(body{.shape = sphere{0.4}, .position = place, .material = iron});
          ++emitted;
        });
      world.exclusive(world.ranks() - 1, [&] {
        removed += world.destroy_if([](const auto& body) { return body.position()[0] > 12; });
      });
      world.step(0.01);
    }

    emitted = sum_of(world, emitted);
    removed = sum_of(world, removed);
    CHECK(emitted > 5);
    CHECK(emitted < 30);  // now and then the place was taken
    CHECK(removed > 2);
    CHECK(emitted == removed + sum_of(world, world.local_bodies()));
  });
}

TEST_CASE("an agglomerate over five ranks moves as on one, and keeps its momentum") {
  struct result {
    vec3 position, velocity, spin, momentum_before, momentum_after;
  };
  const auto run = [](int ranks) {
    result found;
    on_ranks<row>(ranks, [&](auto& world) {
      world.decompose({.lower = 0, .upper = 10}, reach{5});
      const auto stone = world.material({.density = 1, .restitution = 0.5, .friction = 0.3});

      std::vector<clump::part> grains;
      for (int k = 0; k < 13; ++k) grains.push_back({sphere{0.5}, {{0.75 * k - 4.5, 0, 0}}});
      world.add_if_local(body{.shape = clump(grains), .position = {5, 0, 0}, .material = stone});
      for (const double side : {-1, 1})
        world.add_if_local(body{.shape = sphere{0.5},
                                .position = {5 + 4.4 * side, -2 * side, 0},
                                .material = stone,
                                .velocity = {0, 3 * side, 0}});
      world.synchronize();
      int known = 0;
      world.for_each_known([&](const auto& body) {
        if constexpr (requires { body.shape().parts(); }) ++known;
      });
      CHECK(known == 1);  // all five ranks know it
      const motion before = measure_motion(world);
      for (int step = 0; step < 100; ++step) world.step(0.01);
      const motion after = measure_motion(world);
      world.for_each_local([&](const auto& body) {
        if constexpr (requires { body.shape().parts(); })
          found = {body.position(), body.velocity(), body.angular_velocity(), before.momentum,
                   after.momentum};
      });
    });
    return found;
  };
  const result alone = run(1), five = run(5);
  CHECK(alone.spin[2] > 0.2);  // both ends were hit
  CHECK(five.spin[2] == doctest::Approx(alone.spin[2]).epsilon(1e-6));
  CHECK((five.position - alone.position).norm() < 1e-6);
  CHECK((five.velocity - alone.velocity).norm() < 1e-6);
  CHECK((five.momentum_after - five.momentum_before).norm() < 1e-12);
}

TEST_CASE("global bodies are known and fixed on all ranks, finite ones and unions alike") {
  on_ranks<row>(3, [](auto& world) {
    world.decompose({.cuts = {0, 10}});
    const auto oak = world.material(materials::oak);
    handle<sphere> boulder;
    handle<clump> pair;
    world.gravity({0, 0, -10});
    world.global([&](auto& scope) {
      boulder = scope.add(sphere{5}, oak, {10, 20, -40});
      pair = scope.add(clump({{sphere{1}, {{-1, 0, 0}}}, {sphere{1}, {{1, 0, 0}}}}), oak);
    });
    world.synchronize();
    for (int step = 0; step < 10; ++step) world.step(0.01);

    CHECK(world.local_bodies() == 0);  // no rank owns them, and none sends them
    CHECK(world[boulder].is_global());
    CHECK(world[pair].is_global());
    CHECK(world[boulder].position() == vec3(10, 20, -40));  // it does not fall
    CHECK(world[pair].position() == vec3(0, 0, 0));
    CHECK(world.overlaps(sphere{0.5}, {10, 20, -34.6}));
  });
}

TEST_CASE("a plane is made in a global section, and bodies of all ranks rest on it") {
  on_ranks<row>(2, [](auto& world) {
    const auto granite = world.material({.density = 2.8, .friction = 0.5});
    world.gravity({-1, -1, 0});
    world.global([&](auto& scope) { scope.add(plane{.normal = {1, 1, 0}, .offset = 5}, granite); });
    const double foot = 5.5 / std::sqrt(2.0);  // of a sphere of radius 0.5 on the plane
    for (const double along : {-8, 8})
      world.add_if_local(body{
          .shape = sphere{0.5}, .position = {foot + along, foot - along, 0}, .material = granite});
    for (int step = 0; step < 50; ++step) world.step(0.01);

    CHECK(world.local_bodies() == 1);
    world.for_each_local([](const auto& body) {
      CHECK(body.position().dot(unit(vec3(1, 1, 0))) == doctest::Approx(5.5));
      CHECK_FALSE(body.is_global());
    });
  });
}

TEST_CASE("a changed global body is changed on all ranks") {
  on_ranks<row>(2, [](auto& world) {
    const auto oak = world.material(materials::oak);
    handle<sphere> boulder;
    world.global([&](auto& scope) { boulder = scope.add(sphere{5}, oak, {0, 0, 5}); });
    world[boulder].translate({0, 0, 1});  // on every rank
    CHECK(world.overlaps(sphere{1}, {0, 0, 11.9}));
    CHECK_THROWS_AS(world[boulder].release(), std::logic_error);  // global is global for ever
    world.destroy(boulder);
    CHECK_FALSE(world.find(boulder).has_value());
  });
}
