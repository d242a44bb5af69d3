// integrator<velocity_verlet> refreshes shadow copies in the middle of the step. What is observed
// between steps is the same on any ranks all the same, while grains slide, after bodies were
// destroyed and added, and after a restart; and an observation changes no bit of the run.
#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <span>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/feature.hpp>
#include <talus/observe.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/force_balance.hpp>
#include <talus/observe/loads.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <vector>

using namespace talus;

namespace {

/// The squares of the forces that a hook sees at the end of the last step, and before its second
/// half. In every second step one rank alone visits contacts.
struct seen_by_hooks {
  using talus_part_of = roles::features;
  static constexpr const char* name = "seen_by_hooks";
  struct state {
    double at_close = 0, after_solve = 0;
  };
  static double squares(auto& stage) {
    double sum = 0;
    stage.for_each_contact([&](const stage_contact& c) {
      if (c.counts_here) sum += c.force.squaredNorm();
    });
    return sum;
  }
  struct hooks {
    static void after_solve(auto& stage) {
      if (visits(stage)) stage.state().after_solve = squares(stage);
    }
    static void at_close(auto& stage) {
      if (visits(stage)) stage.state().at_close = squares(stage);
    }
    static bool visits(const auto& stage) { return stage.steps() % 2 == 1 || stage.rank() == 0; }
  };
};

template <class Decomposition, class... More>
using scene = scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
                       integrator<velocity_verlet>, decomposition<Decomposition>,
                       transport<threads>, features<checkpoints, More...>>;
using walled = scene<grid<dynamic, dynamic>, seen_by_hooks>;
using endless = scene<periodic<grid<dynamic, dynamic>, along::x>, seen_by_hooks>;

constexpr std::uint64_t grains = 48;
constexpr real dt = 2e-4;

template <class Scenario>
struct rank_world {
  world<Scenario> w;

  explicit rank_world(threads::link& link) : w(make(link)) {
    w.material({.density = 2, .restitution = 0.3, .friction = 0.4, .stiffness = 1e4});
    w.gravity({1, 0, -10});
    w.global([&](auto& scope) { ground = scope.add(plane{}, {}); });
  }
  static world<Scenario> make(threads::link& link) {
    const int x = link.size() > 1 ? 2 : 1;
    if constexpr (std::is_same_v<Scenario, walled>)
      return {link, {.cells = {x, link.size() / x}, .lower = {-4, -4}, .upper = {4, 4}}};
    else
      return {link, {{.cells = {x, link.size() / x}, .lower = {-4, -4}, .upper = {4, 4}}}};
  }
  void fill() {
    random_stream random(7, 1);
    for (std::uint64_t k = 0; k < grains; ++k) {
      const auto x = static_cast<real>(k % 4), y = static_cast<real>(k / 4 % 4),
                 z = static_cast<real>(k / 16);
      const vec3 velocity = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
      w.add_if_local(body{.shape = sphere{random.uniform(0.47, 0.52)},
                          .position = {0.98 * x - 1.4, 0.98 * y - 1.6, 0.49 + 0.96 * z},
                          .velocity = velocity,
                          .angular_velocity = 3 * velocity});
    }
    w.synchronize();
  }
  void run(int steps) {
    for (int k = 0; k < steps; ++k) w.step(dt);
  }
  /// Without notice to other ranks.
  void push() {
    w.for_each_local([](auto b) {
      b.set_velocity(b.velocity() + vec3(0.01 * static_cast<real>(value_of(b.id()) % 5), 0, 0));
    });
  }
  handle<plane> ground;
};

/// What observers find, on rank 0.
struct found {
  double residual = 0, worst = 0, borne = 0, mean = 0, at_close = 0, after_solve = 0;
  std::uint64_t contacts = 0;
  std::vector<contact_load> loads;
  vec3 on_ground{0, 0, 0}, torque{0, 0, 0};
  std::string table, digest;
};

template <class Scenario>
found examine(rank_world<Scenario>& here) {
  auto& w = here.w;
  found f;
  f.digest = state_digest(w);
  const contact_residual r = measure_residual(w);
  f.residual = r.value, f.worst = r.max, f.contacts = r.contacts;
  f.borne = measure_force_balance(w).borne;
  f.mean = measure_coordination(w).mean;
  std::vector<system_id> all{here.ground.id};
  for (std::uint64_t k = 1; k <= grains; ++k) all.push_back(detail::id_of_attempt(k));
  f.loads = contact_forces(w, all);
  f.on_ground = contact_force(w, here.ground);
  f.torque = contact_torque(w, here.ground, {0, 0, 0});
  const std::string file = "/tmp/talus_verlet_forces_" + std::to_string(getpid()) + ".csv";
  const data_table contacts = contact_table(w);
  if (w.rank() == 0) {
    contacts.write_csv(file);
    std::ifstream in(file);
    f.table.assign(std::istreambuf_iterator<char>(in), {});
    unlink(file.c_str());
  }
  std::array<double, 2> sums{w.template feature<seen_by_hooks>().at_close,
                             w.template feature<seen_by_hooks>().after_solve};
  w.link().reduce(reduction::sum, std::span(sums));
  f.at_close = sums[0], f.after_solve = sums[1];
  CHECK(state_digest(w) == f.digest);
  return f;
}

void check_same(const found& one, const found& two, bool stepped = true) {
  CHECK(one.digest == two.digest);
  CHECK(one.residual == doctest::Approx(two.residual).epsilon(1e-12));
  CHECK(one.worst == doctest::Approx(two.worst).epsilon(1e-12));
  CHECK(one.contacts == two.contacts);
  CHECK(one.mean == two.mean);
  CHECK(one.on_ground == two.on_ground);
  CHECK(one.torque == two.torque);
  CHECK(one.table == two.table);
  for (std::size_t k = 0; k < one.loads.size(); ++k) {
    CAPTURE(k);
    CHECK(one.loads[k].force == two.loads[k].force);
    CHECK(one.loads[k].torque == two.loads[k].torque);
  }
  if (!stepped) return;
  CHECK(one.borne == two.borne);
  CHECK(one.at_close == doctest::Approx(two.at_close).epsilon(1e-12));
  CHECK(one.after_solve == doctest::Approx(two.after_solve).epsilon(1e-12));
}

/// What is found before the first step, while grains slide, after a body was destroyed and another
/// one added, after more steps, after a restart, after new velocities, and after steps from there.
template <class Scenario>
std::vector<found> observe_over(int before, int after) {
  CAPTURE(before);
  CAPTURE(after);
  const std::string file = "/tmp/talus_verlet_forces_" + std::to_string(getpid()) + ".h5";
  std::vector<found> all;
  const auto note = [&](auto& here) {
    const found f = examine(here);
    if (here.w.rank() == 0) all.push_back(f);
  };
  threads::launch({.ranks = before}, [&](threads::link& link) {
    rank_world<Scenario> here(link);
    here.fill();
    here.push(), note(here);
    here.run(120), note(here);
    here.w.destroy_if([](const auto& b) { return b.id() == detail::id_of_attempt(20); });
    here.w.add_if_local(body{.shape = sphere{0.5}, .position = {-1, -1, 3.2}});
    (void)measure_residual(here.w);  // before neighbours know of it
    here.w.synchronize(), note(here);
    here.run(40), note(here);
    write_checkpoint(here.w, file);
  });
  threads::launch({.ranks = after}, [&](threads::link& link) {
    rank_world<Scenario> here(link);
    read_checkpoint(here.w, file);
    note(here);
    here.push(), note(here);
    here.run(40), note(here);
  });
  unlink(file.c_str());
  return all;
}

template <class Scenario>
void check_any_ranks() {
  const std::vector<found> one = observe_over<Scenario>(1, 1);
  REQUIRE(one.size() == 7);
  CHECK(one[1].contacts > grains);
  CHECK(one[1].residual > 0.1);
  CHECK(one[1].at_close != one[1].after_solve);
  check_same(one[3], one[4], false);
  CHECK(one[4].residual != one[5].residual);
  for (const auto& [before, after] : {std::pair(2, 4), std::pair(4, 2)}) {
    const std::vector<found> more = observe_over<Scenario>(before, after);
    REQUIRE(more.size() == one.size());
    for (std::size_t k = 0; k < one.size(); ++k) {
      CAPTURE(k);
      check_same(one[k], more[k], k != 0 && k != 4 && k != 5);
    }
  }
}

/// What a step of two spheres that touch across ranks sends.
template <class Integrator>
std::uint64_t bytes_of_step() {
  using pair = scenario<bodies<sphere>, soft_contact<linear_spring_dashpot>, integrator<Integrator>,
                        decomposition<grid<dynamic>>, transport<threads>>;
  std::uint64_t bytes = 0;
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<pair> w(link, {.cells = {2}, .lower = {-4}, .upper = {4}});
    w.material({.density = 2, .restitution = 0.3, .stiffness = 1e4});
    for (const int side : {-1, 1})
      w.add_if_local(body{.shape = sphere{0.5}, .position = {0.499 * side, 0, 0}});
    for (int k = 0; k < 10; ++k) {
      const std::uint64_t before = link.counters().bytes;
      w.step(dt);
      if (link.rank() == 0) bytes = link.counters().bytes - before;
    }
  });
  return bytes;
}

}  // namespace

TEST_CASE("shadow copies do not receive the forces of contacts") {
  const std::uint64_t bytes = bytes_of_step<semi_implicit_euler>();
  CHECK(bytes > 0);
  CHECK(bytes_of_step<velocity_verlet>() == bytes);
}

TEST_CASE("observed forces are the same on any ranks, while grains slide and after a restart") {
  check_any_ranks<walled>();
}

TEST_CASE("observed forces across a periodic boundary are the same on any ranks") {
  check_any_ranks<endless>();
}
