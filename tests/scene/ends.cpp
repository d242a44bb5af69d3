// Runs that end early: exceptions without text, exit() in a callback, ranks that do not return,
// more ranks than possible.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/run.hpp>
#include <thread>
#include <vector>

using namespace talus;

namespace {

using scene = scenario<bodies<sphere>, decomposition<grid<dynamic, 1>>, transport<threads>>;

enum class deed { none, throws_int, throws_struct, exits, exits_with_3, exits_in_set_up, hangs };
struct something {};

void do_it(deed what) {
  if (what == deed::throws_int) throw 42;
  if (what == deed::throws_struct) throw something{};
  if (what == deed::exits) std::exit(0);
  if (what == deed::exits_with_3) std::exit(3);
  while (what == deed::hangs) std::this_thread::sleep_for(std::chrono::seconds(1));
}

struct outcome {
  int code = -1;
  std::string said, json;
  bool says(const char* words) const { return said.find(words) != std::string::npos; }
};

/// In a process of its own: rank 1, or the only one, does it in a callback after step 3.
outcome outcome_of(deed what, int ranks, std::vector<std::string> more = {}) {
  const std::string base = "/tmp/talus_ends_" + std::to_string(getpid());
  const std::string log = base + ".log", json = base + ".json";
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (std::freopen(log.c_str(), "w", stderr) == nullptr) std::_Exit(99);
    std::vector<std::string> words{"balls",  "--quiet", "--steps", "5",
                                   "--json", json,      "--ranks", std::to_string(ranks)};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    std::_Exit(
        run<scene>(int(arguments.size()), arguments.data(), [&](auto& world, const auto& options) {
          if (world.ranks() > 1) world.decompose({.lower = {-9}, .upper = {9}});
          if (what == deed::exits_in_set_up && world.rank() == world.ranks() - 1) std::exit(0);
          (void)world.material({});
          (void)world.add_if_local(body{.shape = sphere{0.5}, .position = {1, 0, 0}});
          world.after_each_step([&] {
            if (world.steps() == 3 && world.rank() == (world.ranks() > 1 ? 1 : 0)) do_it(what);
          });
          world.simulate({.steps = options.steps, .dt = options.dt});
        }));
  }
  int status = 0;
  waitpid(child, &status, 0);
  const auto text_of = [](const std::string& name) {
    std::stringstream text;
    text << std::ifstream(name).rdbuf();
    unlink(name.c_str());
    return text.str();
  };
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status), text_of(log),
          text_of(json)};
}

}  // namespace

TEST_CASE("an exception that is no std::exception ends the run with a message and code 1") {
  for (const int ranks : {1, 3}) {
    const outcome number = outcome_of(deed::throws_int, ranks);
    CHECK(number.code == 1);
    CHECK(number.says("threw an exception of type int on rank"));
    CHECK(number.says("after step 3, which is no std::exception"));
    const outcome value = outcome_of(deed::throws_struct, ranks);
    CHECK(value.code == 1);
    CHECK(value.says("something"));
  }
}

TEST_CASE("exit() in a callback is no silent success") {
  for (const int ranks : {1, 3}) {
    const outcome zero = outcome_of(deed::exits, ranks);
    CHECK(zero.code == 1);
    CHECK(zero.says(ranks == 1 ? "ended early: the program called exit(0) on rank 0 after step 3"
                               : "ended early: the program called exit(0) on rank 1 after step 3"));
    CHECK(zero.json.find("\"ended_early\": \"exit(0) on rank") != std::string::npos);
    CHECK(outcome_of(deed::exits_with_3, ranks).code == 3);
    CHECK(outcome_of(deed::exits_in_set_up, ranks).code == 1);
  }
  const outcome whole = outcome_of(deed::none, 3);
  CHECK(whole.code == 0);
  CHECK(whole.said == "");
  CHECK(whole.json.find("ended_early") == std::string::npos);
}

TEST_CASE("a rank that does not come back is named, with those that wait for it") {
  const outcome hung = outcome_of(deed::hangs, 3, {"--patience", "0.2", "--give-up", "0.3"});
  CHECK(hung.code == 1);
  CHECK(hung.says("rank 1 (after step 3) has kept others waiting for 0.2 seconds: "));
  CHECK(hung.says("for a message of rank 1"));
  CHECK(hung.says("has kept others waiting for 0.5 seconds, and the run ends"));
  CHECK(outcome_of(deed::none, 1, {"--give-up", "1", "--patience", "0"}).code == 2);
}

TEST_CASE("more ranks than a process has are refused before any begins") {
  const outcome many = outcome_of(deed::none, 30000);
  CHECK(many.code == 1);
  CHECK(many.says("30000 ranks are asked for, but one process has at most 4096 as threads"));
}
