// A run that continues from a checkpoint equals the one that wrote it, on any number of ranks.
// timeout: 300
#include <doctest/doctest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/scene/run.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>

#include "restarts.hpp"

using namespace talus;
using namespace talus::restarts;

TEST_CASE("a restarted pile of all shapes goes on to the bit, asleep and awake") {
  check_restarts<pile>(120, 0.01);
}

TEST_CASE("where trajectories do not depend on the ranks, a restart on others changes no bit") {
  check_restarts<same_balls>(100, 0.01);
}

// --- Runs with options ---------------------------------------------------------------------------

namespace {

/// Differences of the next run from the first.
struct change {
  real density = 1, gravity = 10;
  real pair = -1;                    ///< friction of the material with itself, if not negative
  pair_rule rule = pair_rule::mean;  ///< of friction
  bool by_hand = false, other_names = false;
  int seen_in_second = 0;  ///< steps of the second part that a run takes
  std::string digest{};
};

/// In two parts, with a body added in between. Returns the exit code; `said` is its output.
int run_in_two_parts(std::vector<const char*> words, change& c, std::string* said = nullptr) {
  words.insert(words.begin(), "balls");
  std::vector<char*> arguments;
  for (const char* word : words) arguments.push_back(const_cast<char*>(word));
  const std::string log = "/tmp/talus_said_" + std::to_string(getpid());
  std::fflush(stderr);
  const int before = dup(2);
  std::FILE* const file = std::fopen(log.c_str(), "w");
  dup2(fileno(file), 2);
  const int code = run<balls>(
      static_cast<int>(arguments.size()), arguments.data(), [&](auto& world, const auto& options) {
        world.gravity({0, 0, -c.gravity});
        const auto stone = world.material({.density = c.density, .friction = 0.3});
        if (c.pair >= 0) world.material_pair(stone, stone, {.friction = c.pair});
        world.pair_rules({.friction = c.rule});
        world.global([&](auto& scope) { scope.add(plane{}, stone); });
        world.fill(simple_cubic{.spacing = 1} & box_region{{0, 0, 0.6}, {4, 4, 4}},
                   [&](const site& s) {
                     return body{.shape = sphere{0.45}, .position = s.position, .material = stone};
                   });
        double seen = 0;
        if (c.other_names)
          world.keep("watched", seen);
        else
          world.keep("seen", seen);
        if (c.by_hand) world.step(options.dt);
        bool second = false;
        world.after_each_step([&] {
          ++seen;
          if (second && world.rank() == 0) ++c.seen_in_second;
          if (world.steps() == 55) world.gravity({0, 0, -5});
        });
        world.simulate({.steps = 40, .dt = options.dt});
        (void)world.add_if_local(
            body{.shape = sphere{0.3}, .position = {1, 1, 9}, .material = stone});
        second = true;
        world.simulate({.steps = options.steps - 40, .dt = options.dt});
        CHECK(seen == static_cast<double>(options.steps));
        if (world.steps() > 55) CHECK(world.gravity()[2] == (c.gravity == 10 ? -5 : -c.gravity));
        const std::string digest = state_digest(world);
        if (world.rank() == 0) c.digest = digest;
      });
  std::fflush(stderr);
  dup2(before, 2);
  close(before);
  std::fclose(file);
  std::stringstream text;
  text << std::ifstream(log).rdbuf();
  if (said != nullptr) *said = text.str();
  unlink(log.c_str());
  return code;
}

}  // namespace

TEST_CASE("--restart goes on in the part of the course in which the checkpoint was written") {
  const scratch_file file;
  const char* name = file.name.c_str();
  for (const char* at : {"40", "60", "100"}) {  // 40 is the end of the first part
    CAPTURE(at);
    change whole{.pair = 0.2, .rule = pair_rule::table}, cut = whole, rest = whole;
    const auto run_to = [&](const char* steps, change& c, std::vector<const char*> more = {}) {
      std::vector<const char*> all{
          "--quiet", "--steps", steps, "--checkpoint", name, "--checkpoint-every", at};
      all.insert(all.end(), more.begin(), more.end());
      REQUIRE(run_in_two_parts(all, c) == 0);
    };
    run_to("100", whole);
    run_to(at, cut);
    run_to("100", rest, {"--restart", name});
    CHECK(rest.digest == whole.digest);
    CHECK(rest.seen_in_second == 100 - std::stoi(at));
  }
}

TEST_CASE("a run that keeps a checkpoint leaves its last step in it") {
  const scratch_file file;
  const char* name = file.name.c_str();
  change first, rest;
  REQUIRE(run_in_two_parts({"--quiet", "--steps", "70", "--checkpoint", name}, first) == 0);
  REQUIRE(run_in_two_parts({"--quiet", "--steps", "70", "--restart", name}, rest) == 0);
  CHECK(rest.digest == first.digest);
  CHECK(rest.seen_in_second == 0);
}

TEST_CASE("what does not fit the checkpoint is refused with the difference, or told") {
  const scratch_file file;
  const char* name = file.name.c_str();
  change first;
  REQUIRE(run_in_two_parts(
              {"--quiet", "--steps", "60", "--checkpoint", name, "--checkpoint-every", "60"},
              first) == 0);
  const auto said = [&](change c, int code, std::vector<const char*> more = {}) {
    std::string words;
    std::vector<const char*> all{"--quiet", "--steps", "70", "--restart", name};
    all.insert(all.end(), more.begin(), more.end());
    CHECK(run_in_two_parts(all, c, &words) == code);
    return words;
  };
  const auto has = [](const std::string& text, const char* words) {
    return text.find(words) != text.npos;
  };
  CHECK(said({}, 0).empty());
  CHECK(has(said({.density = 2}, 1),
            "whose material 0 has the density 1, and this program gives it 2"));
  CHECK(has(said({.pair = 0.7}, 1), "other properties for contacts of the materials 0 and 0"));
  CHECK(said({.pair = 0.3}, 0).empty());  // the mean of the two
  CHECK(
      has(said({.rule = pair_rule::least}, 1),
          "other rules for pairs of materials (world.pair_rules), and this program takes friction "
          "by the least and restitution by the mean"));
  CHECK(has(said({.other_names = true}, 1), "kept seen, and this program keeps watched"));
  CHECK(has(said({.by_hand = true}, 1), "a step is to be taken before the run goes on"));
  CHECK(has(said({.gravity = 7}, 0), "with other parameters: gravity_z is -7 and was -5"));
  CHECK(has(said({}, 0, {"--dt", "0.002"}), "dt is 0.002 and was 0.005"));
  CHECK(has(said({}, 0, {"--iterations", "20"}), "iterations is 20 and was 10"));
  CHECK(has(said({}, 0, {"--seed", "9"}),
            "with its seed 1, not with the seed 9 of this run: bodies are those of the file"));
  CHECK(has(said({}, 1, {"--checkpoint", "/tmp/none/a.h5"}), "none/a.h5: No such file"));

  serial::link link;
  world<scenario<bodies<sphere, box, plane>, transport<serial>, features<checkpoints>>> other(link);
  CHECK_THROWS_WITH(read_checkpoint(other, file.name),
                    doctest::Contains("that has bodies<sphere, plane>, and this program "
                                      "bodies<sphere, box, plane>"));
  const auto without = [](std::vector<const char*> words) {
    (void)parse<options>(static_cast<int>(words.size()), words.data(), {}, "",
                         detail::withdraw_options<scenario<bodies<sphere>>>);
  };
  CHECK_THROWS_WITH(without({"program", "--checkpoint", "a.h5"}),
                    doctest::Contains("name features<checkpoints> in its scenario"));
}
