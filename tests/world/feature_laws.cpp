// The laws of columns and features: each column is sent in its declared mode, and survives
// migration, sorting, removal and checkpoints; hooks act at their stages, in their order.
#include <doctest/doctest.h>

#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/feature.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/slabs.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/shape/box.hpp>
#include <vector>

#include "../../examples/own_feature/heat.hpp"

using namespace talus;
using detail::byte_buffer;

namespace {

struct refreshed {
  using value_type = double;
  static constexpr const char* name = "refreshed";
  static constexpr double initial = -1;
};
struct changed {
  using value_type = std::uint32_t;
  static constexpr const char* name = "changed";
  static constexpr travels travel = travels::when_changed;
};
struct toggled {
  using value_type = std::uint64_t;
  static constexpr const char* name = "toggled";
  static constexpr travels travel = travels::when_changed;
};
struct migrating {
  using value_type = vec3;
  static constexpr const char* name = "migrating";
  static constexpr travels travel = travels::on_migration;
  static inline const vec3 initial{7, 7, 7};
};
struct staying {
  using value_type = std::uint16_t;
  static constexpr const char* name = "staying";
  static constexpr travels travel = travels::never;
  static constexpr bool in_checkpoint = false, in_digest = false;
  static constexpr std::uint16_t initial = 9;
};

/// The value of `refreshed` after a step.
double mark_of(system_id id, std::uint64_t steps) {
  return static_cast<double>(value_of(id) & 0xffff) + 1000. * static_cast<double>(steps);
}

struct marks {
  using talus_part_of = roles::features;
  static constexpr const char* name = "marks";
  using columns = type_list<staying, refreshed, migrating, changed, toggled>;
  struct state {
    std::uint64_t steps = 0;
    void each_number(auto& visit) { visit.largest(largest); }
    double largest = 0;
  };
  struct hooks {
    static void at_close(auto& stage) {
      auto& s = stage.state();
      ++s.steps;
      s.largest = static_cast<double>(s.steps);
      stage.for_each_local([&](const auto& b) {
        b.template set<refreshed>(mark_of(b.id(), stage.steps()));
        if (stage.steps() % 7 == 0) b.template set<toggled>(stage.steps() / 7 + 1);
      });
    }
  };
};

template <class... More>
using scene = scenario<bodies<sphere, box, plane>, decomposition<grid<dynamic, dynamic>>,
                       features<marks, checkpoints, More...>>;
using with_all = scene<user_ids, sleeping, orientation, forces>;
using bare = scene<>;
using soft = scenario<bodies<sphere, plane>, decomposition<grid<dynamic, dynamic>>,
                      soft_contact<linear_spring_dashpot>, integrator<velocity_verlet>,
                      features<energy_ledger, marks, checkpoints, orientation>>;

constexpr real dt = 0.01;

/// Bodies that fly through each other's domains, with a value of their own in each column.
template <class World>
void fill(World& w) {
  using scenario_type = typename World::scenario_type;
  material m{.density = 2, .restitution = 0.5};
  if constexpr (scenario_type::contact_law::soft) m.stiffness = 1e4;
  const auto stuff = w.material(m);
  w.global([&](auto& all) { all.add(plane{{0, 0, 1}, -3}, stuff); });
  const auto motion = [](random_stream& random) {
    return random.uniform(vec3(-3, -3, -1), vec3(3, 3, 1));
  };
  w.fill(
      simple_cubic{.spacing = 1.1, .origin = {0.5, 0.5, 0.5}} & box_region{{-3, -3, -1}, {3, 3, 1}},
      [&](const site& place, random_stream& random) {
        return body{.shape = sphere{0.4},
                    .position = place.position,
                    .material = stuff,
                    .velocity = motion(random)};
      });
  if constexpr (scenario_type::template has_shape<box>)
    w.fill(simple_cubic{.spacing = 1.1, .origin = {0.5, 0.5, 0.5}} &
               box_region{{-3, -3, 1.5}, {3, 3, 2.5}},
           [&](const site& place, random_stream& random) {
             return body{.shape = box{{0.5, 0.4, 0.3}},
                         .position = place.position,
                         .material = stuff,
                         .velocity = motion(random),
                         .angular_velocity = {1, 2, 3}};
           });
  w.for_each_local([&](auto&& b) {
    const auto n = static_cast<std::uint32_t>(value_of(b.id()));
    b.template set<refreshed>(n + 0.5);
    b.template set<changed>(n + 1);
    b.template set<migrating>({real(n), 1, 2});
    b.template set<staying>(static_cast<std::uint16_t>(100 + w.rank()));
  });
}

/// Runs `program(world)` on so many ranks with such bodies.
template <class Scenario, class Program>
void on_ranks(int ranks, Program&& program) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {.lower = {-3, -3}, .upper = {3, 3}});
    fill(w);
    w.synchronize();
    program(w);
  });
}
template <class Scenario, class Program>
void on_four_ranks(Program&& program) {
  on_ranks<Scenario>(4, program);
}

template <class Columns, class Store>
byte_buffer bytes_of(const Store& store, std::size_t i) {
  byte_buffer bytes;
  detail::byte_writer out(bytes);
  store.template each_column<Columns>([&](const auto& c) { out.put(c[i]); });
  return bytes;
}
template <class Store>
using saved = typename detail::columns_by_use<typename Store::list>::saved;
template <class Store, travels Least>
using sent = typename detail::columns_that_travel<typename Store::list, Least>::sent;

/// The values of the own bodies, by id.
template <class World, class Pick>
std::map<std::uint64_t, byte_buffer> own_values(World& w, Pick&& pick) {
  std::map<std::uint64_t, byte_buffer> values;
  talus::detail::state_of(w).each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i)
      values[value_of(b.movable.id[i])] = pick(b.movable, i);
  });
  return values;
}
/// The same of all ranks. Collective.
std::map<std::uint64_t, byte_buffer> of_all_ranks(
    threads::link& link, const std::map<std::uint64_t, byte_buffer>& mine) {
  byte_buffer packed;
  detail::byte_writer out(packed);
  for (const auto& [id, bytes] : mine) {
    out.put(id);
    out.put(std::span<const std::byte>(bytes));
  }
  std::map<std::uint64_t, byte_buffer> all;
  for (const byte_buffer& each : link.gather_all(packed)) {
    detail::byte_reader in(each);
    while (!in.empty()) {
      const auto id = in.get<std::uint64_t>();
      const auto bytes = in.get_all<std::byte>();
      all[id] = byte_buffer(bytes.begin(), bytes.end());
    }
  }
  return all;
}

/// The number of shadow copies; each has the value of its owner, in the columns that are sent so.
template <travels Least, class World>
std::size_t copies_agree(World& w) {
  const auto pick = [](const auto& store, std::size_t i) {
    return bytes_of<sent<std::remove_cvref_t<decltype(store)>, Least>>(store, i);
  };
  const auto owners = of_all_ranks(w.link(), own_values(w, pick));
  std::size_t copies = 0;
  talus::detail::state_of(w).each_finite_shape([&](const auto& b) {
    for (std::size_t i = b.movable.locals; i < b.movable.size(); ++i, ++copies) {
      const auto owner = owners.find(value_of(b.movable.id[i]));
      REQUIRE(owner != owners.end());
      CHECK(owner->second == pick(b.movable, i));
    }
  });
  return copies;
}

}  // namespace

TEST_CASE_TEMPLATE("a shadow copy has the columns that travel to it, and the defaults of others",
                   Scenario, with_all, bare) {
  on_four_ranks<Scenario>([](auto& w) {
    CHECK(copies_agree<travels::when_changed>(w) > 0);
    for (int k = 0; k < 40; ++k) {
      w.step(dt);
      CHECK(copies_agree<travels::with_every_refresh>(w) > 0);
      w.for_each_known([&](const auto& b) {
        if (b.is_global()) return;
        CHECK(b.template get<refreshed>() == mark_of(b.id(), w.steps() - 1));
        CHECK(b.template get<changed>() == static_cast<std::uint32_t>(value_of(b.id())) + 1);
        CHECK(b.template get<toggled>() == (w.steps() - 1) / 7 + 1);
        if (!b.is_remote()) return;
        CHECK(b.template get<migrating>() == migrating::initial);
        CHECK(b.template get<staying>() == staying::initial);
      });
    }
  });
}

TEST_CASE("a column that travels when something has changed does so then, and not before") {
  threads::launch({.ranks = 2}, [](threads::link& link) {
    using line = scenario<bodies<sphere>, decomposition<slabs<2>>, features<marks>>;
    world<line> w(link, slabs<2>{.lower = -2, .upper = 2});
    const auto stuff = w.material({.density = 1});
    w.add_if_local(body{.shape = sphere{0.5}, .position = {-0.6, 0, 0}, .material = stuff});
    const auto other =
        w.add_if_local(body{.shape = sphere{0.5}, .position = {0.6, 0, 0}, .material = stuff});
    w.synchronize();
    const auto copy = [&] {
      std::uint32_t seen = 77;
      w.for_each_known([&](const auto& b) {
        if (b.is_remote()) seen = b.template get<changed>();
      });
      return seen;
    };
    for (int k = 0; k < 3; ++k) w.step(dt);
    CHECK(copy() == 0);
    // Bypassing the world, as no user can:
    auto& store = talus::detail::state_of(w).template of<sphere>().movable;
    store.template column<changed>()[0] = 5;
    w.step(dt);
    CHECK(copy() == 0);
    if (other) w[*other].template set<changed>(6);
    w.step(dt);
    if (w.rank() == 0) CHECK(copy() == 6);
  });
}

TEST_CASE_TEMPLATE("a body that migrates takes its columns along, but those that stay", Scenario,
                   with_all, bare, soft) {
  on_four_ranks<Scenario>([](auto& w) {
    for (int k = 0; k < 80; ++k) w.step(dt);
    std::array<std::uint64_t, 2> moved{};
    w.for_each_local([&](const auto& b) {
      const auto n = static_cast<std::uint32_t>(value_of(b.id()));
      CHECK(b.template get<refreshed>() == mark_of(b.id(), w.steps() - 1));
      CHECK(b.template get<changed>() == n + 1);
      CHECK(b.template get<migrating>() == vec3(real(n), 1, 2));
      const auto stayed = b.template get<staying>();
      CHECK((stayed == 100 + w.rank() || stayed == staying::initial));
      ++moved[stayed == staying::initial];
    });
    w.link().reduce(reduction::sum, std::span(moved));
    CHECK(moved[0] > 0);
    CHECK(moved[1] > 0);
  });
}

TEST_CASE_TEMPLATE("sorting and removal leave each body its columns", Scenario, with_all, bare,
                   soft) {
  on_four_ranks<Scenario>([](auto& w) {
    const auto pick = [](const auto& store, std::size_t i) {
      return bytes_of<typename std::remove_cvref_t<decltype(store)>::list>(store, i);
    };
    for (int k = 0; k < 5; ++k) w.step(dt);
    auto before = own_values(w, pick);
    talus::detail::state_of(w).each_finite_shape([](auto& b) {
      detail::plain_vector<std::uint32_t> order(b.movable.locals);
      for (std::size_t k = 0; k < order.size(); ++k)
        order[k] = static_cast<std::uint32_t>(order.size() - 1 - k);
      b.movable.permute_locals(order);
    });
    talus::detail::state_of(w).changed = true;
    CHECK(own_values(w, pick) == before);
    const auto odd = [](const auto& b) { return value_of(b.id()) % 2 == 1; };
    CHECK(w.destroy_if(odd) > 0);
    std::erase_if(before, [](const auto& b) { return b.first % 2 == 1; });
    CHECK(own_values(w, pick) == before);
    w.synchronize();
    CHECK(copies_agree<travels::when_changed>(w) > 0);
    CHECK(own_values(w, pick) == before);
  });
}

TEST_CASE_TEMPLATE("a checkpoint holds the columns that say so, and the state of features",
                   Scenario, with_all, bare, soft) {
  const std::string file = "feature_laws.h5";
  std::map<std::uint64_t, byte_buffer> written, read;
  std::string digest, digest_read;
  const auto pick = [](const auto& store, std::size_t i) {
    return bytes_of<saved<std::remove_cvref_t<decltype(store)>>>(store, i);
  };
  on_four_ranks<Scenario>([&](auto& w) {
    for (int k = 0; k < 20; ++k) w.step(dt);
    write_checkpoint(w, file);
    const auto all = of_all_ranks(w.link(), own_values(w, pick));
    const std::string d = state_digest(w);
    if (w.rank() == 0) written = all, digest = d;
  });
  for (const int ranks : {4, 1}) {
    on_ranks<Scenario>(ranks, [&](auto& w) {
      read_checkpoint(w, file);
      const auto all = of_all_ranks(w.link(), own_values(w, pick));
      const std::string d = state_digest(w);
      if (w.rank() == 0) read = all, digest_read = d;
      CHECK(w.template feature<marks>().largest == 20);
      w.for_each_local([](const auto& b) { CHECK(b.template get<staying>() == staying::initial); });
    });
    CHECK(read == written);
    CHECK(digest_read == digest);
  }
  CHECK(written.size() > 50);
  std::remove(file.c_str());
}

TEST_CASE("the digest holds the columns that say so") {
  on_four_ranks<bare>([](auto& w) {
    const std::string before = state_digest(w);
    w.for_each_local([](auto&& b) { b.template set<staying>(1); });
    CHECK(state_digest(w) == before);
    w.for_each_local([&](auto&& b) {
      if (w.rank() == 2) b.template set<changed>(3);
    });
    CHECK(state_digest(w) != before);
  });
}

namespace {

std::vector<std::string> said;

struct later;
struct sooner {
  using talus_part_of = roles::features;
  static constexpr const char* name = "sooner";
  struct hooks {
    static void at_start(auto&) { said.push_back("sooner at_start"); }
    static void at_end(auto&) { said.push_back("sooner at_end"); }
  };
};
struct later {
  using talus_part_of = roles::features;
  static constexpr const char* name = "later";
  using runs_after = type_list<sooner>;
  struct hooks {
    static void at_start(auto& s) {
      CHECK(s.steps() == 0);
      said.push_back("later at_start");
    }
    static void before_detect(auto&) { said.push_back("before_detect"); }
    static void after_detect(auto&) { said.push_back("after_detect"); }
    static void after_solve(auto&) { said.push_back("after_solve"); }
    static void after_move(auto&) { said.push_back("after_move"); }
    static void at_close(auto&) { said.push_back("at_close"); }
    static void before_share(auto&) { said.push_back("before_share"); }
    static void after_share(auto&) { said.push_back("after_share"); }
    static void at_end(auto& s) {
      CHECK(s.steps() == 1);
      CHECK(s.time() == s.dt());
      said.push_back("later at_end");
    }
  };
};

template <class Scenario>
std::vector<std::string> stages_of_step() {
  said.clear();
  threads::launch({.ranks = 1}, [](threads::link& link) {
    world<Scenario> w(link);
    w.step(dt);
  });
  return said;
}
using stage_names = std::vector<std::string>;

}  // namespace

TEST_CASE("hooks act at their stages, features in the order that they ask for") {
  CHECK(stages_of_step<scenario<features<later, sooner>>>() ==
        stage_names{"sooner at_start", "later at_start", "before_detect", "after_detect",
                    "after_solve", "after_move", "at_close", "before_share", "after_share",
                    "sooner at_end", "later at_end"});
  CHECK(stages_of_step<
            scenario<features<later, sooner>, bodies<sphere>, soft_contact<linear_spring_dashpot>,
                     integrator<velocity_verlet>>>() ==
        stage_names{"sooner at_start", "later at_start", "after_move", "before_share",
                    "after_share", "before_detect", "after_detect", "after_solve", "at_close",
                    "sooner at_end", "later at_end"});
}

TEST_CASE("heat flows through soft contacts by the size of their area (Batchelor, O'Brien)") {
  threads::launch({.ranks = 1}, [](threads::link& link) {
    using pair = scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot>,
                          features<heat, orientation>>;
    world<pair> w(link);
    const auto steel = w.material({.density = 1, .restitution = 0.5, .stiffness = 1e4});
    const real r = 0.5, overlap = 0.01, step = 2 * r - overlap;
    const int n = 6;
    handle<plane> left, right;
    w.global([&](auto& scope) {
      left = scope.add(plane{{1, 0, 0}, 0}, steel);
      right = scope.add(plane{{-1, 0, 0}, overlap - n * step}, steel);
    });
    w[left].set<temperature>(400), w[left].set<reservoir>(1);
    w[right].set<temperature>(300), w[right].set<reservoir>(1);
    for (int k = 0; k < n; ++k) w.add(sphere{r}, steel, {r - overlap + k * step, 0, 0});
    w.feature<heat>().conductivity = 50;
    const double before = thermal_energy(w);
    for (int k = 0; k < 6000; ++k) w.step(0.002);
    const double between = 2 * 50 * std::sqrt(0.5 * r * overlap),
                 at_wall = 2 * 50 * std::sqrt(r * overlap);
    const double flow = 100 / (2 / at_wall + (n - 1) / between);
    w.for_each_local([&](const auto& ball) {
      const double k = std::round((ball.position()[0] - r + overlap) / step);
      const double wanted = 400 - flow * (1 / at_wall + k / between);
      CHECK(ball.template get<temperature>() == doctest::Approx(wanted).epsilon(1e-9));
    });
    CHECK(thermal_energy(w) - before == doctest::Approx(heat_given(w)).epsilon(1e-9));
  });
}
