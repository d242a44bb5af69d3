// features<events>: each event is told once, on any ranks, while bodies move over them, in periodic
// space, with sleeping bodies and after restarts.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/events.hpp>
#include <talus/observe/monitors.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/each_contact.hpp>
#include <utility>
#include <vector>

#include "../tutorial/ranks.hpp"

using namespace talus;
using tutorial::refused;

namespace {

template <class... More>
using hard_scene =
    scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<coloured_gauss_seidel>,
             decomposition<periodic<grid<dynamic, dynamic>, along::y>>,
             features<events, checkpoints, orientation, More...>>;
using hard = hard_scene<>;
using followed = hard_scene<continuous_collision>;
using restful = hard_scene<sleeping>;
using springs =
    scenario<bodies<sphere, box, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
             decomposition<periodic<grid<dynamic, dynamic>, along::y>>,
             features<events, checkpoints, orientation>>;

template <class World>
void fill(World& w) {
  using scenario_type = typename World::scenario_type;
  material m{.density = 1, .restitution = 0.4, .friction = 0.3};
  if constexpr (scenario_type::contact_law::soft) m.stiffness = 2e3;
  const auto stuff = w.material(m);
  w.gravity({0, 0, -5});
  if constexpr (scenario_type::template has_feature<sleeping>)
    w.sleeping({.speed = 0.3, .time = 0.1});
  w.global([&](auto& all) {
    all.add(plane{{0, 0, 1}, 0}, stuff);
    all.add(plane{{1, 0, 0}, -4}, stuff);
    all.add(plane{{-1, 0, 0}, -4}, stuff);
  });
  random_stream random(3);
  for (int k = 0; k < 140; ++k) {
    const vec3 at(-3.3 + 1.1 * (k % 7), -2.4 + 1.2 * (k / 7 % 5), 0.6 + 1.1 * (k / 35));
    const vec3 v = random.uniform(vec3(-4, -4, -2), vec3(4, 4, 2));
    if (k % 3 < 2)
      w.add_if_local(
          body<sphere>{.shape = {0.4}, .position = at, .material = stuff, .velocity = v});
    else
      w.add_if_local(body<box>{.shape = {{0.7, 0.6, 0.5}},
                               .position = at,
                               .material = stuff,
                               .velocity = v,
                               .fixed = k == 62});
  }
  auto& e = w.template feature<events>();
  e.impacts({.impulse = 0.01, .speed = 2});
  CHECK(e.region(box_region{{-2, -1, 0}, {1, 2, 2}}) == 0);
  CHECK(e.region(half_space{{0, 1, 0}, 0}) == 1);  // its border is the periodic one, too
}

template <class Scenario, class Program>
void on_ranks(int x, int y, Program&& program) {
  CAPTURE(x * y);
  threads::launch({.ranks = x * y}, [&](threads::link& link) {
    world<Scenario> w(
        link,
        typename Scenario::decomposition{{.cells = {x, y}, .lower = {-4, -3}, .upper = {4, 3}}},
        reach{1.2});
    fill(w);
    program(w);
  });
}

using pair = std::pair<system_id, system_id>;
/// Follows the events of all ranks, and compares them with what there is.
struct follower {
  std::set<pair> touching;
  std::map<std::pair<system_id, int>, bool> inside;
  std::array<std::uint64_t, 5> counted{};
  bool after_restart = false;

  template <class World>
  void look(World& w) {
    const std::vector<event> all = all_events(w);
    CHECK(std::is_sorted(all.begin(), all.end()));
    for (const event& e : all) {
      ++counted[static_cast<std::size_t>(e.kind)];
      const pair both(e.a, e.b);
      if (e.kind == event_kind::contact_begins) {
        CHECK(touching.insert(both).second);
        CHECK(e.a < e.b);
        if constexpr (!World::scenario_type::contact_law::soft) CHECK(e.impulse > 0);
      } else if (e.kind == event_kind::contact_ends) {
        CHECK(touching.erase(both) == 1);
      } else if (e.kind == event_kind::impact) {
        CHECK(touching.count(both) == 1);
        CHECK(e.impulse >= 0.01);
        CHECK(e.speed >= 2);
      } else {
        bool& in = inside[{e.a, e.region}];
        CHECK(in == (e.kind == event_kind::leaves));
        in = !in;
      }
    }
    compare(w);
  }
  /// What touches, and what is in a region, on all ranks.
  template <class World>
  void compare(World& w, bool begins = false) {
    std::vector<std::uint64_t> mine;
    if constexpr (!World::scenario_type::contact_law::soft)
      for_each_contact(w, [&](const loaded_contact& c) {
        mine.push_back(value_of(std::min(c.a, c.b))), mine.push_back(value_of(std::max(c.a, c.b)));
      });
    std::vector<std::uint64_t> in;
    w.for_each_local([&](const auto& b) {
      const vec3& p = b.position();
      if (box_region{{-2, -1, 0}, {1, 2, 2}}.contains(p)) in.push_back(2 * value_of(b.id()));
      if (p[1] >= 0) in.push_back(2 * value_of(b.id()) + 1);
    });
    const auto numbers = [&](const std::vector<std::uint64_t>& from) {
      detail::byte_buffer bytes;
      for (const std::uint64_t x : from) detail::byte_writer(bytes).put(x);
      std::vector<std::uint64_t> all;
      for (const auto& each : w.link().gather_all(bytes)) {
        detail::byte_reader reader(each);
        while (!reader.empty()) all.push_back(reader.template get<std::uint64_t>());
      }
      return all;
    };
    std::set<pair> there;
    const auto pairs = numbers(mine);
    for (std::size_t k = 0; k < pairs.size(); k += 2)
      there.insert({system_id{pairs[k]}, system_id{pairs[k + 1]}});
    std::map<std::pair<system_id, int>, bool> now;
    for (const std::uint64_t x : numbers(in))
      now[{system_id{x / 2}, static_cast<int>(x % 2)}] = true;
    if (begins) {
      touching = there, inside = now;
      return;
    }
    if constexpr (!World::scenario_type::contact_law::soft) CHECK(touching == there);
    for (const auto& [where, is] : inside) CHECK(is == (now.count(where) == 1));
  }
};

/// The events of some steps, as text.
template <class World>
std::string story_of(World& w, follower& f, int first, int last, const std::string& file = {}) {
  std::string story;
  for (int k = first; k < last; ++k) {
    w.step(0.005);
    f.look(w);
    for (const event& e : all_events(w)) {
      story += std::to_string(k) + ' ' + std::to_string(int(e.kind)) + ' ' +
               std::to_string(e.region) + ' ' + std::to_string(value_of(e.a)) + ' ' +
               std::to_string(value_of(e.b));
      for (const double x : {e.point[0], e.point[1], e.point[2], e.impulse, e.speed})
        story += ' ' + detail::text(x, 9);
      story += '\n';
    }
    if (!file.empty() && k == 99) (void)write_checkpoint(w, file);
  }
  return story;
}

}  // namespace

TEST_CASE_TEMPLATE("each event is told once, alike on any ranks, and after a restart on others",
                   Scenario, hard, followed, restful, springs) {
  constexpr bool soft = Scenario::contact_law::soft;
  const std::string file = "events.h5";
  std::string first, rest;
  std::array<std::uint64_t, 5> counted{};
  std::set<pair> at_checkpoint;
  for (const auto& [x, y] : {std::pair{1, 1}, {2, 1}, {2, 2}}) {
    on_ranks<Scenario>(x, y, [&](auto& w) {
      follower f;
      w.step(0.005);  // after which the regions of bodies are known
      for (const event& e : all_events(w)) ++f.counted[static_cast<std::size_t>(e.kind)];
      f.compare(w, true);
      const std::string one = story_of(w, f, 0, 100, file);
      const std::set<pair> touching = f.touching;
      const std::string two = story_of(w, f, 100, 240);
      const std::array<std::uint64_t, 5> totals = total_events(w);
      CHECK(totals == f.counted);
      if (w.rank() != 0) return;
      for (const std::uint64_t n : totals) CHECK(n > 20);
      if (!soft && w.ranks() > 1) {
        CHECK(one == first);
        CHECK(two == rest);
      }
      first = one, rest = two, counted = totals, at_checkpoint = touching;
    });
  }
  for (const auto& [x, y] : {std::pair{2, 2}, {1, 2}, {1, 1}}) {
    on_ranks<Scenario>(x, y, [&](auto& w) {
      (void)read_checkpoint(w, file);
      follower f;
      f.compare(w, true);
      if (soft) f.touching = at_checkpoint;
      const std::string two = story_of(w, f, 100, 240);
      if (soft && w.ranks() < 4) return;  // other ranks, other bits
      CHECK(total_events(w) == counted);
      if (w.rank() == 0) CHECK(two == rest);
    });
  }
  std::remove(file.c_str());
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
}
