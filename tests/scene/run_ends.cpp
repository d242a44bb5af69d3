// Runs that end by themselves: at rest, when an observable is steady, at a time limit; dry runs,
// logs and configurations. On one, two and four ranks, as threads.
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <talus/observe/run_ends.hpp>
#include <talus/talus.hpp>
#include <thread>
#include <vector>

using namespace talus;

namespace {

using scene = scenario<bodies<sphere, plane>, hard_contact<coulomb_friction, newton_restitution>,
                       solver<nonlinear_gauss_seidel, reproducible>,
                       decomposition<grid<dynamic, 1>>, transport<threads>>;

struct ball_options : talus::options {
  double radius = 0.5;
  double height = 1;
  material stone{.density = 2, .restitution = 0.5, .friction = 0.5};
  void describe(auto& cli) {
    options::describe(cli);
    cli.add_positive("--radius", radius, "of the balls");
    cli.add("--height", height, "from which they fall");
    cli.add("--stone", stone, "the balls");
  }
};

std::string text_of(const std::string& name) {
  std::stringstream text;
  text << std::ifstream(name).rdbuf();
  return text.str();
}
bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}
/// The value of a key of a JSON file of a run.
std::string value_in(const std::string& json, const std::string& key) {
  const auto at = json.find('"' + key + "\": ");
  if (at == json.npos) return "";
  const auto from = at + key.size() + 4;
  return json.substr(from, json.find_first_of(",\n", from) - from);
}

struct outcome {
  int code = -1;
  std::string json, err, out;
  std::string operator[](const char* key) const { return value_in(json, key); }
  double number(const char* key) const { return std::stod((*this)[key]); }
};

struct folder {
  std::string path = "/tmp/talus_run_ends_" + std::to_string(getpid());
  folder() { mkdir(path.c_str(), 0700); }
  ~folder() { (void)std::system(("rm -rf " + path).c_str()); }
};

/// What a program writes to a stream.
template <class F>
std::string caught(std::FILE* stream, const std::string& file, F&& f) {
  std::fflush(stream);
  const int saved = dup(fileno(stream));
  REQUIRE(std::freopen(file.c_str(), "w", stream) != nullptr);
  f();
  std::fflush(stream);
  dup2(saved, fileno(stream));
  close(saved);
  return text_of(file);
}

/// Four balls in a row fall onto a floor. `pause`: seconds that each step takes at least.
outcome run_balls(const folder& in, std::vector<std::string> words, bool writes_json = true,
                  double pause = 0, double recorded = 1, real friction_of_floor = -1,
                  pair_rules rules = {}, int calls = 1) {
  const std::string json = in.path + "/balls.json";
  words.insert(words.begin(), "balls");
  if (writes_json) words.insert(words.end(), {"--json", json, "--force"});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  outcome o;
  o.out = caught(stdout, in.path + "/out", [&] {
    o.err = caught(stderr, in.path + "/err", [&] {
      o.code = run<scene, ball_options>(
          static_cast<int>(arguments.size()), arguments.data(),
          [&](auto& world, const ball_options& options) {
            world.decompose({.lower = {-4}, .upper = {4}});
            world.gravity({0, 0, -10});
            const auto stone = world.material(options.stone);
            material of_floor = options.stone;
            if (friction_of_floor >= 0) of_floor.friction = friction_of_floor;
            const auto floor = world.material(of_floor);
            if (rules != pair_rules{}) world.pair_rules(rules);
            world.global([&](auto& scope) { scope.add(plane{}, floor); });
            for (int k = 0; k < 4; ++k)
              (void)world.add_if_local(body{.shape = sphere{options.radius},
                                            .position = {2.0 * k - 3, 0, options.height},
                                            .material = stone});
            world.observe(every{1}, [&](auto& of) {
              if (of.rank() == 0)
                of.record("own", recorded * (of.time() < 1 ? of.time() : 1.0), "1");
              if (pause > 0) std::this_thread::sleep_for(std::chrono::duration<double>(pause));
            });
            for (int k = 0; k < calls; ++k)
              world.simulate({.steps = options.steps, .dt = options.dt});
          });
    });
  });
  o.json = text_of(json);
  return o;
}

}  // namespace

TEST_CASE("a run until rest ends in the same step with the same bits on any number of ranks") {
  const folder in;
  std::string steps, digest;
  for (const char* ranks : {"1", "2", "4"}) {
    const auto o = run_balls(in, {"--quiet", "--reproducible", "--ranks", ranks, "--steps", "5000",
                                  "--dt", "0.002", "--until", "rest"});
    REQUIRE(o.code == 0);
    CHECK(o["ended_by"] == "\"rest\"");
    if (steps.empty()) steps = o["steps"], digest = o["state_digest"];
    CHECK(o["steps"] == steps);
    CHECK(o["state_digest"] == digest);
    CHECK(o.number("steps") < 5000);
    CHECK(o.number("steps") > 100);  // they fall for 0.3
    // At rest they rise by at most 1e-4 radii.
    CHECK(o.number("max_speed") < std::sqrt(2e-4 * 10 * 0.5));
  }
}

TEST_CASE("a run whose bodies never rest makes all its steps") {
  const folder in;
  const auto o = run_balls(in, {"--quiet", "--steps", "100", "--dt", "0.002", "--until", "rest"});
  CHECK(o.code == 0);
  CHECK(o["ended_by"].empty());
  CHECK(o.number("steps") == 100);
}

TEST_CASE("the speed and the time of rest are those that are given") {
  const folder in;
  const auto o =
      run_balls(in, {"--quiet", "--steps", "1000", "--dt", "0.002", "--until", "rest",
                     "--until-speed", "100", "--until-time", "0.1", "--until-every", "7"});
  // From the first look, in step 7, for 50 steps, and then to the next look.
  CHECK(o.number("steps") == 63);
}

TEST_CASE("a run ends when a recorded value or an energy is steady, on any number of ranks") {
  const folder in;
  for (const char* ranks : {"1", "4"}) {
    // It grows until the time 1; then the first half of a window of 0.5 differs from the second by
    // less than 1 % soon.
    const auto own = run_balls(in, {"--quiet", "--ranks", ranks, "--steps", "5000", "--dt", "0.01",
                                    "--until", "steady:own", "--until-time", "0.5"});
    REQUIRE(own.code == 0);
    CHECK(own["ended_by"] == "\"steady:own\"");
    CHECK(own.number("steps") >= 130);
    CHECK(own.number("steps") <= 150);
    const auto energy =
        run_balls(in, {"--quiet", "--ranks", ranks, "--steps", "5000", "--dt", "0.01", "--until",
                       "steady:potential_energy", "--until-time", "0.5"});
    CHECK(energy["ended_by"] == "\"steady:potential_energy\"");
    CHECK(energy.number("steps") < 1000);
  }
}

TEST_CASE("a value that is not recorded, or not finite, ends the run with a message") {
  const folder in;
  auto o = run_balls(in, {"--quiet", "--until", "steady:torque", "--until-time", "1"});
  CHECK(o.code == 1);
  CHECK(has(o.err, "--until steady:torque: nothing is recorded under that name"));
  o = run_balls(in, {"--quiet", "--until", "steady:own", "--until-time", "1"}, true, 0,
                std::numeric_limits<double>::infinity());
  CHECK(o.code == 1);
  CHECK(has(o.err, "it must be finite"));
}

TEST_CASE("conditions are given in a program too") {
  serial::link link;
  world<scenario<bodies<sphere>, transport<serial>>> w(link);
  CHECK_THROWS_WITH_AS((void)at_rest(w, {.speed = -1}), doctest::Contains("not negative"),
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS((void)steady(w, {.time = 0}, [](auto&) { return 1.0; }),
                       doctest::Contains("finite and positive"), std::invalid_argument);
  const auto stone = w.material({.density = 2});
  auto ball = w.add(sphere{0.5}, stone);
  CHECK_THROWS_WITH_AS(w.simulate({.steps = 1, .dt = 0.01, .stop_when = at_rest(w)}),
                       doctest::Contains("without gravity"), std::invalid_argument);
  w.simulate({.steps = 100, .dt = 0.01, .stop_when = at_rest(w, {.speed = 1e-3, .time = 0.2})});
  CHECK(w.stopped());
  CHECK(w.steps() == 22);
  w[ball].set_angular_velocity({0, 0, 1});  // a body that turns is not at rest
  w.simulate({.steps = 50, .dt = 0.01, .stop_when = at_rest(w, {.speed = 0.1, .time = 0.2})});
  CHECK(!w.stopped());
  // The speed counts the rotation of a solid sphere: sqrt(0.4) r omega.
  w.simulate({.steps = 50, .dt = 0.01, .stop_when = at_rest(w, {.speed = 0.32, .time = 0.2})});
  CHECK(w.stopped());
}

TEST_CASE("a steady observable fluctuates, but its mean does not move") {
  detail::end_watch noise({.time = 1, .within = 0.05}), ramp({.time = 1, .within = 0.05});
  bool steady = false, rising = false;
  int at = 0;
  for (int k = 0; k < 400; ++k) {
    const double t = 0.01 * k;
    if (!steady) steady = noise.take(t, 10 + 3 * std::sin(40 * t)), at = k;
    rising = rising || ramp.take(t, 1 + t);  // by half the window, 0.5 of at most 5
  }
  CHECK(steady);
  CHECK(at >= 100);
  CHECK(at < 150);
  CHECK(!rising);
}

TEST_CASE("a time limit ends the run on all ranks, with its code, figures and log") {
  const folder in;
  for (const char* ranks : {"1", "2", "4"}) {
    const std::string log = in.path + "/run.log";
    const auto o =
        run_balls(in, {"--ranks", ranks, "--steps", "1000000", "--time-limit", "1s", "--log", log},
                  true, 1e-3);
    CHECK(o.code == 75);
    CHECK(o["ended_by"] == "\"time limit\"");
    CHECK(o.number("steps") > 10);
    CHECK(o.number("steps") < 1000);
    CHECK(has(o.err, "balls: ended by --time-limit in step " + o["steps"] + "; its state is lost"));
    CHECK(has(text_of(log), "exit code 75"));
  }
  CHECK(run_balls(in, {"--quiet", "--steps", "10", "--time-limit", "1h30m"}).code == 0);
}

TEST_CASE("wall times are read in seconds, minutes, hours and days") {
  CHECK(detail::seconds_in("3600") == 3600);
  CHECK(detail::seconds_in("1.5") == 1.5);
  CHECK(detail::seconds_in("90s") == 90);
  CHECK(detail::seconds_in("1h30m") == 5400);
  CHECK(detail::seconds_in("2d12h") == 216000);
  for (const char* wrong : {"", "0", "-3", "1x", "h", "1h30", "30m1h", "1h1h", ".", "1..5", "nan"})
    CHECK_THROWS_AS((void)detail::seconds_in(wrong), usage_error);
}

TEST_CASE("a floor that is frictionless in name only is told once, and rules are shown") {
  const folder in;
  for (const char* ranks : {"1", "2"}) {
    const std::vector<std::string> words{"--ranks", ranks, "--steps", "3"};
    const auto mean = run_balls(in, words, true, 0, 1, 0);
    const std::string told =
        "balls: warning: material 1 (of a plane) has no friction and material 0";
    CAPTURE(mean.err);
    CHECK(mean.code == 0);
    CHECK(has(mean.err, told));
    CHECK(mean.err.find(told) == mean.err.rfind(told));
    CHECK(!has(mean.out, "of two materials"));
    const auto least = run_balls(in, words, true, 0, 1, 0, {.friction = pair_rule::least});
    CHECK(!has(least.err, "has no friction"));
    CHECK(has(least.out,
              "  contacts of two materials: friction by the least, restitution by the mean"));
  }
}

TEST_CASE("a dry run counts the bodies, estimates the rest, and writes nothing") {
  const folder in;
  for (const char* ranks : {"1", "4"}) {
    const std::string log = in.path + "/none.log", csv = in.path + "/none.csv";
    const auto o =
        run_balls(in,
                  {"--dry-run", "--ranks", ranks, "--steps", "1000", "--log", log, "--csv", csv,
                   "--json", in.path + "/none.json", "--view", in.path + "/none.html"},
                  false);
    CHECK(o.code == 0);
    CHECK(o.err.empty());
    CHECK(has(o.out, "balls: dry run, no output of the options is written"));
    CHECK(has(o.out, std::string("bodies   4, of which 4 can move; ") +
                         (*ranks == '1' ? "4" : "1") + " on the rank with most of " + ranks));
    CHECK(has(o.out, "of two materials: friction by the mean, restitution by the mean; 0 with"));
    CHECK(has(o.out, "for the 1000 steps"));
    CHECK(!has(o.out, "digest"));
    for (const std::string& file : {log, csv, in.path + "/none.json", in.path + "/none.html",
                                    in.path + "/none.json.config.toml"})
      CHECK(access(file.c_str(), F_OK) != 0);
  }
}

TEST_CASE("a dry run tries each call of simulate and adds up their times") {
  const folder in;
  const auto dry = [&](const char* ranks, int calls) {
    const auto o = run_balls(in, {"--dry-run", "--ranks", ranks, "--steps", "300"}, false, 0, 1, -1,
                             {}, calls);
    CHECK(o.code == 0);
    CHECK(o.err.empty());
    return o.out;
  };
  for (const char* ranks : {"1", "4"}) {
    CHECK(!has(dry(ranks, 1), "\nall "));
    const std::string two = dry(ranks, 2);
    CHECK(has(two, "for the 300 steps of this call"));
    CHECK(has(two, "\na later call of simulate()\n"));
    CHECK(has(two, "\nall 2 calls of simulate()\n"));
    CHECK(has(two, " for 600 steps\n"));
  }
  const std::string many = dry("1", 25);
  CHECK(has(many, "\nall 20 calls of simulate()\n"));
  CHECK(has(many, "the calls after these are not tried"));
}

TEST_CASE("the log has what the terminal shows, also of a quiet run, with what the run is") {
  const folder in;
  const std::string log = in.path + "/run.log";
  const auto loud = run_balls(in, {"--steps", "300", "--log", log, "--height", "0.4"});
  const std::string text = text_of(log);
  CHECK(text.starts_with("# log of a run of talus: balls\n"));
  for (const char* head : {"\ndate ", "\nversion      talus 0.1.0\n", "\nprogram ", "\nlibrary ",
                           "\nhost ", "\ncommand      balls --steps 300", "\nseed         1\n",
                           "\n  height = 0.4  # command line\n", "\nranks        1\n"})
    CHECK(has(text, head));
  std::stringstream lines(loud.out + loud.err);
  int found = 0;
  for (std::string line; std::getline(lines, line); ++found) CHECK(has(text, line));
  CHECK(found > 5);
  CHECK(has(loud.err, "warning"));  // the balls begin in the floor
  const std::string digest = loud["state_digest"].substr(1, 16);
  CHECK(has(text, "\ndigest " + digest));
  CHECK(has(text, "exit code 0\n"));

  const auto quiet = run_balls(in, {"--quiet", "--steps", "300", "--log", log, "--height", "0.4"});
  CHECK(quiet.out.empty());
  const std::string of_quiet = text_of(log);
  CHECK(has(of_quiet, "warning"));
  CHECK(has(of_quiet, "digest " + digest));
  CHECK(has(of_quiet, "step 300 of 300"));

  // Errors are in it; a file of another kind stays.
  std::ofstream(in.path + "/mine.txt") << "mine\n";
  const auto refused = run_balls(in, {"--log", in.path + "/mine.txt"}, false);
  CHECK(refused.code == 1);
  CHECK(text_of(in.path + "/mine.txt") == "mine\n");
  const auto failed =
      run_balls(in, {"--quiet", "--log", log, "--stone.density", "1e300", "--radius", "1e100"});
  CHECK(failed.code != 0);
  CHECK(!failed.err.empty());
  CHECK(has(text_of(log), failed.err));
}

TEST_CASE("the configuration beside an output makes the run again") {
  const folder in;
  const std::string csv = in.path + "/a.csv";
  const auto first = run_balls(in, {"--quiet", "--steps", "60", "--set", "stone.restitution=0.25",
                                    "--height", "1.25", "--csv", csv, "--ranks", "2"});
  REQUIRE(first.code == 0);
  const std::string file = in.path + "/balls.json.config.toml";
  const std::string text = text_of(file);
  CHECK(text.starts_with("# configuration of a run of talus: balls\n"));
  CHECK(has(text, "\nheight = 1.25  # command line\n"));
  CHECK(has(text, "\nstone.restitution = 0.25  # --set\n"));
  CHECK(has(text, "\nstone.density = 2  # default\n"));
  CHECK(!has(text, "stiffness"));  // contacts are hard
  CHECK(text_of(csv + ".config.toml") == text);

  const auto again = run_balls(in, {"--config", file}, false);
  REQUIRE(again.code == 0);
  CHECK(again["state_digest"] == first["state_digest"]);
  CHECK(again["steps"] == "60");
  CHECK(again["ranks"] == "2");
  const auto other = run_balls(in, {"--config", csv + ".config.toml", "--height", "2"}, false);
  CHECK_MESSAGE(other.code == 0, other.err);
  CHECK(other["state_digest"] != first["state_digest"]);

  // What talus did not write stays.
  std::ofstream(file) << "height = 3\n";
  const auto refused = run_balls(in, {"--quiet", "--json", in.path + "/balls.json"}, false);
  CHECK(refused.code == 1);
  CHECK(has(refused.err, "balls.json.config.toml"));
  CHECK(text_of(file) == "height = 3\n");
  const auto soft = run_balls(in, {"--stone.stiffness", "5"}, false);
  CHECK(soft.code == 2);
  CHECK(has(soft.err, "hard contacts"));
}
