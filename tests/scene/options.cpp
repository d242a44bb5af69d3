#include "talus/scene/options.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <array>
#include <filesystem>

using namespace talus;

namespace {

struct well_options : talus::options {
  int spheres = 3000;
  double damping = 0.9;
  bool flat = false;
  well_options() { steps = 6000; }
  void describe(auto& cli) {
    options::describe(cli);
    cli.add("--spheres", spheres, "number of spheres", 0);
    cli.add("--damping", damping, "part of the velocity kept", 0, 1);
    cli.add("--flat", flat, "no wall");
    cli.check([this] {
      if (flat && spheres > 5000) throw usage_error("--flat holds at most 5000 spheres");
    });
  }
};

template <class Options = options>
Options parse_words(std::vector<const char*> words) {
  words.insert(words.begin(), "program");
  return parse<Options>(static_cast<int>(words.size()), words.data(), {}, "a program");
}

template <class Options = options>
std::string refusal(std::vector<const char*> words) {
  try {
    parse_words<Options>(words);
  } catch (const usage_error& e) {
    return e.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("what is not named has its default") {
  const auto o = parse_words({});
  CHECK(o.steps == 1000);
  CHECK(o.dt == 0.005);
  CHECK(o.ranks == 0);
  CHECK(o.iterations == 10);
  CHECK(o.seed == 1);
  CHECK(o.json.empty());
  CHECK(o.csv.empty());
  CHECK(o.csv_every == 10);
  CHECK(!o.quiet);
  CHECK(parse_words<well_options>({}).steps == 6000);
}

TEST_CASE("every option is read") {
  const auto o = parse_words<well_options>({"--steps",
                                            "12",
                                            "--dt=0.25",
                                            "--ranks",
                                            "4",
                                            "--iterations",
                                            "50",
                                            "--seed",
                                            "18446744073709551615",
                                            "--json",
                                            "out.json",
                                            "--csv",
                                            "out.csv",
                                            "--csv-every",
                                            "3",
                                            "--quiet",
                                            "--checkpoint",
                                            "out.h5",
                                            "--checkpoint-every",
                                            "7",
                                            "--restart",
                                            "in.h5",
                                            "--output",
                                            "out",
                                            "--output-every",
                                            "8",
                                            "--output-surfaces",
                                            "--spheres",
                                            "0",
                                            "--damping",
                                            "1"});
  CHECK(o.steps == 12);
  CHECK(o.dt == 0.25);
  CHECK(o.ranks == 4);
  CHECK(o.iterations == 50);
  CHECK(o.seed == ~std::uint64_t{0});
  CHECK(o.json == "out.json");
  CHECK(o.csv == "out.csv");
  CHECK(o.csv_every == 3);
  CHECK(o.quiet);
  CHECK(o.checkpoint == "out.h5");
  CHECK(o.checkpoint_every == 7);
  CHECK(o.restart == "in.h5");
  CHECK(o.output == "out");
  CHECK(o.output_every == 8);
  CHECK(o.output_surfaces);
  CHECK(o.spheres == 0);
  CHECK(o.damping == 1);
  CHECK(!o.flat);
}

TEST_CASE("values are read as they are meant") {
  CHECK(parse_words({"--steps", "010"}).steps == 10);
  CHECK(parse_words({"--seed", "0xfF"}).seed == 255);
  CHECK(parse_words({"--steps", "+5"}).steps == 5);
  CHECK(parse_words({"--dt", "+2.5e-3"}).dt == 2.5e-3);
  CHECK(parse_words({"--json=--quiet"}).json == "--quiet");
  CHECK(parse_words({"--json", "a b=c"}).json == "a b=c");
  CHECK_THROWS_WITH_AS(parse_words({"--json="}),
                       "--json needs a value, but is empty: give it one, or leave it out",
                       usage_error);
  CHECK(!parse_words<well_options>({"--flat=no"}).flat);
  CHECK(parse_words<well_options>({"--flat=true"}).flat);
}

TEST_CASE("numbers of every type keep every digit") {
  std::int64_t least = 0;
  signed char small = 0;
  float single = 0.1f;
  double fine = 0, large = 100000;
  command_line cli("");
  cli.add("--least", least, "");
  cli.add("--small", small, "", -5);
  cli.add("--single", single, "");
  cli.add("--fine", fine, "");
  cli.add("--large", large, "");
  const char* words[] = {"program", "--least", "-9223372036854775808",
                         "--small", "-5",      "--single",
                         "-0.3",    "--fine",  "0.1"};
  cli.parse(9, words);
  CHECK(least == std::numeric_limits<std::int64_t>::min());
  CHECK(small == -5);
  CHECK(single == -0.3f);
  CHECK(fine == 0.1);
  const char* ask[] = {"program", "--help"};
  std::string help;
  try {
    cli.parse(2, ask);
  } catch (const help_requested& h) {
    help = h.what();
  }
  CHECK(help.find("--single FLOAT=0.1 ") != help.npos);
  CHECK(help.find("--least INT=0 ") != help.npos);
  CHECK(help.find("--large FLOAT=100000 ") != help.npos);
}

TEST_CASE("what is no option is the rest, where there may be one") {
  std::vector<std::string> files;
  bool quiet = false;
  command_line cli("");
  cli.add_rest("FILES", files, "to read");
  cli.add("--quiet", quiet, "no words");
  const char* words[] = {"program", "a", "--quiet", "b"};
  cli.parse(4, words);
  CHECK(quiet);
  CHECK(files == std::vector<std::string>{"a", "b"});
  const char* wrong[] = {"program", "-x"};
  CHECK_THROWS_AS(cli.parse(2, wrong), usage_error);
}

TEST_CASE("options without a name, or described twice, are refused") {
  int value = 0;
  command_line cli("");
  cli.add("--value", value, "");
  CHECK_THROWS_WITH_AS(cli.add("--value", value, ""), "the option --value is described twice",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(cli.add("--help", value, ""), "the option --help is described twice",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(cli.add("value", value, ""),
                       "the option 'value' needs a name like --spheres", std::invalid_argument);
}

TEST_CASE("what is not known is refused, with the nearest name") {
  CHECK(refusal({"--stps", "3"}) ==
        "'--stps' is not an option of this program; did you mean --steps? see --help");
  CHECK(refusal({"--step=3"}) ==
        "'--step=3' is not an option of this program; did you mean --steps? see --help");
  CHECK(refusal<well_options>({"--sphere", "3"}) ==
        "'--sphere' is not an option of this program; did you mean --spheres? see --help");
  CHECK(refusal({"--spheres", "3"}).find("'--spheres' is not an option") == 0);
  CHECK(refusal({"--colour-of-the-sky"}) ==
        "'--colour-of-the-sky' is not an option of this program; see --help");
  CHECK(refusal({"well"}) == "'well' is not an option of this program; see --help");
  CHECK(refusal({"--hlep"}).find("did you mean --help?") != std::string::npos);
}

TEST_CASE("values that make no sense are refused") {
  CHECK(refusal({"--dt", "0"}) == "--dt must be positive, but is 0; see --help");
  CHECK(refusal({"--dt", "-0.1"}) == "--dt must be positive, but is -0.1; see --help");
  CHECK(refusal({"--dt", "nan"}) == "--dt: needs a finite number, but is 'nan'; see --help");
  CHECK(refusal({"--dt", "inf"}) == "--dt: needs a finite number, but is 'inf'; see --help");
  CHECK(refusal({"--dt", "fast"}) == "--dt: needs a finite number, but is 'fast'; see --help");
  CHECK(refusal({"--steps", "-1"}) ==
        "--steps: needs a whole number of at least 0, but is '-1'; see --help");
  CHECK(refusal({"--steps", "1.5"}).find("--steps: needs a whole number") == 0);
  CHECK(refusal({"--ranks", "0"}) == "--ranks must be at least 1, but is 0; see --help");
  CHECK(refusal({"--ranks", "99999999999"}) ==
        "--ranks: needs a whole number, but is '99999999999'; see --help");
  CHECK(refusal({"--iterations", "0"}) == "--iterations must be at least 1, but is 0; see --help");
  CHECK(refusal<well_options>({"--damping", "1.5"}) ==
        "--damping must be between 0 and 1, but is 1.5; see --help");
  CHECK(refusal({"--json"}) == "--json needs a value; see --help");
  CHECK(refusal({"--json", "--quiet"}) == "--json needs a value, but --quiet follows; see --help");
  CHECK(refusal({"--checkpoint-every", "5"}) ==
        "--checkpoint-every needs --checkpoint FILE; see --help");
  CHECK(refusal({"--output-every", "0"}) ==
        "--output-every must be at least 1, but is 0; see --help");
  CHECK(refusal({"--output-surfaces"}) == "--output-surfaces needs --output NAME; see --help");
  CHECK(refusal({"--output-every", "5"}) == "--output-every needs --output NAME; see --help");
  CHECK(refusal({"--csv-every", "5"}) == "--csv-every needs --csv FILE; see --help");
  CHECK(refusal({"--view-every", "5"}) == "--view-every needs --view FILE; see --help");
  CHECK(refusal({"--view-contacts"}) == "--view-contacts needs --view FILE; see --help");
  CHECK(refusal({"--colour", "speed"}) == "--colour needs --frames DIR or --view FILE; see --help");
  CHECK(refusal({"--view", "x", "--colour", "size"}) ==
        "--colour must be material, rank or speed, but is 'size'; see --help");
  CHECK(refusal({"--view", "x", "--view-every", "0"}) ==
        "--view-every must be at least 1, but is 0; see --help");
  CHECK(refusal({"--view", "x", "--csv", "x"}) ==
        "--view and --csv name the same file, x: give each its own");
  CHECK(refusal({"--json", ".//x", "--csv", "x"}) ==
        "--json and --csv name the same file, .//x: give each its own");
  CHECK(
      refusal({"--json", "./x.config.toml", "--csv", "x"}) ==
      "--json ./x.config.toml is the name of the configuration beside --csv: give it another one");
  for (const auto& [option, value, name, what, other] :
       {std::array{"--checkpoint", "x", "./x.lock", "the lock of --checkpoint", "--csv"},
        std::array{"--output", "x", "x_contacts.hdf.series", "an index of --output", "--json"},
        std::array{"--output", ".//x.hdf", "x_surfaces.hdf.series.lock", "the lock of --output",
                   "--view"},
        std::array{"--output", "x", "x_joints_0000000010.hdf", "a file of --output", "--log"},
        std::array{"--output", "x", "x_0000000010.hdf", "a file of --output", "--restart"},
        std::array{"--frames", "d/", "d/./frame_00003.pov", "a picture of --frames", "--json"},
        std::array{"--frames", ".", "frame_00003.pov", "a picture of --frames", "--csv"},
        std::array{"--output", "/tmp/x", "/tmp/../tmp/x_contacts.hdf.series",
                   "an index of --output", "--json"}})
    CHECK(refusal({option, value, other, name}) ==
          fmt::format("{} {} is the name of {}: give it another one", other, name, what));
  const std::string whole = std::filesystem::current_path().string() + "/x";
  CHECK(refusal({"--csv", "x", "--json", whole.c_str()})
            .find("--json and --csv name the same file") == 0);
  CHECK(refusal({"--frames", "d", "--json", "d/"}) ==
        "--json and --frames name the same file, d/: give each its own");
  for (const char* name :
       {"x", "x.hdf", "x_0000000010", "x_walls_0000000010.hdf", "y/x.hdf.series"})
    CHECK(parse_words({"--output", "x", "--json", name}).json == name);
  CHECK(parse_words({"--restart", "x", "--checkpoint", "./x"}).restart == "x");
  CHECK(refusal({"--every", "100"}) == "--every needs --frames DIR; see --help");
  CHECK(refusal({"--csv-every", "0"}) == "--csv-every must be at least 1, but is 0; see --help");
  CHECK(refusal({"--steps", "1", "--steps", "2"}) == "--steps is given twice; see --help");
  CHECK(refusal({"--steps="}) ==
        "--steps: needs a whole number of at least 0, but is ''; see --help");
  for (const char* number :
       {"3 ", " 3", "3x", "+-3", "--3", "0x", "0xg", "12a", "3/", "1e3", "18446744073709551616"})
    CHECK(refusal({"--steps", number}).find("--steps: needs a whole number of at least 0") == 0);
  for (const char* number : {"0.1x", "-nan", "1e999", "-inf", "0.1 ", "+-1", "."})
    CHECK(refusal({"--dt", number}).find("--dt: needs a finite number") == 0);
  CHECK(refusal<well_options>({"--flat=maybe"}) ==
        "--flat is true or false, but is 'maybe'; see --help");
  CHECK(refusal<well_options>({"--spheres", "2147483648"}).find("--spheres: needs a whole") == 0);
  CHECK(refusal<well_options>({"--spheres", "-1"}) ==
        "--spheres must be at least 0, but is -1; see --help");
  CHECK(refusal<well_options>({"--flat", "--spheres", "6000"}) ==
        "--flat holds at most 5000 spheres");
}

TEST_CASE("help is given whatever else is wrong") {
  for (const char* word : {"--stps", "--steps=x", "--json", "--quiet=maybe"})
    CHECK_THROWS_AS(parse_words({word, "--help"}), help_requested);
}

TEST_CASE("help names the options and their defaults, and is no failure") {
  std::string help;
  try {
    parse_words<well_options>({"--help"});
  } catch (const help_requested& h) {
    help = h.what();
  }
  for (const char* word : {"a program", "--steps", "6000", "--dt", "0.005", "--ranks", "--spheres",
                           "number of spheres", "3000", "--help"})
    CHECK(help.find(word) != std::string::npos);
  CHECK(help.find("=0 ") == std::string::npos);  // --ranks has no number for a default
}
