// Runs that end on a condition, and runs that continue from a checkpoint as if uninterrupted: their
// table is the same to the byte, and calls of simulate() end where they ended.
// timeout: 300
#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/scene/run.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using heap =
    scenario<bodies<sphere, plane>, decomposition<grid<dynamic>>, transport<threads>,
             features<checkpoints, forces, energy_ledger, momentum_balance, penetration_monitor>>;
using soft_heap =
    scenario<bodies<sphere, plane>, soft_contact<hertz_mindlin, coulomb_friction>,
             integrator<velocity_verlet>, decomposition<grid<dynamic>>, transport<threads>,
             features<checkpoints, energy_ledger, momentum_balance, penetration_monitor>>;

/// Files of this process, removed at the end.
struct scratch {
  std::string base = "/tmp/talus_continued_" + std::to_string(getpid());
  [[nodiscard]] std::string file(const char* end) const { return base + end; }
  ~scratch() {
    for (const char* end : {"_a.h5", "_b.h5", "_a.csv", "_b.csv", "_said"})
      unlink(file(end).c_str());
  }
};

std::string text_of(const std::string& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}
bool has(const std::string& text, const char* words) { return text.find(words) != text.npos; }

struct ended {
  int code = 0;
  std::string said;
};

/// A program with these words on its command line, and its output on standard error.
template <class Scenario, class SetUp>
ended program(const scratch& files, std::vector<std::string> words, SetUp&& set_up) {
  words.insert(words.begin(), "program");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  const std::string log = files.file("_said");
  std::fflush(stderr);
  const int before = dup(2);
  std::FILE* const file = std::fopen(log.c_str(), "w");
  dup2(fileno(file), 2);
  ended e;
  e.code = run<Scenario>(static_cast<int>(words.size()), argv.data(), set_up);
  std::fflush(stderr);
  dup2(before, 2);
  close(before);
  std::fclose(file);
  e.said = text_of(log);
  return e;
}

template <class World>
void add_heap(World& world) {
  world.gravity({0, 0, -10});
  world.decompose({.lower = {-2, -2}, .upper = {2, 2}});
  const auto stone =
      world.material({.density = 2, .restitution = 0.5, .friction = 0.5, .youngs_modulus = 1e5});
  world.global([&](auto& scope) { scope.add(plane{}, stone); });
  world.fill(simple_cubic{.spacing = 1} & box_region{{-2, -2, 0.5}, {2, 2, 3}},
             [&](const site& s, random_stream& random) {
               return body{.shape = sphere{random.uniform(0.3, 0.48)},
                           .position = s.position,
                           .material = stone};
             });
}

/// In two calls of simulate(), with columns of its own of which one starts late; fails in a step.
template <class Scenario>
ended run_heap(const scratch& files, const char* name, std::vector<std::string> more,
               std::uint64_t fails_in = 0) {
  const auto file = [&](const char* end) { return files.file(name) + end; };
  std::vector<std::string> words{
      "--quiet",      "--steps",   "200",  "--csv", file(".csv"),         "--csv-every", "7",
      "--checkpoint", file(".h5"), "--dt", "0.004", "--checkpoint-every", "50"};
  words.insert(words.end(), more.begin(), more.end());
  return program<Scenario>(files, words, [&](auto& world, const auto& options) {
    add_heap(world);
    world.observe(every{5}, [](auto& w) {
      w.record("torque", measure_motion(w).angular_momentum[2], "M L^2/T^2");
      if (w.steps() >= 120) w.record("late", static_cast<double>(w.steps()));
    });
    world.after_each_step([&] {
      if (world.steps() == fails_in) throw std::runtime_error("the machine is switched off");
    });
    world.simulate({.steps = 30, .dt = options.dt});
    world.simulate({.steps = options.steps - 30, .dt = options.dt});
  });
}

template <class Scenario>
void check_tables(const char* ranks) {
  const scratch files;
  REQUIRE(run_heap<Scenario>(files, "_a", {"--ranks", ranks}).code == 0);
  CHECK(run_heap<Scenario>(files, "_b", {"--ranks", ranks}, 137).code == 1);
  REQUIRE(has(text_of(files.file("_b.csv")), "\n133,"));  // beyond the checkpoint of step 100
  const ended e =
      run_heap<Scenario>(files, "_b", {"--ranks", ranks, "--restart", files.file("_b.h5")});
  CHECK(e.code == 0);
  CHECK(e.said.empty());
  const std::string whole = text_of(files.file("_a.csv")), in_parts = text_of(files.file("_b.csv"));
  CHECK(whole == in_parts);
  CHECK(has(whole, ",torque [M L^2/T^2],late\n"));
  CHECK(has(whole, ",125\n"));
}

}  // namespace

TEST_CASE(
    "the table of an interrupted run is that of an uninterrupted one to the byte, its own "
    "columns included") {
  for (const char* ranks : {"1", "2"}) {
    CAPTURE(ranks);
    check_tables<heap>(ranks);
    check_tables<soft_heap>(ranks);
  }
}

TEST_CASE("sums of monitors go on after a restart on another number of ranks") {
  const auto work_at_end = [](const std::string& table) {
    std::istringstream in(table);
    std::string head, line, last;
    std::getline(in, head);
    while (std::getline(in, line)) last = line;
    std::istringstream names(head), values(last);
    for (std::string name, value;
         std::getline(names, name, ',') && std::getline(values, value, ',');)
      if (name.starts_with("energy_impact")) return std::stod(value);
    return 0.0;
  };
  const scratch files;
  REQUIRE(run_heap<heap>(files, "_a", {"--ranks", "2"}).code == 0);
  CHECK(run_heap<heap>(files, "_b", {"--ranks", "2"}, 137).code == 1);
  CHECK(run_heap<heap>(files, "_b", {"--ranks", "1", "--restart", files.file("_b.h5")}).code == 0);
  const double whole = work_at_end(text_of(files.file("_a.csv")));
  CHECK(whole > 0);
  CHECK(work_at_end(text_of(files.file("_b.csv"))) == doctest::Approx(whole).epsilon(1e-2));
}

TEST_CASE("a table in the units of the program goes on, that of another run with a warning") {
  const scratch files;
  const auto go = [&](const char* seed, const char* table, std::vector<std::string> more) {
    std::vector<std::string> words{"--ranks",         "2",    "--seed", seed,          "--csv",
                                   files.file(table), "--dt", "0.004",  "--csv-every", "5"};
    words.insert(words.end(), more.begin(), more.end());
    return program<heap>(files, words, [&](auto& world, const auto& options) {
      world.units({.length = "m", .mass = "kg", .time = "s"});
      add_heap(world);
      world.simulate({.steps = options.steps, .dt = options.dt});
    });
  };
  const std::string saved = files.file("_a.h5");
  REQUIRE(go("1", "_a.csv", {"--steps", "40", "--checkpoint", saved, "--quiet", "--force"}).code ==
          0);
  REQUIRE(go("2", "_b.csv", {"--steps", "40", "--quiet", "--force"}).code == 0);
  const ended right = go("1", "_a.csv", {"--steps", "60", "--restart", saved});
  CHECK(right.code == 0);
  CHECK(!has(right.said, "another run"));
  CHECK(has(text_of(files.file("_a.csv")), "kinetic_energy [kg m^2/s^2]"));
  CHECK(has(text_of(files.file("_a.csv")), "\n60,"));
  const ended wrong = go("1", "_b.csv", {"--steps", "60", "--restart", saved});
  CHECK(wrong.code == 0);
  CHECK(has(wrong.said, "is it the table of another run?"));
}

TEST_CASE("stop() by one rank, and conditions, end simulate() on all ranks after the same step") {
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [](threads::link& link) {
      world<heap> w(link);
      add_heap(w);
      int asked = 0;
      bool by_hand = true;
      w.observe(every{5}, [&](auto& world) {
        if (by_hand && world.steps() == 15 && world.rank() == world.ranks() - 1) world.stop();
      });
      w.simulate({.steps = 100, .dt = 0.005});
      CHECK(w.steps() == 15);
      CHECK(w.stopped());
      CHECK(w.last_step() == 15);
      by_hand = false;
      w.simulate({.steps = 10, .dt = 0.005});  // continues
      CHECK(w.steps() == 25);
      CHECK(!w.stopped());
      w.simulate({.steps = 100,
                  .dt = 0.005,
                  .stop_when = [&] { return ++asked, w.rank() == 0 && w.steps() > 35; },
                  .check_every = 10});
      CHECK(w.steps() == 40);
      CHECK(asked == 2);
      w.stop_when(every{4}, [](auto& world) { return world.time() > 0.3; });
      w.simulate({.steps = 100, .dt = 0.005});
      CHECK(w.steps() == 64);
      w.stop_when([] { return true; });
      w.simulate({.steps = 100, .dt = 0.005});
      CHECK(w.steps() == 65);
      CHECK_THROWS_WITH_AS(w.stop(), doctest::Contains("world.stop_when(...)"), std::logic_error);
    });
  }
}

namespace {

/// Settles until a condition holds, then is struck and continues.
ended run_phases(const scratch& files, std::vector<std::string> more, std::string& digest) {
  std::vector<std::string> words{"--steps", "300",          "--ranks",
                                 "2",       "--checkpoint", files.file("_a.h5")};
  words.insert(words.end(), more.begin(), more.end());
  return program<heap>(files, words, [&](auto& world, const auto& options) {
    add_heap(world);
    bool settled = false;
    world.simulate({.steps = 200, .dt = options.dt, .stop_when = [&] {
                      settled = measure_motion(world).max_speed > 1;  // falls
                      return settled && world.steps() > 60;
                    }});
    CHECK(world.stopped());
    CHECK(world.steps() == 61);
    if (options.steps == 300) {
      world.gravity({1, 0, -10});
      world.simulate({.steps = 100, .dt = options.dt});
      CHECK(world.steps() == 161);
    }
    const std::string now = state_digest(world);
    if (world.rank() == 0) digest = now;
  });
}

}  // namespace

TEST_CASE(
    "where a condition ended simulate() is kept in checkpoints, in the middle and at the end") {
  const scratch files;
  std::string whole, rest, stopped, again;
  // The last checkpoint is of step 120, in the second call of simulate().
  CHECK(run_phases(files, {"--checkpoint-every", "60"}, whole).code == 0);
  const ended e = run_phases(files, {"--restart", files.file("_a.h5")}, rest);
  CHECK(e.code == 0);
  CHECK(rest == whole);
  CHECK(!has(e.said, "is not gone on with"));
  // The end of a run that was stopped is in its checkpoint; a restart does not continue it.
  CHECK(run_phases(files, {"--steps", "299"}, stopped).code == 2);  // given twice
  const auto end_early = [&](std::vector<std::string> more, std::string& digest) {
    std::vector<std::string> words{"--quiet", "--ranks", "2", "--checkpoint", files.file("_b.h5")};
    words.insert(words.end(), more.begin(), more.end());
    return program<heap>(files, words, [&](auto& world, const auto& options) {
      add_heap(world);
      int steps = 0;
      world.after_each_step([&] { ++steps; });
      world.stop_when(every{9}, [](auto& w) { return w.steps() >= 40; });
      world.simulate({.steps = options.steps, .dt = options.dt});
      CHECK(world.steps() == 45);
      CHECK(world.stopped());
      CHECK(steps == (options.restart.empty() ? 45 : 0));
      const std::string now = state_digest(world);
      if (world.rank() == 0) digest = now;
    });
  };
  CHECK(end_early({}, stopped).code == 0);
  const ended later = end_early({"--restart", files.file("_b.h5")}, again);
  CHECK(later.code == 0);
  CHECK(has(later.said, "was ended in step 45 by stop() or stop_when, and is not gone on with"));
  CHECK(again == stopped);
}

TEST_CASE("a loop of one's own around simulate() is refused after a restart, with what to use") {
  const scratch files;
  for (const real faster_than : {-1.0, 1e9}) {  // ends at once for the bodies of the set-up, never
    CAPTURE(faster_than);
    const auto run_loop = [&](std::vector<std::string> more) {
      std::vector<std::string> words{"--quiet", "--checkpoint", files.file("_a.h5"),
                                     "--checkpoint-every", "35"};
      words.insert(words.end(), more.begin(), more.end());
      const bool first = more.empty();
      return program<heap>(files, words, [&](auto& world, const auto& options) {
        add_heap(world);
        for (int n = 0; n < 40; n += 10) {
          world.simulate({.steps = 10, .dt = options.dt});
          if (!first && measure_motion(world).max_speed > faster_than) break;
        }
      });
    };
    CHECK(run_loop({}).code == 0);
    const ended e = run_loop({"--restart", files.file("_a.h5")});
    CHECK(e.code == 1);
    CHECK(has(e.said, "world.stop_when(...)"));
    CHECK(has(e.said, "those of the set-up"));
    MESSAGE(e.said);
  }
}
