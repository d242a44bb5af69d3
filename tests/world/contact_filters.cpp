// Pairs that features<contact_filters>, or the hook may_touch of any feature, keeps apart: no
// contact of theirs acts, and none of another pair is lost, while bodies move over the ranks.
// timeout: 300
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/filters.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <tuple>
#include <utility>
#include <vector>

#include "../tutorial/ranks.hpp"

using namespace talus;
using tutorial::refused;

namespace {

/// Bodies of three kinds, by their ids; the first two ignore each other, and of each kind those
/// whose numbers are 5 apart.
[[nodiscard]] unsigned kind_of(system_id id) { return value_of(id) % 3; }
[[nodiscard]] bool ignore_each_other(system_id a, system_id b) {
  return kind_of(a) + kind_of(b) == 1;
}

/// Counts contacts between bodies of two kinds, at the stage at which they act.
struct witness {
  using talus_part_of = roles::features;
  static constexpr const char* name = "witness";
  struct state {
    std::array<std::uint64_t, 3> contacts{};  ///< of kinds that ignore each other, others, walls
    std::map<std::pair<system_id, system_id>, int> of_pairs;
  };
  struct hooks {
    static void after_solve(auto& stage) {
      stage.for_each_contact([&](const stage_contact& c) {
        if (!c.counts_here) return;
        auto& s = stage.state();
        ++s.contacts[!c.moves_b ? 2 : ignore_each_other(c.a, c.b) ? 0 : 1];
        ++s.of_pairs[{std::min(c.a, c.b), std::max(c.a, c.b)}];
      });
    }
  };
};

using clump = union_of<sphere>;
template <class... More>
using hard_scene =
    scenario<bodies<sphere, box, clump, plane>, hard_contact<coulomb_friction, newton_restitution>,
             solver<coloured_gauss_seidel>,
             decomposition<periodic<grid<dynamic, dynamic>, along::y>>,
             features<contact_filters, witness, checkpoints, orientation, More...>>;
using hard = hard_scene<>;
using followed = hard_scene<continuous_collision>;
using restful = hard_scene<sleeping>;
using springs = scenario<bodies<sphere, box, clump, plane>, soft_contact<linear_spring_dashpot>,
                         decomposition<periodic<grid<dynamic, dynamic>, along::y>>,
                         features<contact_filters, witness, checkpoints, orientation>>;

template <class World>
void fill(World& w, bool by_rules) {
  using scenario_type = typename World::scenario_type;
  material m{.density = 1, .restitution = 0.3, .friction = 0.3};
  if constexpr (scenario_type::contact_law::soft) m.stiffness = 2e3;
  const auto stuff = w.material(m);
  w.gravity({0, 0, -5});
  w.global([&](auto& all) {
    all.add(plane{{0, 0, 1}, 0}, stuff);
    all.add(plane{{1, 0, 0}, -4}, stuff);
    all.add(plane{{-1, 0, 0}, -4}, stuff);
  });
  random_stream random(3);
  for (int k = 0; k < 210; ++k) {
    const vec3 at(-3.3 + 1.1 * (k % 7), -2.4 + 1.2 * (k / 7 % 5), 0.6 + 1.1 * (k / 35));
    const vec3 v = random.uniform(vec3(-4, -4, -2), vec3(4, 4, 2));
    if (k % 4 < 2)
      w.add_if_local(
          body<sphere>{.shape = {0.4}, .position = at, .material = stuff, .velocity = v});
    else if (k % 4 == 2)
      w.add_if_local(
          body<box>{.shape = {{0.7, 0.6, 0.5}}, .position = at, .material = stuff, .velocity = v});
    else
      w.add_if_local(body<clump>{.shape = clump{{{.shape = sphere{0.3}, .at = {{-0.2, 0, 0}}},
                                                 {.shape = sphere{0.3}, .at = {{0.2, 0, 0}}}}},
                                 .position = at,
                                 .material = stuff,
                                 .velocity = v});
  }
  auto& filters = w.template feature<contact_filters>();
  if (by_rules) filters.ignore(contact_group{0}, contact_group{1});
  w.for_each_local([&](auto&& b) {
    b.template set<contact_groups>(1u << kind_of(b.id()));
    if (!by_rules)
      b.template set<contact_mask>(kind_of(b.id()) < 2 ? ~(2u >> kind_of(b.id())) : ~0u);
  });
}

template <class Scenario, class Program>
void on_ranks(int x, int y, Program&& program) {
  CAPTURE(x * y);
  threads::launch({.ranks = x * y}, [&](threads::link& link) {
    world<Scenario> w(
        link,
        typename Scenario::decomposition{{.cells = {x, y}, .lower = {-4, -3}, .upper = {4, 3}}},
        reach{1.2});
    program(w);
  });
}

/// The centres of movable bodies of kinds that ignore each other that are nearer than 0.2.
template <class World>
[[nodiscard]] double count_inside_each_other(World& w) {
  double near = 0;
  w.for_each_local([&](const auto& a) {
    w.for_each_known([&](const auto& b) {
      if (!b.is_global() && a.id() < b.id() && ignore_each_other(a.id(), b.id()))
        near += (a.position() - b.position()).norm() < 0.2;
    });
  });
  w.link().reduce(reduction::sum, std::span(&near, 1));
  return near;
}

}  // namespace

TEST_CASE_TEMPLATE("bodies of groups that ignore each other have no contacts, and others all",
                   Scenario, hard, followed, restful, springs) {
  constexpr bool is_soft = Scenario::contact_law::soft;
  std::string digest, digest_after;
  for (const auto& [x, y, by_rules] :
       {std::tuple{1, 1, false}, {2, 2, false}, {1, 1, true}, {2, 1, true}, {2, 2, true}}) {
    if (is_soft && !by_rules) continue;
    on_ranks<Scenario>(x, y, [&](auto& w) {
      fill(w, by_rules);
      std::string in_the_middle;
      double inside = 0;
      for (int k = 0; k < 240; ++k) {
        w.step(0.005);
        if (k % 10 == 0) inside += count_inside_each_other(w);
        if (k == 119)
          in_the_middle = state_digest(w), (void)write_checkpoint(w, "contact_filters.h5");
      }
      std::array<std::uint64_t, 3> contacts = w.template feature<witness>().contacts;
      w.link().reduce(reduction::sum, std::span<std::uint64_t>(contacts));
      CHECK(contacts[0] == 0);
      CHECK(contacts[1] > 500);
      CHECK(contacts[2] > 500);
      CHECK(inside > 3);
      CHECK(measure_penetration(w).deepest < (is_soft ? 0.6 : 0.15));
      const std::string d = state_digest(w);
      if (w.rank() != 0) return;
      if constexpr (!is_soft) {
        if (w.ranks() > 1) {
          CHECK(in_the_middle == digest);
          CHECK(d == digest_after);
        }
      }
      digest = in_the_middle, digest_after = d;
    });
  }
  // Restarts: the groups, masks and rules are those of the file, not those of the set-up.
  for (const auto& [x, y] : {std::pair{2, 2}, {1, 1}}) {
    on_ranks<Scenario>(x, y, [&](auto& w) {
      fill(w, false);
      w.template feature<contact_filters>().ignore(contact_group{2}, contact_group{2});
      read_checkpoint(w, "contact_filters.h5");
      for (int k = 120; k < 240; ++k) w.step(0.005);
      const std::string d = state_digest(w);
      if (w.rank() == 0 && !is_soft) CHECK(d == digest_after);
      std::array<std::uint64_t, 3> contacts = w.template feature<witness>().contacts;
      w.link().reduce(reduction::sum, std::span<std::uint64_t>(contacts));
      CHECK(contacts[0] == 0);
      CHECK(contacts[1] > 200);
    });
  }
  std::remove("contact_filters.h5");
}

namespace {

using line = scenario<bodies<sphere, box, plane>, hard_contact<coulomb_friction>,
                      decomposition<grid<dynamic>>,
                      features<contact_filters, witness, sleeping, checkpoints>>;

template <class Shape>
using handles = std::vector<std::optional<handle<Shape>>>;

/// Four boxes with even numbers stand on the floor, and onto each of them falls another one.
template <class World>
handles<box> towers(World& w) {
  const auto stuff = w.material({.density = 1, .friction = 0.5});
  w.gravity({0, 0, -10});
  w.global([&](auto& all) { all.add(plane{}, stuff); });
  handles<box> all;
  for (int k = 0; k < 8; ++k) {
    const vec3 at(-1.9 + k / 2, 0, 0.5 + 1.1 * (k % 2));
    all.push_back(
        w.add_if_local(body{.shape = box{{0.8, 0.8, 1}}, .position = at, .material = stuff}));
  }
  return all;
}
template <class World, class Shape>
[[nodiscard]] std::array<double, 8> heights(World& w, const handles<Shape>& all) {
  std::array<double, 8> z{};
  // Bodies fall straight down, and stay with their owners.
  for (std::size_t k = 0; k < 8; ++k)
    if (all[k]) z[k] = w[*all[k]].position()[2];
  w.link().reduce(reduction::sum, std::span<double>(z));
  return z;
}

}  // namespace

TEST_CASE("rules for pairs of bodies hold on any ranks, and wake what sleeps when they change") {
  for (const int ranks : {1, 2, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<line> w(link, {.cells = {ranks}, .lower = {-2}, .upper = {2}}, reach{2});
      const auto all = towers(w);
      w.sleeping({.speed = 0.05, .time = 0.1});
      keep_apart(w, all[0], all[1]);
      for (int k = 0; k < 400; ++k) w.step(0.005);
      auto z = heights(w, all);
      for (const std::size_t k : {0u, 1u, 2u, 4u, 6u})
        CHECK(z[k] == doctest::Approx(0.5).epsilon(0.02));
      for (const std::size_t k : {3u, 5u, 7u}) CHECK(z[k] == doctest::Approx(1.5).epsilon(0.02));
      double asleep = 0;
      w.for_each_local([&](const auto& b) { asleep += b.is_asleep(); });
      w.link().reduce(reduction::sum, std::span(&asleep, 1));
      CHECK(asleep == 8);

      // A rule: the upper one of the second tower falls into the lower one.
      keep_apart(w, all[3], all[2]);
      for (int k = 0; k < 400; ++k) w.step(0.005);
      CHECK(heights(w, all)[3] == doctest::Approx(0.5).epsilon(0.02));
      CHECK(heights(w, all)[5] == doctest::Approx(1.5).epsilon(0.02));
      // A mask: so does that of the third one.
      if (all[5]) w[*all[5]].set<contact_groups>(2);
      if (all[4]) w[*all[4]].set<contact_mask>(1);
      for (int k = 0; k < 400; ++k) w.step(0.005);
      CHECK(heights(w, all)[5] == doctest::Approx(0.5).epsilon(0.02));
      CHECK(heights(w, all)[7] == doctest::Approx(1.5).epsilon(0.02));
      // Only the two of the last tower touch each other: they fall through the floor together.
      only_between(w, all[6], all[7]);
      for (int k = 0; k < 200; ++k) w.step(0.005);
      z = heights(w, all);
      CHECK(z[6] < -3);
      CHECK(z[7] - z[6] == doctest::Approx(1).epsilon(0.02));
      CHECK(z[5] == doctest::Approx(0.5).epsilon(0.02));
      // Pairs that ignore each other do not overlap. Without rules they do.
      CHECK(measure_penetration(w).deepest < 0.1);
      w.feature<contact_filters>().clear();
      CHECK(measure_penetration(w).deepest > 1);
    });
  }
}

TEST_CASE("materials ignore each other, or touch one another alone") {
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<line> w(link, {.cells = {ranks}, .lower = {-2}, .upper = {2}}, reach{2});
      const auto floor = w.material({}), wood = w.material({}), air = w.material({}),
                 glass = w.material({});
      w.gravity({0, 0, -10});
      w.global([&](auto& all) { all.add(plane{}, floor); });
      handles<sphere> all;
      const std::array<material_id, 8> of{wood, wood, wood, air, air, air, glass, wood};
      for (int k = 0; k < 8; ++k) {
        all.push_back(w.add_if_local(body{.shape = sphere{0.5},
                                          .position = {-1.9 + k / 2, 0, 0.5 + 1.1 * (k % 2)},
                                          .material = of[static_cast<std::size_t>(k)]}));
      }
      auto& filters = w.feature<contact_filters>();
      filters.only_between(glass, floor);
      filters.of_material(wood, 1u << 1, ~0u);
      filters.of_material(air, 1u << 2, ~(1u << 1));  // not wood
      filters.only_between(floor, air);
      for (int k = 0; k < 200; ++k) w.step(0.005);
      // The floor touches glass and air: wood falls through it.
      const auto z = heights(w, all);
      for (const std::size_t k : {0u, 1u, 2u, 7u}) CHECK(z[k] < -3);
      CHECK(z[1] - z[0] == doctest::Approx(1.1).epsilon(0.02));
      for (const std::size_t k : {3u, 4u, 6u}) CHECK(z[k] == doctest::Approx(0.5).epsilon(0.02));
      // Air is bound to the floor by the last rule: two of air do not touch.
      CHECK(z[5] == doctest::Approx(0.5).epsilon(0.02));
    });
  }
}

TEST_CASE("a bullet passes through a body that ignores it and stops at the next") {
  using range = scenario<bodies<sphere, box>, hard_contact<>, decomposition<grid<dynamic>>,
                         features<contact_filters, continuous_collision, orientation>>;
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<range> w(link, {.cells = {ranks}, .lower = {-4}, .upper = {4}}, reach{3});
      const auto stuff = w.material({});
      const auto wall = [&](real x) {
        return w.add_if_local(
            body{.shape = box{{0.1, 2, 2}}, .position = {x, 0, 0}, .fixed = true});
      };
      const auto first = wall(-1), second = wall(1);
      wall(3);
      const auto bullet = w.add_if_local(body{.shape = sphere{0.1},
                                              .position = {-3.5, 0, 0},
                                              .material = stuff,
                                              .velocity = {100, 0, 0}});
      keep_apart(w, first, bullet);
      keep_apart(w, bullet, second);
      for (int k = 0; k < 20; ++k) w.step(0.01);
      double x = 0;
      w.for_each_local([&](const auto& b) {
        if (!b.is_fixed()) x = b.position()[0];
      });
      w.link().reduce(reduction::sum, std::span(&x, 1));
      CHECK(x == doctest::Approx(2.85).epsilon(0.02));
    });
  }
}

namespace {

/// A feature of one's own: bodies with the same number of a chain do not touch.
struct chain_number {
  using value_type = std::uint32_t;
  static constexpr const char* name = "chain_number";
  static constexpr talus::travels travel = talus::travels::when_changed;
};
struct chains {
  using talus_part_of = roles::features;
  static constexpr const char* name = "chains";
  using columns = type_list<chain_number>;
  struct hooks {
    static bool may_touch(const auto& pair) {
      const auto of_a = pair.a().template get<chain_number>();
      return of_a == 0 || of_a != pair.b().template get<chain_number>();
    }
  };
};

}  // namespace

TEST_CASE("a feature of one's own keeps pairs apart") {
  using balls =
      scenario<bodies<sphere, plane>, hard_contact<>, transport<serial>, features<chains>>;
  static_assert(detail::world_state<balls>::filters);
  serial::link link;
  world<balls> w(link);
  const auto all = [&] {
    const auto stuff = w.material({});
    w.gravity({0, 0, -10});
    w.global([&](auto& scope) { scope.add(plane{}, stuff); });
    std::array<handle<sphere>, 3> made;
    for (std::size_t k = 0; k < 3; ++k)
      made[k] = w.add(body{.shape = sphere{0.5}, .position = {0, 0, 0.5 + 1.1 * real(k)}});
    return made;
  }();
  for (int k = 0; k < 200; ++k) w.step(0.005);
  CHECK(w[all[2]].position()[2] == doctest::Approx(2.5).epsilon(0.02));
  w[all[0]].set<chain_number>(7), w[all[1]].set<chain_number>(7);
  for (int k = 0; k < 200; ++k) w.step(0.005);
  CHECK(w[all[1]].position()[2] == doctest::Approx(0.5).epsilon(0.02));
  CHECK(w[all[2]].position()[2] == doctest::Approx(1.5).epsilon(0.02));
}

TEST_CASE("rules that cannot hold are refused") {
  contact_filters::state filters;
  refused<std::invalid_argument>([&] { filters.ignore(contact_group{32}, contact_group{1}); },
                                 "contact_filters has the groups 0 to 31, and 32 is not one of "
                                 "them: number the groups from 0");
  refused<std::invalid_argument>(
      [] {
        threads::launch({.ranks = 2}, [](threads::link& link) {
          world<line> w(link, {.cells = {2}, .lower = {-2}, .upper = {2}}, reach{2});
          const auto all = towers(w);
          keep_apart(w, all[0], std::optional<handle<box>>());
        });
      },
      "keep_apart was called with no handle of the second body on any rank: pass what add or "
      "add_if_local returned, on all ranks");
  refused<std::invalid_argument>(
      [] {
        threads::launch({.ranks = 2}, [](threads::link& link) {
          world<line> w(link, {.cells = {2}, .lower = {-2}, .upper = {2}}, reach{2});
          const auto all = towers(w);
          only_between(w, all[0], all[0]);
        });
      },
      "only_between was called with body 4611686018427387905 twice, which does not touch itself: "
      "pass two bodies");
}

TEST_CASE("a scenario without filters stores nothing of them") {
  using bare = scenario<bodies<sphere>, transport<serial>>;
  using state = detail::world_state<bare>;
  static_assert(!state::filters);
  static_assert(!detail::body_store<sphere, type_list<>>::has<contact_groups>);
  CHECK(std::is_empty_v<decltype(state::filtered)>);
  CHECK(std::is_empty_v<detail::slots_of_features<bare::features, bare>>);
  CHECK(detail::body_store<sphere, type_list<contact_filters>>::bytes_per_body() ==
        detail::body_store<sphere, type_list<>>::bytes_per_body() + 8);
}
