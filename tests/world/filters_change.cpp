// Filters that change during a run: when a change acts, what it costs, and what a checkpoint holds.
// timeout: 120
// alone
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/filters.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <vector>

#include "../tutorial/ranks.hpp"

using namespace talus;
using tutorial::refused;

namespace {

using awake = scenario<bodies<sphere, plane>, hard_contact<>, decomposition<grid<dynamic>>,
                       features<contact_filters, forces, checkpoints>>;
using restful = scenario<bodies<sphere, plane>, hard_contact<>, decomposition<grid<dynamic>>,
                         features<contact_filters, sleeping, checkpoints>>;

template <class Scenario, class Program>
void on_ranks(int ranks, Program&& program) {
  CAPTURE(ranks);
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {.cells = {ranks}, .lower = {-2}, .upper = {2}}, reach{2});
    program(w);
  });
}

using handles = std::vector<std::optional<handle<sphere>>>;

/// Two spheres one on the other, at the border of two ranks, and others at rest on the floor.
template <class World>
handles tower(World& w) {
  const auto stuff = w.material({});
  w.gravity({0, 0, -10});
  w.global([&](auto& all) { all.add(plane{}, stuff); });
  handles all;
  for (const auto& [x, z] : {std::pair{-0.1, 0.5}, {-0.1, 1.5}, {-1.5, 0.5}, {1.5, 0.5}})
    all.push_back(
        w.add_if_local(body{.shape = sphere{0.5}, .position = {x, 0, z}, .material = stuff}));
  return all;
}
template <class World>
[[nodiscard]] double height(World& w, const std::optional<handle<sphere>>& of) {
  double z = of ? double(w[*of].position()[2]) : 0;
  w.link().reduce(reduction::sum, std::span(&z, 1));
  return z;
}

}  // namespace

TEST_CASE("a mask that is set before simulate(), or at a step with a checkpoint, acts at once") {
  for (const int ranks : {1, 2}) {
    on_ranks<awake>(ranks, [&](auto& w) {
      const handles all = tower(w);
      w.simulate({.steps = 50, .dt = 0.005});
      CHECK(height(w, all[1]) == doctest::Approx(1.5).epsilon(0.02));
      if (all[1]) w[*all[1]].template set<contact_mask>(0);
      w.simulate({.steps = 200, .dt = 0.005});
      CHECK(height(w, all[1]) < -1);
      // The other one, at a checkpoint: its floor no longer bears it.
      if (all[0]) w[*all[0]].template set<contact_mask>(0);
      write_checkpoint(w, "filters_change.h5");
      for (int k = 0; k < 200; ++k) w.step(0.005);
      CHECK(height(w, all[0]) < -1);
      CHECK(height(w, all[2]) == doctest::Approx(0.5).epsilon(0.02));
    });
  }
  std::remove("filters_change.h5");
}

TEST_CASE(
    "a rule that is set while bodies sleep, right before a checkpoint, acts after a restart") {
  std::string digest;
  on_ranks<restful>(2, [&](auto& w) {
    const handles all = tower(w);
    w.sleeping({.speed = 0.05, .time = 0.1});
    for (int k = 0; k < 200; ++k) w.step(0.005);
    double asleep = 0;
    w.for_each_local([&](const auto& b) { asleep += b.is_asleep(); });
    w.link().reduce(reduction::sum, std::span(&asleep, 1));
    REQUIRE(asleep == 4);
    keep_apart(w, all[0], all[1]);
    write_checkpoint(w, "filters_change.h5");
    for (int k = 0; k < 200; ++k) w.step(0.005);
    CHECK(height(w, all[1]) == doctest::Approx(0.5).epsilon(0.02));
    const std::string d = state_digest(w);
    if (w.rank() == 0) digest = d;
  });
  for (const int ranks : {2, 1}) {
    on_ranks<restful>(ranks, [&](auto& w) {
      const handles all = tower(w);
      w.sleeping({.speed = 0.05, .time = 0.1});
      w.synchronize();  // the rules of the set-up are not those of the file
      read_checkpoint(w, "filters_change.h5");
      for (int k = 0; k < 200; ++k) w.step(0.005);
      double highest = 0;
      w.for_each_local([&](const auto& b) { highest = std::max(highest, b.position()[2]); });
      w.link().reduce(reduction::max, std::span(&highest, 1));
      CHECK(highest == doctest::Approx(0.5).epsilon(0.02));
      const std::string d = state_digest(w);
      if (w.rank() == 0 && ranks == 2) CHECK(d == digest);
    });
  }
  std::remove("filters_change.h5");
}

TEST_CASE("a restart of sleeping bodies wakes none of them for rules of the set-up") {
  for (const bool rule : {false, true}) {
    on_ranks<restful>(1, [&](auto& w) {
      const handles all = tower(w);
      w.sleeping({.speed = 0.05, .time = 0.1});
      if (rule) keep_apart(w, all[2], all[3]);
      if (!rule) {
        for (int k = 0; k < 200; ++k) w.step(0.005);
        write_checkpoint(w, "filters_change.h5");
      } else {
        w.step(0.005);
        read_checkpoint(w, "filters_change.h5");
        w.step(0.005);
        int asleep = 0;
        w.for_each_local([&](const auto& b) { asleep += b.is_asleep(); });
        CHECK(asleep == 4);
      }
    });
  }
  std::remove("filters_change.h5");
}

TEST_CASE("only what may_touch reads makes a step search for pairs anew") {
  on_ranks<awake>(1, [&](auto& w) {
    const handles all = tower(w);
    for (int k = 0; k < 50; ++k) w.step(0.005);
    const auto& found = detail::state_of(w).found;
    const std::uint64_t before = found.searches;
    for (int k = 0; k < 20; ++k) {
      w[*all[1]].add_force({0, 0, -0.1});
      w.step(k < 10 ? 0.005 : 0.0051);
    }
    CHECK(found.searches == before);
    w[*all[1]].template set<contact_groups>(5);
    w.step(0.005);
    CHECK(found.searches == before + 1);
    w[*all[3]].fix();  // may_touch reads is_fixed()
    w.step(0.005);
    CHECK(found.searches == before + 2);
  });
}

TEST_CASE("a rule that is there already changes nothing") {
  contact_filters::state filters;
  const auto changes = [&](auto&& call) {
    const std::uint64_t before = filters.revision();
    call();
    return filters.revision() != before;
  };
  const material_id stone{0}, glass{1};
  for (const bool first : {true, false}) {
    CHECK(changes([&] { filters.ignore(contact_group{1}, contact_group{2}); }) == first);
    CHECK(!changes([&] { filters.ignore(contact_group{2}, contact_group{1}); }));
    CHECK(changes([&] { filters.only_between(stone, glass); }) == first);
    CHECK(changes([&] { filters.of_material(glass, 2, 3); }) == first);
    CHECK(!changes([&] { filters.of_material(stone, 1, ~0u); }));  // as without the call
  }
  CHECK(changes([&] { filters.of_material(glass, 1, ~0u); }));
  CHECK(changes([&] { filters.clear(); }));
  CHECK(!changes([&] { filters.clear(); }));
}

TEST_CASE("a pair that ignores each other and is to touch alone is refused") {
  contact_filters::state filters;
  const std::string words =
      " ignore each other, and that they touch each other and nothing else: leave one of the two "
      "rules out, or call clear() between them";
  filters.ignore(contact_group{1}, contact_group{2});
  refused<std::invalid_argument>([&] { filters.only_between(contact_group{2}, contact_group{1}); },
                                 "contact_filters was told that the groups 2 and 1" + words);
  filters.only_between(material_id{0}, material_id{1});
  refused<std::invalid_argument>([&] { filters.ignore(material_id{0}, material_id{1}); },
                                 "contact_filters was told that the materials 0 and 1" + words);
  filters.clear();
  filters.only_between(contact_group{2}, contact_group{1});
}

TEST_CASE("a rule on a material that does not exist is refused in the next step, on all ranks") {
  for (const int ranks : {1, 2})
    for (const bool masks : {true, false})
      refused<std::invalid_argument>(
          [&] {
            on_ranks<awake>(ranks, [&](auto& w) {
              (void)tower(w);
              auto& filters = w.template feature<contact_filters>();
              filters.ignore(material_id{0}, material_id{0});  // that of tower()
              w.step(0.01);
              if (masks)
                filters.of_material(material_id{77}, 2, 3);
              else
                filters.ignore(material_id{77}, material_id{0});
              w.step(0.01);
            });
          },
          "contact_filters has a rule on material 77, which is unknown to this world, which has 1: "
          "pass what world.material(...) returned");
}

TEST_CASE("rules of bodies that are destroyed are forgotten, and those of others hold") {
  for (const int ranks : {1, 2, 4})
    on_ranks<awake>(ranks, [&](auto& w) {
      const auto all = tower(w);
      w.synchronize();
      keep_apart(w, all[0], all[1]);
      auto& filters = w.template feature<contact_filters>();
      std::size_t most = 0;
      for (int k = 0; k < 1000; ++k) {
        const auto passing = w.add_if_local(
            body{.shape = sphere{0.1}, .position = {-1.9 + 0.003 * k, 0, 9}, .material = {}});
        w.synchronize();
        keep_apart(w, passing, all[0]);
        if (k % 100 == 7) only_between(w, passing, all[2]);
        most = std::max(most, filters.rules_of_bodies());
        if (const auto here = passing ? w.find(*passing) : std::nullopt; here && !here->is_remote())
          w.destroy(*passing);
        w.synchronize();
      }
      CHECK(most < 300);
      CHECK(most > 20);
      for (int k = 0; k < 40; ++k) w.step(0.01);
      CHECK(height(w, all[1]) < 1.45);  // it falls through the other
    });
}

TEST_CASE("a rule about different bodies on different ranks is refused") {
  refused<std::invalid_argument>(
      [] {
        on_ranks<restful>(2, [](auto& w) {
          const handles all = tower(w);
          keep_apart(w, all[0], w.rank() == 0 ? all[2] : all[3]);
        });
      },
      "keep_apart was called with different bodies as the second one on different ranks: pass "
      "handles of one body, or empty ones, on all ranks");
}

namespace {

struct colour {
  using value_type = std::uint32_t;
  static constexpr const char* name = "colour";
  static constexpr talus::travels travel = talus::travels::when_changed;
};
/// Changes the colour of bodies in each step; those of one colour do not touch.
template <bool Early>
struct chameleons {
  using talus_part_of = roles::features;
  static constexpr const char* name = "chameleons";
  using columns = type_list<colour>;
  struct hooks {
    static void before_detect(auto& stage) {
      if constexpr (Early) change(stage);
    }
    static void after_detect(auto& stage) {
      if constexpr (!Early) change(stage);
    }
    static bool may_touch(const auto& pair) {
      return pair.a().template get<colour>() != pair.b().template get<colour>();
    }
    static void change(auto& stage) {
      const auto step = static_cast<std::uint32_t>(stage.steps());
      stage.for_each_local([&](auto&& b) {
        if (b.id() == first_of(stage)) b.template set<colour>(step % 40 < 20);
      });
    }
    static system_id first_of(auto& stage) {
      system_id first = no_id;
      stage.for_each_known([&](const auto& b) {
        if (!b.is_global() && b.id() < first) first = b.id();
      });
      return first;
    }
  };
};
template <bool Early>
using changing = scenario<bodies<sphere>, hard_contact<>, decomposition<grid<dynamic>>,
                          features<chameleons<Early>>>;

template <bool Early>
[[nodiscard]] std::array<double, 2> push(int ranks) {
  std::array<double, 2> momentum_and_place{};
  on_ranks<changing<Early>>(ranks, [&](auto& w) {
    const auto stuff = w.material({.density = 1});
    for (const int side : {-1, 1})
      w.add_if_local(body{.shape = sphere{0.5},
                          .position = {0.499 * side, 0, 0},
                          .material = stuff,
                          .velocity = {side < 0 ? 0.3 : 0, 0, 0}});
    w.for_each_local([](auto&& b) { b.template set<colour>(1); });
    for (int k = 0; k < 60; ++k) w.step(0.005);
    std::array<double, 2> sums{};
    w.for_each_local([&](const auto& b) {
      sums[0] += b.velocity()[0], sums[1] += b.velocity()[0] * b.position()[0];
    });
    w.link().reduce(reduction::sum, std::span<double>(sums));
    if (w.rank() == 0) momentum_and_place = sums;
  });
  return momentum_and_place;
}

}  // namespace

TEST_CASE("a hook that changes a filter before contacts are found is refused, after that it acts") {
  const auto one = push<false>(1), two = push<false>(2);
  CHECK(one[0] == doctest::Approx(0.3));
  CHECK(two[0] == doctest::Approx(0.3));
  CHECK(one[1] == doctest::Approx(two[1]));
  refused<std::logic_error>(
      [] { (void)push<true>(1); },
      "a hook has set the column colour of body 0x4000000000000000 before the contacts of the "
      "step are found, but neighbours receive it after that, so that ranks would differ about "
      "which bodies touch: set it at after_detect or a later stage");
}
