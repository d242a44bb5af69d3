// What a run says at its end when its calls of simulate() have steps of several lengths.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <talus/observe/summary.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/scene/detail/unused_steps.hpp>
#include <talus/scene/run.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using soft = scenario<bodies<sphere, plane>, soft_contact<hertz_mindlin, coulomb_friction>,
                      transport<serial>, features<>>;

/// A ball that hits the floor at a speed of 2, in steps of 1e-4; then, at rest, in steps of 1e-6.
summary two_lengths(int stages) {
  summary r;
  serial::launch({}, [&](serial::link& link) {
    world<soft> w(link);
    const auto m = w.material({.density = 2000, .restitution = 0.5, .youngs_modulus = 1e7});
    w.global([&](auto& s) { s.add(plane{}, m); });
    w.add(body{
        .shape = sphere{0.01}, .position = {0, 0, 0.02}, .material = m, .velocity = {0, 0, -2}});
    if (stages > 0) w.simulate({.steps = 100, .dt = 1e-4});
    if (stages > 1) w.simulate({.steps = 100, .dt = 1e-6});
    r = summarize(w, 0, 0);
  });
  return r;
}

/// Runs a program of one call of 50 steps; returns what it says on standard error.
std::string said_with(std::vector<std::string> words, const std::string& json) {
  words.insert(words.begin(), {"program", "--force", "--json", json});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  const std::string said = json + "_said";
  std::fflush(stderr);
  const int before = dup(2);
  std::FILE* const file = std::fopen(said.c_str(), "w");
  dup2(fileno(file), 2);
  (void)run<soft>(static_cast<int>(argv.size()), argv.data(), [](auto& world, const auto& options) {
    const auto m = world.material({.density = 2000, .youngs_modulus = 1e7});
    world.add(sphere{0.01}, m, {0, 0, 1});
    world.gravity({0, 0, -1});
    world.simulate({.steps = 50, .dt = std::min(options.dt, 0.01)});
    return results{{"dt", 7}, {"height", 1}, {"height", 2}};
  });
  std::fflush(stderr);
  dup2(before, 2);
  close(before);
  std::fclose(file);
  std::stringstream text;
  text << std::ifstream(said).rdbuf();
  unlink(said.c_str());
  return text.str();
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE("the shortest contact is counted in steps of its own length") {
  const summary one = two_lengths(1), two = two_lengths(2);
  REQUIRE(one.steps_per_contact > 1);
  CHECK(two.steps_per_contact == doctest::Approx(one.steps_per_contact));
  CHECK(two.shortest_contact_dt == real(1e-4));
  CHECK(two.impact_speed_max == one.impact_speed_max);
  const std::string text = to_text(two);
  CHECK(text.find("200 steps of 1e-06 to 0.0001") != text.npos);
  CHECK(to_json(two).find("\"dt_most\": 0.0001") != std::string::npos);
}

TEST_CASE("a run without steps, as a restart at the last one, has no figures of a step") {
  using scene = scenario<bodies<sphere, plane>, transport<serial>>;
  for (const int steps : {0, 2}) {
    summary r;
    serial::launch({}, [&](serial::link& link) {
      world<scene> w(link);
      w.gravity({0, 0, -1});
      const auto m = w.material({.density = 1});
      w.global([&](auto& s) { s.add(plane{}, m); });
      w.add(sphere{1}, m, {0, 0, 1});
      w.simulate({.steps = static_cast<std::size_t>(steps), .dt = 0.01});
      r = summarize(w, 1, 1);
    });
    for (const int made : {steps, 0}) {
      r.restarted_at = static_cast<std::uint64_t>(steps - made);
      r.ranks = 2;
      CAPTURE(steps);
      CAPTURE(made);
      const std::string text = to_text(r), json = to_json(r);
      for (const char* words : {"per step", "in the last step", "in a step;"})
        CHECK((text.find(words) != text.npos) == (made > 0));
      for (const char* key : {"\"contacts\"", "\"residual\"", "\"residual_max\"", "per_step"})
        CHECK((json.find(key) != json.npos) == (made > 0));
    }
  }
}

TEST_CASE("of many lengths of steps those next to each other are one") {
  detail::step_lengths lengths;
  for (int k = 0; k < 1000; ++k) lengths.change(1e-4 * (1 + k % 300), 0.5 * k);
  lengths.note(1e4);
  CHECK(lengths.all().size() == 64);
  CHECK(lengths.all().back().dt == doctest::Approx(300e-4));
  real most = 0;
  for (const auto& x : lengths.all()) most = std::max(most, x.fastest);
  CHECK(most == 1e4);
}

TEST_CASE("a key of the JSON file is there once, --steps and --dt are not ignored in silence") {
  const std::string json = "/tmp/talus_summary_" + std::to_string(getpid()) + ".json";
  const auto says = [&](std::vector<std::string> words, const std::string& what) {
    return said_with(std::move(words), json).find(what) != std::string::npos;
  };
  CHECK(says({"--steps", "51"},
             "--steps is 51, but the calls of world.simulate in this program ask for 50 steps in "
             "all: if that does not follow from it, give one .steps = options.steps"));
  CHECK(says({"--steps", "1000"}, "--steps is 1000"));  // also the default, where it is given
  CHECK(says({"--set", "steps=1000"}, "--steps is 1000"));
  CHECK(!says({"--steps", "50"}, "--steps"));
  CHECK(!says({}, "--steps"));
  CHECK(says({"--dt", "0.3"},
             "--dt is 0.3, but the steps of this program have lengths of 0.01: if these do not "
             "follow from it, give world.simulate .dt = options.dt"));
  CHECK(says({"--dt", "0.02"}, "--dt is 0.02"));  // twice as much by chance
  CHECK(!says({"--dt", "0.004"}, "--dt"));
  CHECK(!says({}, "--dt"));
  std::stringstream text;
  text << std::ifstream(json).rdbuf();
  CHECK(count(text.str(), "\"dt\":") == 1);
  CHECK(count(text.str(), "\"result_dt\": 7") == 1);
  CHECK(count(text.str(), "\"height\":") == 1);
  CHECK(count(text.str(), "\"result_height\": 2") == 1);
  unlink(json.c_str());
}

TEST_CASE("calls of simulate() that make a number of steps, and those that do so by chance") {
  using detail::make_steps;
  CHECK(make_steps({500, 1000, 20}, 1000));  // stages
  CHECK(make_steps({33, 33, 33}, 100));      // a third of it, three times
  CHECK(make_steps({20, 33, 33, 33}, 100));
  CHECK(make_steps({30, 70}, 100));
  CHECK(make_steps({500, 30, 70}, 100));
  CHECK(make_steps({}, 100));
  CHECK(make_steps({0}, 0));
  CHECK(!make_steps({50}, 0));
  CHECK(!make_steps({1000}, 50));  // a round number of the program
  CHECK(!make_steps({200}, 100));
  CHECK(!make_steps({300}, 100));
  CHECK(!make_steps({500}, 100 + 1));
  CHECK(!make_steps({50}, 100));
  CHECK(!make_steps({500, 20}, 100));
  CHECK(!make_steps({99, 500}, 100));
  for (const std::uint64_t steps : {700, 510, 34, 2040, 1079})  // of 1020
    CHECK(!make_steps(std::vector<std::uint64_t>(60, 17), steps));
  CHECK(!make_steps(std::vector<std::uint64_t>(1000, 1), 1999));
  CHECK(!make_steps(std::vector<std::uint64_t>(5000, 7), 100));
}

TEST_CASE("steps that have a length, and those that have a multiple by chance") {
  using detail::have_length;
  CHECK(have_length({}, 0.1));
  CHECK(have_length({{0.1, 0}}, 0.1));
  CHECK(have_length({{0.1, 0}, {7, 0}}, 0.1));
  CHECK(!have_length({{0.002, 0}}, 0.004));
  CHECK(!have_length({{0.002, 0}}, 0.001));
  CHECK(!have_length({{0.07, 0}, {0.08, 0}}, 0.075));
  CHECK(!have_length({{1e-5, 0}}, 0.1));
  std::vector<detail::step_lengths::entry> many;
  for (int k = 0; k < 64; ++k) many.push_back({1e-3 * (k + 1), 0});
  CHECK(have_length(many, 0.0305));
  CHECK(!have_length(many, 0.1));
}
