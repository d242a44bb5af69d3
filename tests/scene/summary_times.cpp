// What the summary of a run says about time and units: shares of the wall time by name, and the
// names of units in the summary, the table and the JSON file.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <talus/core/clock.hpp>
#include <talus/observe/summary.hpp>
#include <talus/observe/time_series.hpp>
#include <talus/state/step_times.hpp>
#include <talus/talus.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

using watched =
    scenario<bodies<sphere, plane>, decomposition<any_decomposition>, features<energy_ledger>>;

void wait(double seconds) {
  for (const double end = detail::wall_seconds() + seconds; detail::wall_seconds() < end;) {
  }
}

/// A row of balls on a floor, along x.
void set_up(world<watched>& w) {
  w.decompose(slabs<dynamic>{.axis = {1, 0, 0}, .lower = 0, .upper = 8});
  w.gravity({0, 0, -9.81});
  const auto m = w.material({});
  w.global([&](auto& scope) { scope.add(plane{}, m); });
  for (int k = 0; k < 8; ++k)
    w.add_if_local(body{.shape = sphere{0.4}, .position = {k + 0.5, 0, 0.5}, .material = m});
}

/// The summary of a run of 20 steps after `prepare`.
template <class Prepare>
summary summary_of(int ranks, Prepare prepare) {
  summary r;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    const double began = detail::wall_seconds();
    world<watched> w(link);
    set_up(w);
    prepare(w);
    w.simulate({.steps = 20, .dt = 1e-3});
    const summary mine = summarize(w, 0, detail::wall_seconds() - began);
    if (link.rank() == 0) r = mine;
  });
  return r;
}

double seconds_of(const summary& r, const std::string& name) {
  for (const auto& [one, seconds] : r.functions)
    if (one == name) return seconds;
  return -1;
}

double share_of(const summary& r, const std::string& name) {
  std::string small;
  for (const auto& [one, share] : detail::time_shares(r, small))
    if (one == name) return share;
  return -1;
}

bool has(const std::string& text, const std::string& words) {
  return text.find(words) != text.npos;
}

}  // namespace

TEST_CASE("functions of the program are named, and all shares of the wall time sum to 100") {
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    const summary r = summary_of(ranks, [](auto& w) {
      w.observe("height of the row", every{2}, [](auto&) { wait(0.004); });
      w.observe(every{1}, [](auto&) { wait(0.002); });
      w.after_each_step("pause", [] { wait(0.001); });
      w.stop_when(every{4}, [](auto&) { return wait(0.004), false; });
      wait(0.02);  // of the set-up
    });
    CAPTURE(to_text(r));
    // At least that long; on a busy machine a function may be interrupted.
    CHECK(seconds_of(r, "height of the row") >= 0.04);
    CHECK(seconds_of(r, "functions of the program") >= 0.04);
    CHECK(seconds_of(r, "pause") >= 0.02);
    CHECK(seconds_of(r, "stop conditions") >= 0.02);
    CHECK(seconds_of(r, "monitors") > 0);
    CHECK(share_of(r, "set-up and the rest") > 0);
    std::string small;
    double sum = 0;
    for (const auto& [name, share] : detail::time_shares(r, small)) {
      CHECK(share == std::round(share));
      sum += share;
    }
    CHECK(sum == 100);
    // Nothing is counted twice.
    double seconds = r.seconds_mean.detect + r.seconds_mean.respond + r.seconds_mean.integrate +
                     r.seconds_mean.exchange;
    for (const auto& one : r.functions_mean) {
      CHECK(one.second >= 0);
      seconds += one.second;
    }
    CHECK(seconds < r.wall_seconds);
    CHECK(has(to_text(r), "height of the row "));
    CHECK(has(to_json(r), "\"seconds_height_of_the_row\": "));
    CHECK(has(to_text(r), " rank") == (ranks > 1));
    CHECK(has(to_text(r), "reductions") == (ranks > 1));
  }
}

TEST_CASE("the time of a function is without that of stages and of functions in it") {
  const summary r = summary_of(1, [](auto& w) {
    w.observe("outer", every{1}, [](auto& world) {
      auto& s = detail::state_of(world);
      const detail::function_clock clock(s, s.functions.number("inner"));
      wait(0.003);
    });
  });
  CHECK(seconds_of(r, "inner") >= 0.06);
  CHECK(seconds_of(r, "outer") < 0.02);
  CHECK(seconds_of(r, "outer") >= 0);
}

TEST_CASE("the wait for the agreement on the end of a call is that for messages") {
  const summary r = summary_of(2, [](auto& w) {
    w.observe("uneven", every{1}, [](auto& world) {
      if (world.rank() == 1) wait(0.004);
    });
  });
  CHECK(r.seconds.exchange >= 0.06);
  CHECK(seconds_of(r, "stop conditions") < 0.02);
}

TEST_CASE("where ranks have different functions, their times have one name") {
  const summary r = summary_of(2, [](auto& w) {
    const std::string name = w.rank() == 0 ? "of the first" : "of the second";
    w.after_each_step(name, [] { wait(0.002); });
  });
  REQUIRE(r.functions.size() == 2);
  CHECK(r.functions[1].first == "functions of the program");
  CHECK(r.functions[1].second >= 0.04);
}

TEST_CASE("units have the names that the program gives, also in forms of several") {
  const unit_names si{.length = "m", .mass = "kg", .time = "s"};
  CHECK(detail::in_units("M L^2/T^2", si) == "kg m^2/s^2");
  CHECK(detail::in_units("L^2/(T^2 K)", si) == "m^2/(s^2 K)");
  CHECK(detail::in_units("M L/T", {.length = "mm"}) == "M mm/T");
  CHECK(detail::in_units("1", si) == "1");
  CHECK(detail::unit_behind("L/T", si) == " m/s");
  CHECK(detail::unit_behind("L/T", {}).empty());
  CHECK(detail::unit_behind("1", si).empty());

  const std::string file = "/tmp/talus_units_" + std::to_string(getpid()) + ".csv";
  unlink(file.c_str());
  const auto prepare = [&](auto& w) {
    w.units({.length = "m", .mass = "kg", .time = "s"});
    w.record("torque", 1, "M L^2/T^2");
    time_series table(file, w.rank() == 0);
    table.sample(w);
    table.finish();
    CHECK_THROWS_WITH(w.units({.length = "m,m"}), doctest::Contains("cannot write the unit 'm,m'"));
  };
  for (const int ranks : {1, 2}) {
    const summary r = summary_of(ranks, prepare);
    const std::string text = to_text(r);
    CAPTURE(text);
    CHECK(has(text, ", 20 steps of 0.001 s\n"));
    CHECK(has(text, " kg m^2/s^2, fastest body "));
    CHECK(has(text, " m/s, momentum of all ("));
    CHECK(has(text, ") kg m/s\n"));
    CHECK(has(text, " kg m^2/s^2 at the start; "));
    CHECK(has(to_json(r), "\"unit_mass\": \"kg\""));
    std::stringstream table;
    table << std::ifstream(file).rdbuf();
    CHECK(has(table.str(), "step [1],time [s],"));
    CHECK(has(table.str(), ",max_speed [m/s],"));
    CHECK(has(table.str(), ",torque [kg m^2/s^2]\n"));
    unlink(file.c_str());
  }
  const summary bare = summary_of(1, [](auto&) {});
  CHECK(has(to_text(bare), ", 20 steps of 0.001\n"));
  CHECK(!has(to_json(bare), "unit_"));
}

TEST_CASE("of the times of steps the median, the slowest of 99 in 100 and the slowest are found") {
  detail::step_times times;
  CHECK(times.found().longest == 0);
  CHECK(times.found().median == 0);
  for (std::uint64_t k = 1; k <= 1000; ++k) times.add(k == 700 ? 9.0 : 1e-6 * double(k), k);
  const step_seconds found = times.found();
  CHECK(found.median == doctest::Approx(500e-6).epsilon(0.025));
  CHECK(found.p99 == doctest::Approx(991e-6).epsilon(0.025));
  CHECK(found.longest == 9);
  CHECK(found.slowest_step == 700);
  detail::step_times extremes;
  for (const double seconds : {0.0, 1e-300, 1e300}) extremes.add(seconds, 1);
  CHECK(extremes.quantile(0.3) <= 1.1e-7);
  CHECK(extremes.found().longest == 1e300);
}

TEST_CASE("times of steps leave out the functions of the program, and name the slowest step") {
  for (const int ranks : {1, 2}) {
    CAPTURE(ranks);
    const std::string file = "/tmp/talus_step_times_" + std::to_string(getpid()) + ".json";
    const std::string count = std::to_string(ranks);
    const char* arguments[] = {"steps",   "--steps",     "60",     "--quiet",
                               "--ranks", count.c_str(), "--json", file.c_str()};
    const int code =
        run<watched>(static_cast<int>(std::size(arguments)), const_cast<char**>(arguments),
                     [](auto& w, const options& options) {
                       set_up(w);
                       w.after_each_step("spin", [&] {
                         if (w.steps() == 30) wait(0.2);
                       });
                       w.simulate({.steps = options.steps, .dt = 1e-3});
                     });
    CHECK(code == 0);
    std::stringstream text;
    text << std::ifstream(file).rdbuf();
    unlink(file.c_str());
    unlink((file + ".config.toml").c_str());
    const auto value = [&](const std::string& key) {
      const auto at = text.str().find("\"" + key + "\": ");
      REQUIRE(at != std::string::npos);
      return std::stod(text.str().substr(at + key.size() + 4));
    };
    const double median = value("cpu_seconds_per_step_median");
    CHECK(median > 0);
    CHECK(median <= value("cpu_seconds_per_step_p99"));
    CHECK(value("cpu_seconds_per_step_p99") <= value("cpu_seconds_per_step_longest"));
    CHECK(value("cpu_seconds_per_step_longest") < 0.1);
    CHECK(value("slowest_step") >= 1);
    CHECK(value("slowest_step") <= 60);
  }
}
