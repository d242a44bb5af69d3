// features<sleeping>: resting islands are put to sleep, on all ranks alike; islands that are
// touched wake, and continue from their state.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <set>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/fluid.hpp>
#include <talus/scene/force_field.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using scene = scenario<bodies<sphere, box, plane>, features<sleeping, forces, energy_ledger>,
                       decomposition<grid<dynamic>>, transport<threads>>;
using scene_world = world<scene>;
constexpr real dt = 0.005;

grid<dynamic> slabs_of(int ranks, real width = 16) {
  return {.cells = {ranks}, .lower = {0}, .upper = {width}};
}

/// Runs program(world) on each of `ranks` ranks that divide 0 <= x <= 16.
template <class Program>
void on(int ranks, Program&& program) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    scene_world w(link, slabs_of(ranks));
    w.material({.restitution = 0, .friction = 0.5});
    program(w);
  });
}
template <class World>
double sum_of(World& w, double mine) {
  w.link().reduce(reduction::sum, std::span(&mine, 1));
  return mine;
}
double asleep(scene_world& w) { return static_cast<double>(measure_motion(w).asleep); }
/// Bodies of one island, by a user's mark: they have y above or below 5.
double asleep_beyond(scene_world& w) {
  double count = 0;
  w.for_each_local([&](const auto& b) { count += b.is_asleep() && b.position()[1] > 5; });
  return sum_of(w, count);
}
void run(scene_world& w, int steps) {
  for (int k = 0; k < steps; ++k) w.step(dt);
}

handle<plane> floor_of(scene_world& w) {
  handle<plane> h;
  w.gravity({0, 0, -10});
  w.global([&](auto& s) { h = s.add(plane{.normal = {0, 0, 1}}, {}); });
  return h;
}
/// A row of boxes, likewise, and one that slides towards it.
void struck_row(scene_world& w) {
  for (int k = 0; k < 16; ++k)
    w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {k + 0.5, 0, 0.5}});
}
void strike(scene_world& w) {
  w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {-1, 0, 0.5}, .velocity = {4, 0, 0}});
}
/// A row of spheres that touch each other, through all slabs.
std::vector<std::optional<handle<sphere>>> row_at(scene_world& w, real y, real z) {
  std::vector<std::optional<handle<sphere>>> row;
  for (int k = 0; k < 16; ++k)
    row.push_back(w.add_if_local(body{.shape = sphere{0.5}, .position = {k + 0.5, y, z}}));
  return row;
}

}  // namespace

TEST_CASE("an island sleeps as of the same step, on any number of ranks") {
  std::set<int> first;
  for (const int ranks : {1, 2, 4})
    on(ranks, [&](scene_world& w) {
      floor_of(w);
      w.sleeping({.speed = 0.05, .time = 0.1});
      row_at(w, 0, 0.5);
      // A moving one starts in the last slab and keeps all awake.
      if (const auto h = w.add_if_local(
              body{.shape = box{{1, 1, 1}}, .position = {15.5, 1, 0.5}, .velocity = {0, 0, 1}}))
        w[*h].set_velocity({0, 0, 1});
      int step = 0;
      double some = 0;
      while (some == 0 && step < 400) run(w, 1), ++step, some = asleep(w);
      CHECK(some == 17);
      if (w.rank() == 0) first.insert(step);
      const auto before = state_digest(w);
      run(w, 200);
      CHECK(asleep(w) == 17);
      CHECK(state_digest(w) == before);
    });
  CHECK(first.size() == 1);
  CHECK(*first.begin() > 0.1 / dt);
}

TEST_CASE("an impact wakes its island on all ranks, no other one, and keeps its momentum") {
  for (const int ranks : {1, 2, 4})
    on(ranks, [&](scene_world& w) {
      w.sleeping({.speed = 0.05, .time = 0.1});
      w.solver().tolerance = 1e-12, w.solver().max_iterations = 20000;
      row_at(w, 0, 0), row_at(w, 10, 0);
      run(w, 40);
      REQUIRE(asleep(w) == 32);
      w.add_if_local(body{.shape = sphere{0.5}, .position = {-1, 0, 0}, .velocity = {4, 0, 0}});
      double energy = 1e9;
      int woken_at = 0, moved_at = 0;
      for (int k = 1; k <= 60; ++k) {
        w.step(dt);
        const motion m = measure_motion(w);
        const double mass = m.mass / 33;
        CHECK(std::abs(m.momentum[0] - 4 * mass) < 1e-12);
        CHECK(m.kinetic_energy <= energy * (1 + 1e-9));
        energy = m.kinetic_energy;
        if (woken_at == 0 && m.asleep == 16) woken_at = k;
        double last = 0;
        w.for_each_local([&](const auto& b) {
          if (b.position()[0] > 15 && b.position()[1] < 5) last = b.velocity()[0];
        });
        if (moved_at == 0 && sum_of(w, last) > 0.01) moved_at = k;
      }
      CHECK(woken_at > 10);
      CHECK(moved_at >= woken_at);
      CHECK(asleep_beyond(w) == 16);
      CHECK(measure_energy(w).worst < 1e-11);
    });
}

TEST_CASE("an island that sleeps until it is struck ends up as one that never slept") {
  for (const int ranks : {1, 2, 4}) {
    std::map<system_id, vec3> velocity[2];
    std::mutex one_at_a_time;
    for (const bool sleeps : {false, true})
      on(ranks, [&](scene_world& w) {
        w.sleeping({.speed = 0.05, .time = sleeps ? 0.1 : 1e9});
        w.solver().tolerance = 1e-12, w.solver().max_iterations = 20000;
        row_at(w, 0, 0);
        run(w, 40);
        REQUIRE(asleep(w) == (sleeps ? 16 : 0));
        w.add_if_local(body{.shape = sphere{0.5}, .position = {-1, 0, 0}, .velocity = {4, 0, 0}});
        run(w, 60);
        const std::lock_guard lock(one_at_a_time);
        w.for_each_local([&](const auto& b) { velocity[sleeps][b.id()] = b.velocity(); });
      });
    real most = 0;
    for (const auto& [id, v] : velocity[0]) most = std::max(most, (v - velocity[1].at(id)).norm());
    CHECK(velocity[0].size() == 17);
    CHECK(most < 1e-8);
  }
}

TEST_CASE("alone, a rank wakes in the very step what is struck without warning") {
  using serial_scene = scenario<bodies<sphere>, features<sleeping>, transport<serial>>;
  static_assert(world<serial_scene>::link_type::alone);
  serial::link link;
  world<serial_scene> w(link);
  w.material({.restitution = 0, .friction = 0});
  w.sleeping({.speed = 0.05, .time = 0.1});
  w.solver().tolerance = 1e-12, w.solver().max_iterations = 20000;
  handle<sphere> last;
  for (int k = 0; k < 8; ++k) last = w.add(body{.shape = sphere{0.5}, .position = {real(k), 0, 0}});
  for (int k = 0; k < 40; ++k) w.step(dt);
  REQUIRE(measure_motion(w).asleep == 8);
  const auto ball =
      w.add(body{.shape = sphere{0.5}, .position = {-1.001, 0, 0}, .velocity = {4, 0, 0}});
  w.step(dt);
  const motion m = measure_motion(w);
  CHECK(m.asleep == 0);
  CHECK(m.momentum[0] == doctest::Approx(4 * w[ball].mass()).epsilon(1e-12));
  CHECK(w[ball].velocity()[0] < 3);
  CHECK(w[last].velocity()[0] > 0.1);
}

TEST_CASE("what the user does wakes the island it concerns, on all ranks, and no other") {
  using action = void (*)(scene_world&, std::vector<std::optional<handle<sphere>>>&);
  const std::map<std::string, action> actions{
      {"a force",
       [](scene_world& w, auto& row) {
         if (row[3]) w[*row[3]].add_force({0, 0, 1});
       }},
      {"a velocity",
       [](scene_world& w, auto& row) {
         if (row[3]) w[*row[3]].set_velocity({0, 0, 0});
       }},
      {"a removal",
       [](scene_world& w, auto& row) {
         if (row[3]) w.destroy(*row[3]);
       }},
      {"an insertion",
       [](scene_world& w, auto&) {
         w.add_if_local(body{.shape = sphere{0.5}, .position = {4, 0.85, 0.5}});
       }},
      {"a fixed body beside it",
       [](scene_world& w, auto&) {
         w.add_if_local(
             body{.shape = box{{1, 1, 1}}, .position = {4.5, 1.001, 0.5}, .fixed = true});
       }},
      {"a wake", [](scene_world& w, auto& row) {
         if (row[3]) w[*row[3]].wake();
       }}};
  for (const int ranks : {1, 4})
    for (const auto& [name, act] : actions)
      on(ranks, [&, &name = name, &act = act](scene_world& w) {
        CAPTURE(name);
        CAPTURE(ranks);
        floor_of(w);
        w.sleeping({.speed = 0.05, .time = 0.1});
        auto row = row_at(w, 0, 0.5);
        row_at(w, 10, 0.5);
        run(w, 60);
        REQUIRE(asleep(w) == 32);
        act(w, row);
        run(w, 2);
        CHECK(asleep(w) == 16);
        CHECK(asleep_beyond(w) == 16);
        run(w, 240);             // until the inserted sphere is pushed out of its neighbours
        CHECK(asleep(w) >= 31);  // and back to sleep
      });
}

TEST_CASE("gravity, a pair of materials and wake() wake all") {
  on(2, [&](scene_world& w) {
    floor_of(w);
    w.sleeping({.speed = 0.05, .time = 0.1});
    row_at(w, 0, 0.5), row_at(w, 10, 0.5);
    const auto rests = [&] {
      run(w, 60);
      return asleep(w) == 32;
    };
    REQUIRE(rests());
    w.gravity({0, 0, -10});
    run(w, 1);
    CHECK(asleep(w) == 32);
    w.gravity({0, 0, -9});
    run(w, 1);
    CHECK(asleep(w) == 0);
    REQUIRE(rests());
    w.material_pair({}, {}, {.friction = 0.1});
    run(w, 1);
    CHECK(asleep(w) == 0);
    REQUIRE(rests());
    w.wake();
    run(w, 1);
    CHECK(asleep(w) == 0);
  });
}

TEST_CASE("what an island stands on wakes it when it moves or goes") {
  for (const int ranks : {1, 2, 4})
    on(ranks, [&](scene_world& w) {
      CAPTURE(ranks);
      w.gravity({0, 0, -10});
      w.sleeping({.speed = 0.05, .time = 0.1});
      handle<box> shelf;
      w.global([&](auto& s) {
        shelf = s.add(box{{20, 4, 1}}, {}, {8, 0, -0.5});
        s.add(box{{20, 4, 1}}, {}, {8, 10, -0.5});
      });
      const auto support =
          w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {4.1, 20, -0.5}, .fixed = true});
      w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {3.8, 20, 0.5}});
      row_at(w, 0, 0.5), row_at(w, 10, 0.5);
      run(w, 60);
      REQUIRE(asleep(w) == 33);
      w[shelf].translate({0, 0, -0.01});
      run(w, 1);
      CHECK(asleep(w) == 17);
      run(w, 80);
      REQUIRE(asleep(w) == 33);
      w.destroy(shelf);
      run(w, 2);
      CHECK(asleep(w) == 17);
      if (support) w[*support].translate({0, 0, -0.01});
      run(w, 2);
      CHECK(asleep(w) == 16);
    });
}

TEST_CASE("a body that spins in place stays awake") {
  on(1, [&](scene_world& w) {
    floor_of(w);
    w.sleeping({.speed = 0.1, .time = 0.1});
    w.add(body{.shape = sphere{0.5}, .position = {4, 0, 0.5}, .angular_velocity = {0, 0, 5}});
    w.add(body{.shape = sphere{0.5}, .position = {8, 0, 0.5}});
    run(w, 100);
    CHECK(asleep(w) == 1);
  });
}

TEST_CASE("what falls slowly, drifts or rolls on stays awake, alone or with others") {
  for (const int ranks : {1, 2})
    on(ranks, [&](scene_world& w) {  // these fall
      w.gravity({0, 0, -0.01});
      w.add_if_local(body{.shape = sphere{0.5}, .position = {2, 0, 0}});
      w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {7.5, 0, 0}});
      w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {8.5, 0, 0}});
      run(w, 600);
      CHECK(asleep(w) == 0);
      w.for_each_local([&](const auto& b) {
        CHECK(b.velocity()[2] == doctest::Approx(-0.01 * 600 * dt).epsilon(1e-9));
      });
    });
  for (const int ranks : {1, 2})
    for (const double speed : {0.04, 1e-3, 1e-6})
      for (const auto& [step, time] : {std::pair{dt, 0.5}, {1. / 60, 0.5}, {1. / 60, 0.1}})
        on(ranks, [&](scene_world& w) {  // these drift, two of them in touch over the cut
          w.sleeping({.speed = 0.05, .time = time});
          w.add_if_local(
              body{.shape = sphere{0.5}, .position = {2, 0, 0}, .velocity = {0, speed, 0}});
          row_at(w, 5, 0);
          w.for_each_local([&](auto& b) { b.set_velocity({0, speed, 0}); });
          for (int k = 0; k < 600; ++k) w.step(step);
          CHECK(asleep(w) == 0);
          w.for_each_local([&](const auto& b) {
            CHECK(b.velocity()[1] == doctest::Approx(speed).epsilon(1e-9));
          });
        });
  for (const double speed : {0.02, 1e-3, 1e-4})
    on(1, [&](scene_world& w) {  // this rolls
      floor_of(w);
      const auto ball = w.add(body{.shape = sphere{0.5},
                                   .position = {2, 0, 0.5},
                                   .velocity = {speed, 0, 0},
                                   .angular_velocity = {0, 2 * speed, 0}});
      run(w, 600);
      CHECK(asleep(w) == 0);
      CHECK(w[ball].velocity()[0] == doctest::Approx(speed).epsilon(1e-6));
    });
}

TEST_CASE("what loses its support falls, however long it has rested, awake or asleep") {
  for (const int ranks : {1, 2})
    for (const int rested : {60, 96, 400})
      for (const double time : {0.1, 0.5})
        on(ranks, [&](scene_world& w) {
          w.gravity({0, 0, -0.01});
          w.sleeping({.speed = 0.05, .time = time});
          handle<box> shelf;
          w.global([&](auto& s) { shelf = s.add(box{{20, 4, 1}}, {}, {8, 0, -0.5}); });
          w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {4, 0, 0.5}});
          run(w, rested);
          w.destroy(shelf);
          run(w, 400);
          CHECK(asleep(w) == 0);
          w.for_each_local([&](const auto& b) {
            CHECK(b.velocity()[2] == doctest::Approx(-0.01 * 400 * dt).epsilon(1e-3));
          });
        });
}

TEST_CASE("a heap in a fluid stays asleep until the flow changes") {
  for (const int ranks : {1, 2})
    on(ranks, [&](scene_world& w) {
      floor_of(w);
      w.sleeping({.speed = 0.05, .time = 0.1});
      for (int k = 0; k < 8; ++k) {
        w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {1.5 * k + 2, 0, 0.52}});
        w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {1.5 * k + 2.1, 0, 1.55}});
      }
      const auto flow = [](const vec3&, real time) { return vec3(0, time > 7 ? 20 : 0, 0); };
      add_fluid(w, fluid{.density = 0.5, .viscosity = 0.1, .velocity = flow});
      w.simulate({.steps = 400, .dt = dt});
      REQUIRE(asleep(w) == 16);
      bool stays = true;
      for (int k = 0; k < 10; ++k) {
        w.simulate({.steps = 99, .dt = dt});
        stays = stays && asleep(w) == 16;
      }
      CHECK(stays);
      w.simulate({.steps = 20, .dt = dt});
      CHECK(asleep(w) == 0);
    });
}

TEST_CASE("a field that changes wakes what it would move") {
  for (const int ranks : {1, 2})
    on(ranks, [&](scene_world& w) {
      floor_of(w);
      w.sleeping({.speed = 0.05, .time = 0.1});
      for (const double x : {4.0, 12.0})
        w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {x, 0, 0.5}});
      add_force_field(
          w, [](const vec3& x, real time) { return vec3(1, time > 1 && x[0] < 8 ? 20 : 0, 0); });
      w.simulate({.steps = 199, .dt = dt});
      CHECK(asleep(w) == 2);
      w.simulate({.steps = 40, .dt = dt});
      CHECK(asleep(w) == 1);
      w.for_each_local([&](const auto& b) {
        // 15 = 20 less friction, nearly: it acts against 1 and 20 together
        if (b.position()[0] < 8) CHECK(b.position()[1] > 0.2);
      });
    });
}

TEST_CASE("a belt keeps awake what lies on it") {
  on(1, [&](scene_world& w) {
    w.gravity({0, 0, -10});
    w.sleeping({.speed = 2, .time = 0.1});
    const auto belt = w.add(body{.shape = box{{9, 1, 1}}, .position = {8, 0, -0.5}, .fixed = true});
    w.add(body{.shape = box{{1, 1, 1}}, .position = {8, 0, 0.5}});
    w[belt].set_velocity({1, 0, 0});
    run(w, 100);
    CHECK(asleep(w) == 0);
    w[belt].set_velocity({0, 0, 0});
    run(w, 100);
    CHECK(asleep(w) == 1);
  });
}

TEST_CASE("an island goes on with the impulses it had, and its ranks agree on them") {
  for (const int ranks : {1, 2, 4})
    on(ranks, [&](scene_world& w) {
      CAPTURE(ranks);
      floor_of(w);
      w.sleeping({.speed = 0.05, .time = 0.1});
      // A wall of bricks, five courses, through all slabs.
      double bricks = 0;
      for (int z = 0; z < 5; ++z)
        for (int k = 0; k < 8; ++k, ++bricks)
          w.add_if_local(body{.shape = box{{1.99, 1, 1}},
                              .position = {2.0 * k + (z % 2 ? 1.2 : 0.8), 0, z + 0.5}});
      run(w, 200);
      REQUIRE(asleep(w) == bricks);
      CHECK(talus::detail::state_of(w).sleep.contacts.entries().size() > 0);
      run(w, 20);
      w.wake();
      run(w, 1);
      CHECK(asleep(w) == 0);
      CHECK(measure_motion(w).max_speed < 1e-3);  // a fall of one step would make it 5e-2
      std::map<std::array<std::uint64_t, 3>, vec3> impulses;
      double apart = 0, shared = 0;
      for (const auto& c : talus::detail::state_of(w).history.entries())
        impulses[{value_of(c.key.a), value_of(c.key.b), c.key.feature}] = c.memory;
      detail::byte_buffer mine;
      for (const auto& [key, impulse] : impulses) {
        detail::byte_writer out(mine);
        for (const auto k : key) out.put(k);
        out.put(impulse);
      }
      const auto all = w.link().gather_all(mine);
      for (std::size_t r = 0; r < all.size(); ++r) {
        detail::byte_reader in(all[r]);
        for (std::size_t n = all[r].size() / (3 * 8 + sizeof(vec3)); n > 0; --n) {
          std::array<std::uint64_t, 3> key;
          for (auto& k : key) k = in.get<std::uint64_t>();
          const auto theirs = in.get<vec3>();
          const auto found = impulses.find(key);
          if (static_cast<int>(r) == w.rank() || found == impulses.end()) continue;
          ++shared;
          apart = std::max(apart, (found->second - theirs).norm());
        }
      }
      CHECK((ranks == 1 || sum_of(w, shared) > 0));
      CHECK(apart < 1e-13);
    });
}

TEST_CASE("a sleeping pile that is struck again and again gains no energy, and its ledger closes") {
  for (const int ranks : {1, 4})
    on(ranks, [&](scene_world& w) {
      CAPTURE(ranks);
      floor_of(w);
      w.sleeping({.speed = 0.2, .time = 0.1});
      double bodies = 0;
      for (int z = 0; z < 3; ++z)
        for (int y = 0; y < 2; ++y)
          for (int x = 0; x < 12; ++x, ++bodies) {
            const vec3 at{1.3 * x + 0.7, 1.02 * y, 1.02 * z + 0.5};
            w.add_if_local(body{.shape = box{{1.2, 1, 1}}, .position = at});
          }
      run(w, 200);
      REQUIRE(asleep(w) == bodies);
      bool slept = true;
      for (int k = 0; k < 3; ++k) {
        w.add_if_local(body{
            .shape = sphere{0.4}, .position = {4.1 * k + 2.5, 0.5, 4.2}, .velocity = {1, 0.3, -3}});
        energy_balance before = measure_energy(w);
        double most = before.kinetic + before.potential;
        for (int i = 0; i < 300; ++i) {
          w.step(dt);
          const energy_balance e = measure_energy(w);
          const double now = e.kinetic + e.potential;
          // Contacts dissipate energy, or their work is less than what the scheme takes from falls.
          CHECK(now - most <= e.step.correction + std::max(e.step.scheme, 0.0) + 1e-4);  // of 1300
          CHECK(e.step.sleep >= 0);
          most = now;
        }
        slept = slept && asleep(w) > 0;
      }
      const energy_balance e = measure_energy(w);
      CHECK(slept);
      CHECK(e.worst < 1e-11);
      CHECK(e.total.sleep > 0);
    });
}

TEST_CASE("ranks agree on who sleeps and on impulses, and what sleeps does not move") {
  using heap = scenario<bodies<sphere, box, plane>, features<sleeping>,
                        decomposition<grid<dynamic, dynamic>>, transport<threads>>;
  using contact = std::array<std::uint64_t, 3>;
  struct known {
    bool asleep;
    vec3 position;
  };
  std::map<system_id, known> now, before;
  std::array<std::map<system_id, bool>, 4> copies;
  std::array<std::map<contact, vec3>, 4> impulses;
  std::mutex one_at_a_time;
  int contradictions = 0, moved = 0, shared = 0, fell = 0, woke = 0;
  real apart = 0;
  const auto look = [&] {
    for (const auto& there : copies)
      for (const auto& [id, sleeps] : there) contradictions += now.at(id).asleep != sleeps;
    const auto awake = [&](std::uint64_t id) {
      const auto a = now.find(system_id{id}), b = before.find(system_id{id});
      return a != now.end() && b != before.end() && !a->second.asleep && !b->second.asleep;
    };
    for (const auto& [id, body] : now)
      if (const auto then = before.find(id); then != before.end()) {
        fell += !then->second.asleep && body.asleep, woke += then->second.asleep && !body.asleep;
        moved += then->second.asleep && body.asleep && then->second.position != body.position;
      }
    for (std::size_t r = 0; r < 4; ++r)
      for (std::size_t q = 0; q < r; ++q)
        for (const auto& [key, impulse] : impulses[r])
          if (const auto other = impulses[q].find(key);
              other != impulses[q].end() && awake(key[0]) && awake(key[1]))
            ++shared, apart = std::max(apart, (impulse - other->second).norm());
    before = std::move(now), now = {};
  };
  threads::launch({.ranks = 4}, [&](threads::link& link) {
    const auto rank = static_cast<std::size_t>(link.rank());
    world<heap> w(link, {.cells = {2, 2}, .lower = {-3, -3}, .upper = {3, 3}});
    w.material({.restitution = 0.2, .friction = 0.6});
    w.gravity({0, 0, -10});
    w.global([&](auto& s) {
      s.add(plane{.normal = {0, 0, 1}}, {});
      for (const real side : {-1, 1})
        s.add(plane{.normal = {side, 0, 0}, .offset = -4}, {}),
            s.add(plane{.normal = {0, side, 0}, .offset = -4}, {});
    });
    w.sleeping({.speed = 0.3, .time = 0.1});
    random_stream random(2);
    for (int i = 0; i < 120; ++i) {
      const vec3 at{random.uniform(-3.4, 3.4), random.uniform(-3.4, 3.4), 0.6 + 0.08 * i};
      const real r = random.uniform(0.25, 0.45);
      if (i % 3 == 0)
        w.add_if_local(body{.shape = sphere{r}, .position = at});
      else
        w.add_if_local(
            body{.shape = box{{2 * r, random.uniform(0.4, 0.9), random.uniform(0.4, 0.9)}},
                 .position = at});
    }
    for (int k = 0; k < 1000; ++k) {
      const vec3 at = random.uniform(vec3(-3.4, -3.4, 4), vec3(3.4, 3.4, 4.5));
      if (k % 100 == 50) w.add_if_local(body{.shape = sphere{0.3}, .position = at});
      if (k % 100 == 99)
        w.destroy_if([&](const auto& b) {
          const vec3 off = b.position() - at;
          return std::hypot(off[0], off[1]) < 0.4;
        });
      w.step(1. / 240);
      {
        const std::lock_guard lock(one_at_a_time);
        copies[rank].clear(), impulses[rank].clear();
        w.for_each_known([&](const auto& b) {
          if (b.is_global()) return;
          if (b.is_remote())
            copies[rank][b.id()] = b.is_asleep();
          else
            now[b.id()] = {b.is_asleep(), b.position()};
        });
        for (const auto& c : talus::detail::state_of(w).history.entries())
          impulses[rank][{value_of(c.key.a), value_of(c.key.b), c.key.feature}] = c.memory;
      }
      link.barrier();
      if (rank == 0) look();
      link.barrier();
    }
  });
  CHECK(contradictions == 0);
  CHECK(moved == 0);
  CHECK(fell > 20);
  CHECK(woke > 10);
  CHECK(shared > 1000);
  CHECK(apart < 1e-13);
}

TEST_CASE("sleeping bodies change hands when space is divided anew, and wake there") {
  on(4, [&](scene_world& w) {
    const auto floor = floor_of(w);
    w.sleeping({.speed = 0.05, .time = 0.1});
    struck_row(w);
    run(w, 60);
    REQUIRE(asleep(w) == 16);
    w.decompose(slabs_of(4, 9));
    run(w, 20);
    CHECK(asleep(w) == 16);
    const double weight = 10 * measure_motion(w).mass;  // the memory of their contacts migrated
                                                        // with them
    CHECK(contact_force(w, floor)[2] == doctest::Approx(-weight).epsilon(1e-6));
    if (w.rank() == 3) CHECK(w.local_bodies() == 9);
    strike(w);
    run(w, 30);
    CHECK(asleep(w) == 0);
    run(w, 600);
    CHECK(asleep(w) == 17);
  });
}

TEST_CASE("an island larger than what can be told in its time of rest comes to rest all the same") {
  on(4, [&](scene_world& w) {
    floor_of(w);
    w.sleeping({.speed = 0.05, .time = 0});
    struck_row(w);
    strike(w);
    run(w, 1000);
    CHECK(asleep(w) == 17);
    const auto before = state_digest(w);
    run(w, 100);
    CHECK(asleep(w) == 17);
    CHECK(state_digest(w) == before);
  });
}

TEST_CASE("a sleeping body is nobody's weight less: the floor still bears it") {
  on(2, [&](scene_world& w) {
    const auto floor = floor_of(w);
    w.sleeping({.speed = 0.05, .time = 0.1});
    row_at(w, 0, 0.5);
    run(w, 60);
    REQUIRE(asleep(w) == 16);
    const double weight = 10 * measure_motion(w).mass;
    CHECK(contact_force(w, floor)[2] == doctest::Approx(-weight).epsilon(1e-6));
  });
}

TEST_CASE("settings that make no sense are refused") {
  on(1, [&](scene_world& w) {
    CHECK_THROWS_WITH_AS(
        w.sleeping({.speed = -1}),
        "islands go to sleep below a positive speed and after a time of 0 or more, "
        "both finite, but they are -1 and 0.5",
        std::invalid_argument);
    CHECK_THROWS_AS(w.sleeping({.speed = std::nan("")}), std::invalid_argument);
    CHECK_THROWS_AS(w.sleeping({.time = -1}), std::invalid_argument);
    CHECK_THROWS_AS(w.sleeping({.time = std::nan("")}), std::invalid_argument);
    CHECK_THROWS_AS(w.sleeping({.time = INFINITY}), std::invalid_argument);
  });
}
