// Options from files and from --set: precedence, refusals with file and line, and what a run writes
// about its options.
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <talus/scene/options.hpp>
#include <talus/scene/run_configuration.hpp>
#include <thread>
#include <vector>

using namespace talus;

namespace {

struct heap_options : talus::options {
  int spheres = 3000;
  double kept = 0.9;
  bool flat = false;
  float share = 0.1F;
  std::string shares = "grid";
  material stone{.density = 2.8, .friction = 0.5};
  uniform_size radius{0.3, 0.5};
  heap_options() { steps = 6000; }
  void describe(auto& cli) {
    options::describe(cli);
    cli.add("--spheres", spheres, "number of spheres", 0);
    cli.add("--kept-speed", kept, "part of the velocity kept", 0, 1);
    cli.add("--flat", flat, "no wall");
    cli.add("--share", share, "in single precision");
    cli.add("--decomposition", shares, "how space is cut");
    cli.add("--stone", stone, "stones");
    cli.add("--radius", radius, "radii of stones");
  }
};

struct folder {
  std::string path = "/tmp/talus_settings_" + std::to_string(getpid());
  folder() { mkdir(path.c_str(), 0700); }
  ~folder() { (void)std::system(("rm -rf " + path).c_str()); }
  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(path + "/" + name) << text;
    return path + "/" + name;
  }
};

heap_options read(std::vector<std::string> words) {
  words.insert(words.begin(), "heap");
  std::vector<const char*> pointers;
  for (const std::string& word : words) pointers.push_back(word.c_str());
  return parse<heap_options>(static_cast<int>(pointers.size()), pointers.data());
}

std::string refusal(const std::vector<std::string>& words) {
  try {
    (void)read(words);
  } catch (const usage_error& e) {
    return e.what();
  }
  return "accepted";
}

/// What is said of a file with this text, without the name of the file.
std::string refusal_of(const std::string& text) {
  const folder here;
  const std::string file = here.file("box.toml", text);
  std::string said = refusal({"--config", file});
  for (auto at = said.find(file); at != said.npos; at = said.find(file))
    said.replace(at, file.size(), "box.toml");
  return said;
}

}  // namespace

TEST_CASE("options come from a file, by their names with dashes or underscores, and from tables") {
  const folder here;
  const auto o = read({"--config", here.file("box.toml", R"(
steps = 12
dt = 0.25
csv-every = 3
output_every = 4
quiet = true
flat = true
kept_speed = 1
share = 0.3
decomposition = "slabs"
seed = "18446744073709551615"
[stone]
friction = 0.7
dynamic_friction = 0.25
[radius]
lower = 0.1
)")});
  CHECK(o.steps == 12);
  CHECK(o.dt == 0.25);
  CHECK(o.csv_every == 3);
  CHECK(o.output_every == 4);
  CHECK(o.quiet);
  CHECK(o.flat);
  CHECK(o.kept == 1);
  CHECK(o.share == 0.3F);
  CHECK(o.shares == "slabs");
  CHECK(o.seed == ~std::uint64_t{0});
  CHECK(o.stone.density == 2.8);
  CHECK(o.stone.friction == 0.7);
  CHECK(o.stone.dynamic_friction == 0.25);
  CHECK(o.radius.lower == 0.1);
  CHECK(o.radius.upper == 0.5);
}

TEST_CASE(
    "later files replace earlier ones, and the command line replaces files wherever it names "
    "them") {
  const folder here;
  const std::string a = here.file("a.toml", "steps = 1\ndt = 0.1\nspheres = 10\n");
  const std::string b = here.file("b.toml", "dt = 0.2\nspheres = 20\nseed = 7\n");
  const auto o = read({"--spheres", "30", "--config", a, "--config=" + b, "--set", "seed=8"});
  CHECK(o.steps == 1);
  CHECK(o.dt == 0.2);
  CHECK(o.spheres == 30);
  CHECK(o.seed == 8);
  CHECK(read({"--config", b, "--config", a}).dt == 0.1);
  // Of an option and --set the later one counts.
  CHECK(read({"--set", "seed=8", "--seed", "9"}).seed == 9);
  CHECK(read({"--seed", "9", "--set", "seed=8"}).seed == 8);
  CHECK(read({"--set=stone.friction=0.25", "--set", "stone.dynamic-friction=0.5"}).stone.friction ==
        0.25);
  CHECK(read({"--stone.friction", "0.25"}).stone.friction == 0.25);
  CHECK(read({"--set", "decomposition=a=b"}).shares == "a=b");
}

TEST_CASE("a file with a fault is refused with its line, the key, the value and what is allowed") {
  CHECK(refusal_of("steps = 1\n\nsphere = 3\n") ==
        "box.toml:3: 'sphere' is not an option of this program; did you mean spheres? see --help");
  CHECK(
      refusal_of("[stone]\nfrction = 0.5\n") ==
      "box.toml:2: 'stone.frction' is not an option of this program; did you mean stone.friction? "
      "see --help");
  CHECK(refusal_of("colour_of_the_sky = 'blue'") ==
        "box.toml:1: 'colour_of_the_sky' is not an option of this program; see --help");
  CHECK(refusal_of("kept_speed = 1.5") ==
        "box.toml:1: kept_speed must be between 0 and 1, but is 1.5; see --help");
  CHECK(refusal_of("\nkept_speed = nan") ==
        "box.toml:2: kept_speed: needs a finite number, between 0 and 1, but is 'nan'; see --help");
  CHECK(refusal_of("dt = -inf") ==
        "box.toml:1: dt: needs a finite number, positive, but is '-inf'; see --help");
  CHECK(refusal_of("dt = 0") == "box.toml:1: dt must be positive, but is 0; see --help");
  CHECK(refusal_of("spheres = 1.5") ==
        "box.toml:1: spheres: needs a whole number, at least 0, but is '1.5'; see --help");
  CHECK(refusal_of("spheres = 2147483648") ==
        "box.toml:1: spheres: needs a whole number, at least 0, but is '2147483648'; see --help");
  CHECK(refusal_of("spheres = '300'") ==
        "box.toml:1: spheres needs a number, at least 0, but is \"300\"; see --help");
  CHECK(refusal_of("spheres = true") ==
        "box.toml:1: spheres needs a number, at least 0, but is true; see --help");
  CHECK(refusal_of("flat = 'yes'") ==
        "box.toml:1: flat needs true or false, but is \"yes\"; see --help");
  CHECK(refusal_of("decomposition = 3") ==
        "box.toml:1: decomposition needs a text in quotes, but is 3; see --help");
  CHECK(refusal_of("spheres = [1, 2]") ==
        "box.toml:1: spheres needs a number, at least 0, but is an array; see --help");
  CHECK(refusal_of("spheres = 3\n[[box]]\nwidth = 1\n[[box]]") ==
        "box.toml:2: [[box]] begins a list of tables; a program takes one: write [box]");
  CHECK(refusal_of("spheres = 2026-11-25") ==
        "box.toml:1: spheres needs a number, at least 0, but is a date or a time; see --help");
  CHECK(refusal_of("config = 'other.toml'") ==
        "box.toml:1: config stands on the command line only, not in a file");
  CHECK(refusal_of("csv-every = 3\ncsv_every = 3\n") ==
        "box.toml:2: csv_every is set twice in this file, first at box.toml:1");
  CHECK(refusal_of("steps = 3\nsteps = 4\n").find("box.toml:2:") == 0);  // in the words of toml++
  CHECK(refusal_of("steps = \n").find("box.toml:1:") == 0);
  CHECK(refusal_of("steps = 3\nfriction 0.5\n").find("box.toml:2:") == 0);
  CHECK(refusal_of("") == "accepted");
}

TEST_CASE("a file that is missing, is a folder or has no end is refused") {
  const folder here;
  CHECK(refusal({"--config", here.path + "/none.toml"}) ==
        "--config " + here.path +
            "/none.toml cannot be read: No such file or directory; give it a file that exists, or "
            "leave it out");
  CHECK(refusal({"--config", here.path}).find("cannot be read: it is a folder") !=
        std::string::npos);
  CHECK(refusal({"--config", "/dev/zero"}).find("larger than any configuration") !=
        std::string::npos);
  CHECK(refusal({"--config"}) == "--config needs a value; see --help");
}

TEST_CASE("an empty value is a mistake where it would mean nothing, and so is what is no UTF-8") {
  const std::string end = " needs a value, but is empty: give it one, or leave it out";
  CHECK(refusal({"--restart", ""}) == "--restart" + end);
  CHECK(refusal({"--json="}) == "--json" + end);
  CHECK(refusal({"--config", ""}) == "--config" + end);
  CHECK(refusal({"--config="}) == "--config" + end);
  CHECK(refusal({"--set", "checkpoint="}) == "--checkpoint" + end);
  CHECK(refusal_of("steps = 3\nrestart = ''\n") == "box.toml:2: restart" + end);
  CHECK(read({"--decomposition", ""}).shares.empty());  // "grid" is what is not given
  CHECK(refusal({"--json", "a\xff"}).find("--json needs a text in UTF-8") == 0);
  CHECK(refusal({"--json", "a\nb"}) == "--json needs a text of one line, but is \"a\\u000ab\"");
  CHECK(refusal_of("json = \"a\\u0000b\"\n") ==
        "box.toml:1: json needs a text without zero bytes, but is \"a\\u0000b\"");
}

TEST_CASE("a key of very many parts is refused before it is read") {
  std::string key = "a";
  for (int part = 1; part < 50000; ++part) key += ".a";
  CHECK(refusal_of("steps = 3\n" + key + " = 1\n") ==
        "box.toml:2: has a key with more than 100 dots, and no option has such a name");
  CHECK(refusal_of("[" + key + "]\n").find("box.toml:1: has a key with more") == 0);
  CHECK(refusal_of("steps = {" + key + " = 1}\n").find("box.toml:1: has a key with more") == 0);
  CHECK(refusal_of("# " + key + "\nsteps = 3 # " + key) == "accepted");
  CHECK(refusal_of("json = '" + key + "'\n") == "accepted");
  CHECK(refusal_of("json = \"\\\"" + key + "\"\n") == "accepted");
  CHECK(refusal_of("json = '''\n" + key + "'''\n") == "accepted");
}

TEST_CASE("a pipe is read when its writer comes") {
  const folder here;
  const std::string pipe = here.path + "/pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    std::ofstream to(pipe);
    for (const char* const part : {"steps", " = ", "7\n"}) {  // it may be slow
      std::this_thread::sleep_for(std::chrono::milliseconds(1100));
      to << part << std::flush;
    }
  });
  CHECK(read({"--config", pipe}).steps == 7);
  writer.join();
}

TEST_CASE("a pipe is refused where several processes would read it") {
  const folder here;
  const std::string pipe = here.path + "/pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  for (const char* const name : {"PMIX_RANK", "PMI_RANK"}) {  // without a number of processes
    if (std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr) return;
    setenv(name, "2", 1);
    CHECK(refusal({"--config", pipe}) ==
          "--config " + pipe +
              " cannot be read: it is a pipe, and only one of the 3 processes could read it; give "
              "it a file that exists, or leave it out");
    unsetenv(name);
  }
}

TEST_CASE("--set is refused without a value, for a name that is not known, and twice") {
  CHECK(refusal({"--set", "steps"}) ==
        "--set needs NAME=VALUE, as in --set steps=200, but is 'steps'; see --help");
  CHECK(refusal({"--set", "=3"}).find("--set needs NAME=VALUE") == 0);
  CHECK(refusal({"--set", "stps=3"}) ==
        "--set: 'stps' is not an option of this program; did you mean steps? see --help");
  CHECK(refusal({"--set", "steps=3", "--set", "steps=4"}) ==
        "--steps is given twice by --set; see --help");
  CHECK(refusal({"--set", "dt=0"}) == "--dt must be positive, but is 0; see --help");
  CHECK(refusal({"--set", "config=a.toml"}) == "--set cannot set --config: give it by itself");
}

TEST_CASE("a file may say things about outputs that are not in use, the command line may not") {
  const folder here;
  CHECK(refusal({"--config", here.file("box.toml", "csv_every = 5\nevery = 7\n")}) == "accepted");
  CHECK(refusal({"--set", "csv_every=5"}) == "--csv-every needs --csv FILE; see --help");
}

TEST_CASE("the configuration of a run is read back to the same values, each with its source") {
  const folder here;
  const std::string file = here.file("box.toml", "dt = 0.1\n[stone]\nfriction = 0.7\n");
  const auto o = read({"--config", file, "--spheres", "17", "--set", "share=0.3", "--seed",
                       "18446744073709551615", "--json", "a \"b\"\\\t.json"});
  const auto has = [&](const std::string& line) {
    return ("\n" + o.configuration).find("\n" + line + "\n") != std::string::npos;
  };
  CHECK(has("steps = 6000  # default"));
  CHECK(has("dt = 0.1  # " + file + ":1"));
  CHECK(has("stone.friction = 0.7  # " + file + ":3"));
  CHECK(has("spheres = 17  # command line"));
  CHECK(has("share = 0.3  # --set"));
  CHECK(has("seed = \"18446744073709551615\"  # command line"));
  CHECK(has("# ranks: not given"));
  CHECK(has("# restart: not given"));
  CHECK(has("# stone.dynamic_friction: not given"));
  CHECK(o.configuration.find("config =") == std::string::npos);

  const auto again = read({"--config", here.file("again.toml", o.configuration)});
  CHECK(again.steps == 6000);
  CHECK(again.dt == o.dt);
  CHECK(again.stone.friction == o.stone.friction);
  CHECK(again.spheres == 17);
  CHECK(again.share == 0.3F);
  CHECK(again.seed == o.seed);
  CHECK(again.json == "a \"b\"\\\t.json");
  CHECK(detail::differing_options(again.configuration, o.configuration).empty());
}

TEST_CASE("two configurations differ in options of the program, not in those of talus") {
  const auto a = read({"--spheres", "17", "--steps", "3"});
  const auto b = read({"--set", "stone.friction=0.25", "--json", "x.json"});
  CHECK(detail::differing_options(a.configuration, b.configuration) ==
        "spheres is 17 and was 3000, stone.friction is 0.5 and was 0.25");
  CHECK(detail::configuration_mark(a.configuration) != detail::configuration_mark(b.configuration));
}

TEST_CASE("a program of headers alone says what reads its files") {
  command_line cli("");
  int value = 0;
  cli.add("--value", value, "");
  cli.add_settings(nullptr);
  const char* words[] = {"program", "--config", "a.toml"};
  CHECK_THROWS_WITH_AS(cli.parse(3, words), doctest::Contains("#include <talus/config.hpp>"),
                       usage_error);
  const char* set[] = {"program", "--set", "value=3"};
  cli.parse(3, set);
  CHECK(value == 3);
}
