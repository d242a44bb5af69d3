// features<events>: each event is reported once, on any ranks, while bodies move over them, in
// periodic space, with sleeping bodies and after restarts.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <set>
#include <span>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/events.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/each_contact.hpp>
#include <utility>
#include <vector>

#include "../tutorial/ranks.hpp"

using namespace talus;
using tutorial::refused;

namespace {

using clump = union_of<sphere>;
template <class... More>
using hard_scene =
    scenario<bodies<sphere, box, clump, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<coloured_gauss_seidel>,
             decomposition<periodic<grid<dynamic, dynamic>, along::y>>,
             features<events, checkpoints, orientation, More...>>;
using hard = hard_scene<>;
using followed = hard_scene<continuous_collision>;
using restful = hard_scene<sleeping>;
template <class Integrator>
using soft_scene = scenario<bodies<sphere, box, clump, plane>,
                            soft_contact<linear_spring_dashpot, coulomb_friction>,
                            decomposition<periodic<grid<dynamic, dynamic>, along::y>>,
                            integrator<Integrator>, features<events, checkpoints, orientation>>;
using springs = soft_scene<semi_implicit_euler>;
using verlet = soft_scene<velocity_verlet>;

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
    else if (k % 6 == 5)
      w.add_if_local(body<clump>{.shape = clump{{{.shape = sphere{0.3}, .at = {{-0.15, 0, 0}}},
                                                 {.shape = sphere{0.3}, .at = {{0.15, 0, 0}}}}},
                                 .position = at,
                                 .material = stuff,
                                 .velocity = v});
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
  std::set<pair> loaded;  ///< before the step

  /// Soft contacts act at the positions before the step (Verlet: at those after it).
  template <class World>
  void prepare(World& w) {
    if constexpr (World::scenario_type::contact_law::soft) loaded = contacts_of(w);
  }
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
  template <class World>
  [[nodiscard]] static std::vector<std::uint64_t> from_all(World& w,
                                                           const std::vector<std::uint64_t>& mine) {
    detail::byte_buffer bytes;
    for (const std::uint64_t x : mine) detail::byte_writer(bytes).put(x);
    std::vector<std::uint64_t> all;
    for (const auto& each : w.link().gather_all(bytes)) {
      detail::byte_reader reader(each);
      while (!reader.empty()) all.push_back(reader.template get<std::uint64_t>());
    }
    return all;
  }
  template <class World>
  [[nodiscard]] static std::set<pair> contacts_of(World& w) {
    std::vector<std::uint64_t> mine;
    const auto add = [&](system_id a, system_id b) {
      mine.push_back(value_of(std::min(a, b))), mine.push_back(value_of(std::max(a, b)));
    };
    if constexpr (World::scenario_type::contact_law::soft)  // also while the force vanishes
      detail::observe_forces(detail::state_of(w),
                             [&](const auto& key, const auto&, const vec3&, bool counts) {
                               if (counts) add(key.a, key.b);
                             });
    else
      for_each_contact(w, [&](const loaded_contact& c) { add(c.a, c.b); });
    std::set<pair> there;
    const auto pairs = from_all(w, mine);
    for (std::size_t k = 0; k < pairs.size(); k += 2)
      there.insert({system_id{pairs[k]}, system_id{pairs[k + 1]}});
    return there;
  }
  /// What touches, and what is in a region, on all ranks.
  template <class World>
  void compare(World& w, bool begins = false) {
    using scenario_type = typename World::scenario_type;
    std::vector<std::uint64_t> in;
    w.for_each_local([&](const auto& b) {
      const vec3& p = b.position();
      if (box_region{{-2, -1, 0}, {1, 2, 2}}.contains(p)) in.push_back(2 * value_of(b.id()));
      if (p[1] >= 0) in.push_back(2 * value_of(b.id()) + 1);
    });
    std::map<std::pair<system_id, int>, bool> now;
    for (const std::uint64_t x : from_all(w, in))
      now[{system_id{x / 2}, static_cast<int>(x % 2)}] = true;
    constexpr bool before =
        scenario_type::contact_law::soft && !scenario_type::integrator::shares_midway;
    const std::set<pair> there = before ? loaded : contacts_of(w);
    if (begins) {
      touching = there, inside = now;
      return;
    }
    CHECK(touching == there);
    for (const auto& [where, is] : inside) CHECK(is == (now.count(where) == 1));
  }
};

/// The events of some steps, as text.
template <class World>
std::string story_of(World& w, follower& f, int first, int last, const std::string& file = {}) {
  std::string story;
  for (int k = first; k < last; ++k) {
    f.prepare(w);
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

TEST_CASE_TEMPLATE("each event is reported once, alike on any ranks, after a restart on others too",
                   Scenario, hard, followed, restful, springs, verlet) {
  constexpr bool soft = Scenario::contact_law::soft;
  const std::string file = "events.h5";
  std::string first, rest;
  std::array<std::uint64_t, 5> counted{};
  std::set<pair> at_checkpoint;
  for (const auto& [x, y] : {std::pair{1, 1}, {2, 1}, {2, 2}}) {
    on_ranks<Scenario>(x, y, [&](auto& w) {
      follower f;
      w.synchronize();
      f.prepare(w);
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
      f.loaded = at_checkpoint;
      f.compare(w, true);
      if (soft) f.touching = at_checkpoint;
      const std::string two = story_of(w, f, 100, 240);
      CHECK(f.counted[0] > 20);
      if (soft && w.ranks() < 4) return;  // other ranks, other bits; look() has compared them
      CHECK(total_events(w) == counted);
      if (w.rank() == 0) CHECK(two == rest);
    });
  }
  std::remove(file.c_str());
}
