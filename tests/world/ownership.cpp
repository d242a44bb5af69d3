// Ownership over ranks: ids, shadow copies, migration, and changes between steps.
#include <doctest/doctest.h>

#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>
#include <talus/parallel/by_hand.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>

#include "../scenes/solids.hpp"

using namespace talus;
using halves = scenes::solids;

TEST_CASE("system ids are unique over ranks, and a body is local on exactly one of them") {
  std::mutex mutex;
  std::set<system_id> ids;
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<halves> w(link, grid<2>{.lower = {-1}, .upper = {1}});
    const auto stuff = w.material({});
    for (int k = 0; k < 10; ++k) {
      const double x = link.rank() == 0 ? -1.0 - 3 * k : 1.0 + 3 * k;
      const auto h = w.add(body{.shape = sphere{0.5}, .position = {x, 0, 0}, .material = stuff});
      const auto attempt = w.add_if_local(
          body{.shape = sphere{0.5}, .position = {-30.0 + 6 * k, 5, 0}, .material = stuff});
      const std::lock_guard lock(mutex);
      CHECK(ids.insert(h.id).second);
      if (attempt) CHECK(ids.insert(attempt->id).second);
    }
    w.synchronize();
    CHECK(ids.size() == 30);
  });
}

TEST_CASE("a body in a foreign domain is refused with the place and the rank that owns it") {
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<halves> w(link, grid<2>{.lower = {-1}, .upper = {1}});
    const auto stuff = w.material({});
    const double foreign = link.rank() == 0 ? 2 : -2;
    CHECK_THROWS_WITH_AS(
        w.add(body{.shape = sphere{1}, .position = {foreign, 0, 0}, .material = stuff}),
        doctest::Contains(link.rank() == 0 ? "in the domain of rank 1" : "in the domain of rank 0"),
        std::invalid_argument);
  });
}

TEST_CASE("a body near the boundary has one owner and one shadow copy, which refuses changes") {
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<halves> w(link, grid<2>{.lower = {-1}, .upper = {1}});
    const auto stuff = w.material({});
    handle<sphere> h{detail::id_of_attempt(0)};
    w.add_if_local(body{.shape = sphere{1}, .position = {0.2, 0, 0}, .material = stuff});
    w.synchronize();
    const auto seen = w.find(h);
    REQUIRE(seen.has_value());
    CHECK(seen->is_remote() == (link.rank() == 0));
    if (seen->is_remote()) {
      CHECK_THROWS_WITH_AS(w[h].set_velocity({1, 0, 0}), doctest::Contains("shadow copy"),
                           std::logic_error);
      CHECK_THROWS_WITH_AS(w.destroy(h), doctest::Contains("shadow copy"), std::logic_error);
    } else {
      w[h].set_velocity({-10, 0, 0});
    }
    w.step(0.05);  // crosses the boundary
    CHECK(w[h].is_remote() == (link.rank() == 1));
    CHECK(w[h].velocity()[0] == -10);
    if (link.rank() == 0) w.destroy(h);
    w.step(0.01);
    CHECK_FALSE(w.find(h).has_value());
  });
}

TEST_CASE(
    "destroying and adding shadowed bodies between steps without synchronize keeps the ranks in "
    "step") {
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<halves> w(link, grid<2>{.lower = {-1}, .upper = {1}});
    const auto stuff = w.material({});
    std::vector<handle<sphere>> mine;
    for (int k = 0; k < 60; ++k) {
      if (link.rank() == 0) {
        mine.push_back(
            w.add(body{.shape = sphere{0.3}, .position = {-0.1, 0.5 * k, 0}, .material = stuff}));
        if (mine.size() > 5) {
          w.destroy(mine.front());
          mine.erase(mine.begin());
        }
      } else if (k % 3 == 0) {
        w.add(body{.shape = sphere{0.4}, .position = {0.5, 0.5 * k, 0}, .material = stuff});
      }
      w.step(0.01);
    }
    std::uint64_t bodies = w.local_bodies();
    link.reduce(reduction::sum, std::span(&bodies, 1));
    CHECK(bodies == 5 + 20);
  });
}

TEST_CASE("a body translated far into a domain that is no neighbour is routed there") {
  threads::launch({.ranks = 6}, [&](threads::link& link) {
    world<scenes::solids> w(link, grid<dynamic, 1, 1>{.lower = {0}, .upper = {6}});
    const auto stuff = w.material({});
    w.add_if_local(body{.shape = sphere{0.1}, .position = {0.5, 0, 0}, .material = stuff});
    if (link.rank() == 0) w[handle<sphere>{detail::id_of_attempt(0)}].translate({5, 0, 0});
    w.synchronize();
    CHECK(w.local_bodies() == (link.rank() == 5 ? 1 : 0));
    if (link.rank() == 5) w[handle<sphere>{detail::id_of_attempt(0)}].translate({-5, 0, 0});
    for (int k = 0; k < 6; ++k) w.step(1e-6);  // one connection a step
    CHECK(w.local_bodies() == (link.rank() == 0 ? 1 : 0));
  });
}

TEST_CASE(
    "a body whose motion is no longer finite ends the run with its id, place, step and rank") {
  CHECK_THROWS_WITH_AS(threads::launch({.ranks = 2},
                                       [&](threads::link& link) {
                                         world<halves> w(link,
                                                         grid<2>{.lower = {-1}, .upper = {1}});
                                         const auto stuff = w.material({});
                                         if (link.rank() == 1)
                                           w.add(body{.shape = sphere{1},
                                                      .position = {2, 0, 0},
                                                      .material = stuff,
                                                      .velocity = {1e308, 0, 0}});
                                         for (int k = 0; k < 20; ++k) w.step(10);
                                       }),
                       doctest::Contains("rank 1"), std::runtime_error);
}

TEST_CASE("a body that is released next to a boundary takes as much momentum as it gives") {
  // Contacts with it were solved by the other rank alone, which stores their impulse.
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<halves> w(link, grid<2>{.lower = {-1}, .upper = {1}});
    const auto stuff = w.material({});
    w.solver().iterations = 1;  // more would hide a lost warm start
    for (const double x : {-2.4, -1.4, -0.4})
      w.add_if_local(body{.shape = sphere{0.5}, .position = {x, 0, 0}, .material = stuff});
    const auto fixed = w.add_if_local(
        body{.shape = sphere{0.5}, .position = {0.6, 0, 0}, .material = stuff, .fixed = true});
    w.gravity({10, 0, 0});
    for (int k = 0; k < 10; ++k) w.step(0.01);
    w.gravity({0, 0, 0});
    if (fixed) w[*fixed].release();
    for (int k = 0; k < 3; ++k) {
      w.step(0.01);
      double momentum = 0;
      w.for_each_local([&](const auto& b) { momentum += b.mass() * b.velocity()[0]; });
      link.reduce(reduction::sum, std::span(&momentum, 1));
      CHECK(std::abs(momentum) < 1e-14);
    }
  });
}

TEST_CASE("bodies made before the connections are handed over by synchronize") {
  using free_form = scenario<bodies<sphere>, transport<threads>, decomposition<by_hand>>;
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<free_form> w(link);
    const auto stuff = w.material({});
    w.exclusive(0, [&] {
      for (int k = -5; k <= 5; ++k)
        w.add(body{.shape = sphere{0.4}, .position = {1.0 * k, 0.5, 0}, .material = stuff});
      w.connect(1, vec3(1, 1, 0), -std::sqrt(2.0));
    });
    w.exclusive(1, [&] { w.connect(0, vec3(-1, -1, 0), std::sqrt(2.0)); });
    CHECK_NOTHROW(w.check_connections());
    w.synchronize();
    CHECK(w.local_bodies() == (link.rank() == 0 ? 3 : 8));
  });
}

TEST_CASE("a one-sided connection is named on all ranks instead of hanging the first exchange") {
  using free_form = scenario<bodies<sphere>, transport<threads>, decomposition<by_hand>>;
  for (const bool step : {false, true})
    CHECK_THROWS_WITH_AS(
        threads::launch({.ranks = 3},
                        [&](threads::link& link) {
                          world<free_form> w(link);
                          w.exclusive(2, [&] { w.connect(0, vec3(-1, 0, 0), 0.0); });
                          step ? w.step(0.1) : w.synchronize();
                        }),
        doctest::Contains("rank 2 is connected to rank 0, but rank 0 is not connected to rank 2"),
        std::runtime_error);
}

TEST_CASE("connections changed between steps want a synchronize, and then carry bodies") {
  using free_form = scenario<bodies<sphere>, transport<threads>, decomposition<by_hand>>;
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<free_form> w(link);
    const auto stuff = w.material({});
    w.exclusive(0, [&] {
      w.add(body{.shape = sphere{0.5}, .position = {-2, 0, 0}, .material = stuff});
      w.add(body{.shape = sphere{0.5}, .position = {2, 0, 0}, .material = stuff});
    });
    w.step(0.1);
    CHECK(w.local_bodies() == (link.rank() == 0 ? 2 : 0));
    if (link.rank() == 0)
      w.connect(1, 1.0, 0.0, 0.0, 0.0);
    else
      w.connect(0, -1.0, 0.0, 0.0, 0.0);
    CHECK_THROWS_WITH_AS(w.step(0.1), doctest::Contains("call synchronize()"), std::runtime_error);
    w.synchronize();
    CHECK(w.local_bodies() == 1);
    CHECK_NOTHROW(w.step(0.1));
  });
}

TEST_CASE(
    "a decomposition without its extents is named before any body exists, and decompose() cures "
    "it") {
  using cells =
      scenario<bodies<sphere, plane>, transport<threads>, decomposition<grid<dynamic, dynamic>>>;
  threads::launch({.ranks = 9}, [&](threads::link& link) {
    world<cells> w(link);
    const auto stuff = w.material({});
    const auto refused = [](auto&& f) {
      CHECK_THROWS_WITH_AS(f(), doctest::Contains("world.decompose(...) takes them"),
                           std::invalid_argument);
    };
    refused([&] { w.add(body{.shape = sphere{1}, .material = stuff}); });
    refused([&] { (void)w.contains({0, 0, 0}); });
    refused([&] { w.synchronize(); });
    refused([&] { w.step(0.1); });
    w.decompose({.lower = {-1, -1}, .upper = {1, 1}});
    w.add_if_local(body{.shape = sphere{1}, .material = stuff});
    CHECK_NOTHROW(w.step(0.1));
    CHECK(w.local_bodies() == (link.rank() == 4 ? 1 : 0));
  });
}

TEST_CASE("a decomposition for another number of ranks is refused with both numbers") {
  using four = scenario<bodies<sphere>, transport<threads>, decomposition<grid<2, 2>>>;
  threads::launch({.ranks = 3}, [&](threads::link& link) {
    const auto make = [&] { world<four> w(link, {}); };
    CHECK_THROWS_WITH_AS(make(), doctest::Contains("4"), std::invalid_argument);
    CHECK_THROWS_WITH_AS(make(), doctest::Contains("3"), std::invalid_argument);
  });
}

TEST_CASE("checking new connections does not stand for the synchronize that they want") {
  using free_form = scenario<bodies<sphere>, transport<threads>, decomposition<by_hand>>;
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<free_form> w(link);
    w.step(0.1);
    const double towards = link.rank() == 0 ? 1 : -1;
    w.connect(1 - link.rank(), towards, 0.0, 0.0, 0.0);
    w.check_connections();
    CHECK_THROWS_WITH_AS(w.step(0.1), doctest::Contains("call synchronize()"), std::runtime_error);
    w.synchronize();
    CHECK_NOTHROW(w.step(0.1));
  });
}
