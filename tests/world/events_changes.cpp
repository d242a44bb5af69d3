// features<events> while the user changes the world: bodies are removed, fixed and released,
// regions are added, and domains move. What an impact is, and what is refused.
// timeout: 120
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/events.hpp>
#include <talus/observe/monitors.hpp>
#include <talus/observe/queries.hpp>
#include <talus/parallel/bisection.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/outflow.hpp>
#include <talus/scene/region.hpp>
#include <talus/world/each_contact.hpp>
#include <utility>
#include <vector>

#include "../tutorial/ranks.hpp"

using namespace talus;
using tutorial::refused;

namespace {

using stiff = hard_contact<coulomb_friction>;
using springs = soft_contact<linear_spring_dashpot, coulomb_friction>;
template <class Law>
using serially = scenario<bodies<sphere, plane>, Law, transport<serial>, features<events>>;
template <class Law>
using divided =
    scenario<bodies<sphere, plane>, Law, decomposition<grid<dynamic>>, features<events>>;

/// Two spheres on a wall, which gravity presses against it, one on the other; the domains are
/// divided between them.
template <class World>
struct column_of_two {
  World& w;
  handle<plane> wall;
  std::optional<handle<sphere>> lower, upper;

  column_of_two(World& world, bool lower_is_fixed, bool upper_first) : w(world) {
    material m{.density = 1, .restitution = 0, .friction = 0.3};
    if constexpr (World::scenario_type::contact_law::soft) m.restitution = 0.3, m.stiffness = 1e4;
    const auto stuff = w.material(m);
    w.gravity({10, 0, 0});
    w.global([&](auto& all) { wall = all.add(plane{{-1, 0, 0}, -1}, stuff); });
    const auto add = [&](real x, bool fixed) {
      return w.add_if_local(
          body{.shape = sphere{0.5}, .position = {x, 0, 0}, .material = stuff, .fixed = fixed});
    };
    if (upper_first) upper = add(-0.498, false);
    lower = add(0.501, lower_is_fixed);
    if (!upper_first) upper = add(-0.498, false);
    for (int k = 0; k < 200; ++k) w.step(0.002);
  }
  /// The number of contacts that begin and end in some steps.
  [[nodiscard]] std::array<int, 2> changes(int steps) {
    std::array<int, 2> n{};
    for (int k = 0; k < steps; ++k) {
      w.step(0.002);
      const auto all = all_events(w);
      for (const event& e : all) ++n[static_cast<std::size_t>(e.kind)];
      for (std::size_t i = 1; i < all.size(); ++i)  // an end comes before a new beginning
        if (all[i].a == all[i - 1].a && all[i].b == all[i - 1].b)
          CHECK(all[i - 1].kind == event_kind::contact_ends);
    }
    return n;
  }
};

/// Calls program(column) in one process, and on one and two ranks.
template <class Law, class Program>
void everywhere(bool lower_is_fixed, Program&& program) {
  for (const bool upper_first : {false, true}) {
    CAPTURE(upper_first);
    {
      serial::link link;
      world<serially<Law>> w(link);
      column_of_two column(w, lower_is_fixed, upper_first);
      program(column);
    }
    for (const int ranks : {1, 2}) {
      CAPTURE(ranks);
      threads::launch({.ranks = ranks}, [&](threads::link& link) {
        world<divided<Law>> w(link, {.cells = {ranks}, .lower = {-1}, .upper = {1}}, reach{1});
        column_of_two column(w, lower_is_fixed, upper_first);
        program(column);
      });
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("a body that is removed ends no contact", Law, stiff, springs) {
  using counts = std::array<int, 2>;
  everywhere<Law>(false, [](auto& c) {
    CHECK(c.changes(5) == counts{0, 0});
    if (c.upper) c.w.destroy(*c.upper);
    CHECK(c.changes(5) == counts{0, 0});
    c.w.destroy(c.wall);
    CHECK(c.changes(5) == counts{0, 0});
  });
  everywhere<Law>(false, [](auto& c) {
    if (c.lower) c.w.destroy(*c.lower);
    CHECK(c.changes(5) == counts{0, 0});
  });
}

TEST_CASE_TEMPLATE("contacts of a body that is fixed, and of one that is released", Law, stiff,
                   springs) {
  using counts = std::array<int, 2>;
  everywhere<Law>(true, [](auto& c) {
    CHECK(c.changes(5) == counts{0, 0});
    if (c.lower) c.w[*c.lower].release();
    // That with the upper body ends and begins anew, that with the wall begins.
    CHECK(c.changes(1) == counts{2, 1});
    CHECK(c.changes(20) == counts{0, 0});
    if (c.lower) c.w[*c.lower].release();  // it is movable already
    CHECK(c.changes(5) == counts{0, 0});
    if (c.lower) c.w[*c.lower].fix();
    CHECK(c.changes(5) == counts{0, 1});  // that with the wall ends
  });
}

namespace {

using visited = scenario<bodies<sphere>, hard_contact<>, decomposition<grid<dynamic>>,
                         features<events, checkpoints>>;

}  // namespace

TEST_CASE("a region that is added during a run: bodies inside have not entered, and may leave") {
  const auto run = [](int ranks, int first) {
    std::vector<std::array<int, 3>> story;  // step, kind, region
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<visited> w(link, {.cells = {ranks}, .lower = {-2}, .upper = {2}}, reach{1});
      (void)w.material({});
      w.add_if_local(body{.shape = sphere{0.1}, .position = {-1.5, 0, 0}, .velocity = {1, 0, 0}});
      auto& e = w.feature<events>();
      const auto add = [&](real from, real to) {
        return e.region(box_region{{from, -1, -1}, {to, 1, 1}});
      };
      if (first > 0) {
        (void)add(-2, 1), (void)add(-2, 0.5), (void)add(0.7, 2);
        (void)read_checkpoint(w, "events_regions.h5");
      }
      for (int k = first; k < 30; ++k) {
        if (first == 0 && k == 5) (void)add(-2, 1);
        if (first == 0 && k == 10) (void)add(-2, 0.5), (void)add(0.7, 2);
        w.step(0.1);
        for (const event& each : all_events(w))
          if (w.rank() == 0) story.push_back({k, int(each.kind), each.region});
        if (first == 0 && k == 14) write_checkpoint(w, "events_regions.h5");
      }
    });
    return story;
  };
  const auto leaves = int(event_kind::leaves), enters = int(event_kind::enters);
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    const auto all = run(ranks, 0);
    REQUIRE(all.size() == 3);
    CHECK(all[0][1] == leaves);
    CHECK(all[0][2] == 1);
    CHECK(all[1][1] == enters);
    CHECK(all[1][2] == 2);
    CHECK(all[2][1] == leaves);
    CHECK(all[2][2] == 0);
    CHECK(run(ranks, 15) == all);
  }
  std::remove("events_regions.h5");
}

namespace {

using moving = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction>,
                        decomposition<bisection<dynamic>>, features<events, balancing>>;

}  // namespace

TEST_CASE("contacts begin and end once while domains move") {
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<moving> w(link);
    w.decompose({.lower = {-4}, .upper = {4}});
    w.balance({.every = 10, .above = 1.01});
    const auto stuff = w.material({.friction = 0.2});
    w.gravity({6, 0, -8});
    w.global([&](auto& all) {
      all.add(plane{}, stuff), all.add(plane{{-1, 0, 0}, -4}, stuff);
      all.add(plane{{0, 1, 0}, -1}, stuff), all.add(plane{{0, -1, 0}, -1}, stuff);
    });
    for (int k = 0; k < 24; ++k)
      w.add_if_local(
          body{.shape = sphere{0.3},
               .position = {-3.5 + 0.7 * (k % 6), -0.6 + 0.7 * (k / 6 % 2), 0.4 + 0.7 * (k / 12)},
               .material = stuff});
    std::set<std::pair<system_id, system_id>> touching;
    std::uint64_t changes = 0;
    for (int k = 0; k < 200; ++k) {
      w.step(0.01);
      for (const event& e : all_events(w)) {
        ++changes;
        if (e.kind == event_kind::contact_begins)
          CHECK(touching.insert({e.a, e.b}).second);
        else
          CHECK(touching.erase({e.a, e.b}) == 1);
      }
      std::uint64_t here = 0;
      std::set<std::pair<system_id, system_id>> mine;
      for_each_contact(w, [&](const loaded_contact& c) {
        mine.insert({std::min(c.a, c.b), std::max(c.a, c.b)});
      });
      for (const auto& one : mine) here += touching.count(one) == 1;
      std::array<std::uint64_t, 2> sums{here, mine.size()};
      w.link().reduce(reduction::sum, std::span(sums));
      CHECK(sums[0] == touching.size());
      CHECK(sums[1] == touching.size());
    }
    CHECK(changes > 50);
  });
}

namespace {

using line = scenario<bodies<sphere, plane>, hard_contact<newton_restitution>,
                      decomposition<grid<dynamic>>, features<events>>;

}  // namespace

TEST_CASE("a ball that bounces: place, impulse and speed of its impacts, and the columns") {
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<line> w(link, {.cells = {ranks}, .lower = {-1}, .upper = {1}}, reach{1});
      const auto stuff = w.material({.density = 1, .restitution = 0.5});
      w.gravity({0, 0, -10});
      w.global([&](auto& all) { all.add(plane{}, stuff); });
      // It crosses to the second rank between its impacts.
      w.add_if_local(body{.shape = sphere{0.1},
                          .position = {-0.5, 0, 1.1},
                          .material = stuff,
                          .velocity = {1, 0, 0}});
      w.feature<events>().impacts({.speed = 1});
      std::vector<event> impacts;
      int begun = 0;
      for (int k = 0; k < 2000; ++k) {
        w.step(0.0005);
        for (const event& e : all_events(w)) {
          if (e.kind == event_kind::impact) impacts.push_back(e);
          begun += e.kind == event_kind::contact_begins;
        }
      }
      REQUIRE(impacts.size() == 2);
      CHECK(begun >= 2);
      const double v = std::sqrt(2 * 10 * 1.0), mass = 4. / 3 * pi * 1e-3;
      CHECK(impacts[0].speed == doctest::Approx(v).epsilon(0.01));
      CHECK(impacts[0].impulse == doctest::Approx(1.5 * mass * v).epsilon(0.01));
      CHECK(impacts[0].point[0] == doctest::Approx(-0.5 + v / 10).epsilon(0.02));
      CHECK(impacts[1].speed == doctest::Approx(v / 2).epsilon(0.01));
      CHECK(impacts[1].point[2] == doctest::Approx(0).epsilon(0.01));
      const auto columns = measure_monitors(w).values;
      const auto is = [&](std::string_view name, double value) {
        for (const auto& c : columns)
          if (c.name == name) return c.value == value;
        return false;
      };
      CHECK(is("impacts", 2));
      CHECK(is("contacts_begun", begun));
      CHECK(is("regions_entered", 0));
      const data_table table = event_table(w);
      CHECK(table.columns().size() == 9);
    });
  }
}

TEST_CASE("what events cannot be is refused") {
  events::state e;
  refused<std::invalid_argument>(
      [&] { e.impacts({.impulse = -1}); },
      "events has impacts with .impulse = -1 and .speed = 0: set thresholds of 0 or more");
  for (int k = 0; k < 31; ++k) (void)e.region(box_region{{0, 0, 0}, {1, 1, 1}});
  refused<std::invalid_argument>(
      [&] {
        (void)e.region(box_region{{0, 0, 0}, {1, 1, 1}});
      },
      "events has 31 regions, and no room for another: merge regions, or test bodies in "
      "after_each_step");
  const real nan = std::numeric_limits<real>::quiet_NaN();
  const std::string says =
      ", in which no point lies: give its lowest corner first, a radius of 0 or more, and numbers "
      "everywhere";
  refused<std::invalid_argument>(
      [&] {
        (void)events::state().region(box_region{{1, 1, 1}, {0, 0, 0}});
      },
      "events.region was given a region from (1, 1, 1) to (0, 0, 0)" + says);
  refused<std::invalid_argument>(
      [&] {
        (void)events::state().region(box_region{{0, nan, 0}, {1, 1, 1}});
      },
      "events.region was given a region from (0, nan, 0) to (1, 1, 1)" + says);
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<scenario<bodies<sphere>>> w(link);
    refused<std::invalid_argument>(
        [&] { (void)bodies_within(w, ball_region{.radius = nan}); },
        "bodies_within was given a region from (nan, nan, nan) to (nan, nan, nan)" + says);
    refused<std::invalid_argument>(
        [&] { (void)remove_in(w, ball_region{.radius = -1}); },
        "remove_in was given a region from (1, 1, 1) to (-1, -1, -1)" + says);
  });
}
