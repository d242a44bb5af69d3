#pragma once
// A command line from any bytes, and the properties of the reader of options for all of them.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>
#include <talus/core/error.hpp>
#include <talus/scene/options.hpp>
#include <vector>

namespace fuzz {

struct options : talus::options {
  int spheres = 3000;
  long offset = -7;
  std::uint8_t small = 3;
  float ratio = 0.5F;
  double share = 0.25;
  bool flat = false;
  std::string name = "well";
  std::vector<std::string> files;

  void describe(talus::command_line& cli) {
    talus::options::describe(cli);
    cli.add("--spheres", spheres, "a whole number with limits", -5, 100000);
    cli.add("--offset", offset, "a whole number");
    cli.add("--small", small, "a number of one byte");
    cli.add("--ratio", ratio, "a number in single precision");
    cli.add("--share", share, "a number with limits", 0, 1);
    cli.add("--flat", flat, "yes or no");
    cli.add("--name", name, "a text");
    cli.add_rest("FILES", files, "files");
    cli.check([this] {
      if (flat && spheres > 5000) throw talus::usage_error("--flat holds at most 5000 spheres");
    });
  }
};

inline void demand(bool condition) {
  if (!condition) std::abort();
}

/// Words, ended by line feeds, of a command line.
inline std::vector<std::string> words_of(std::string_view bytes) {
  std::vector<std::string> words{"program"};
  while (!bytes.empty()) {
    const auto end = bytes.find('\n');
    words.emplace_back(bytes.substr(0, bytes.substr(0, end).find('\0')));
    bytes = end == bytes.npos ? std::string_view{} : bytes.substr(end + 1);
  }
  return words;
}

/// "" if the words are accepted, else the reason; aborts if a promise does not hold.
inline std::string read_options(const std::vector<std::string>& words, options& into) {
  std::vector<const char*> pointers;
  for (const std::string& word : words) pointers.push_back(word.c_str());
  try {
    into = talus::parse<options>(static_cast<int>(pointers.size()), pointers.data(), {}, "fuzz");
  } catch (const talus::help_requested& help) {
    const std::string_view text = help.what();
    demand(text.find("Usage: program [OPTIONS] FILES") != text.npos);
    return "help";
  } catch (const talus::usage_error& error) {
    const std::string text = error.what();
    demand(text.size() > 10);
    return text;
  }
  return "";
}

inline void check_options(std::string_view bytes) {
  const auto words = words_of(bytes);
  options o;
  const std::string wrong = read_options(words, o);
  options again;
  demand(read_options(words, again) == wrong);
  if (!wrong.empty()) return;
  demand(again.spheres == o.spheres && again.dt == o.dt && again.files == o.files);
  demand(o.spheres >= -5 && o.spheres <= 100000 && !(o.flat && o.spheres > 5000));
  demand(o.dt > 0 && std::isfinite(o.dt));
  demand(o.share >= 0 && o.share <= 1 && std::isfinite(o.ratio));
  demand(o.ranks >= 0 && o.iterations >= 1 && o.csv_every >= 1 && o.every >= 1);
  demand(o.tolerance == 0 || (o.tolerance >= 1e-14 && o.tolerance <= 0.5));
  demand(o.colour.empty() || o.colour == "rank" || o.colour == "speed");
  for (const std::string& file : o.files) demand(!file.starts_with('-'));
  // Options that were read are read again from their print.
  const auto digits = [](double x) { return talus::detail::text(x, 17); };
  options back;
  demand(read_options({"program", "--dt", digits(o.dt), "--share=" + digits(o.share), "--offset",
                       std::to_string(o.offset), "--small=" + std::to_string(o.small), "--seed",
                       std::to_string(o.seed), "--ratio=" + digits(static_cast<double>(o.ratio)),
                       "--steps=" + std::to_string(o.steps)},
                      back)
             .empty());
  demand(back.dt == o.dt && back.share == o.share && back.offset == o.offset &&
         back.small == o.small && back.seed == o.seed && back.ratio == o.ratio &&
         back.steps == o.steps);
}

}  // namespace fuzz
