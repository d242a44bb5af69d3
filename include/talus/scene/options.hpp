#pragma once
// The options of every example. The only header that includes CLI11: include it at the edge.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace talus {

/// Thrown by parse() when the user asks for help: what() is the text to print; not a failure.
struct help_requested : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Thrown by parse() for a command line that makes no sense: what() is one line for the user.
struct usage_error : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// The options of a program while they are described, and the reader of its command line.
class command_line {
 public:
  explicit command_line(const std::string& description) : app_(description) {
    app_.set_help_flag("--help", "show this help and stop");
    app_.get_formatter()->column_width(28);
    app_.allow_extras();  // refused below, with a hint
  }
  command_line(const command_line&) = delete;
  command_line& operator=(const command_line&) = delete;

  /// An option `name` ("--spheres") for a number or a text; the variable holds the default. A bool
  /// makes an option without a value, which sets it.
  template <class Value>
  void add(const std::string& name, Value& value, const std::string& meaning) {
    add_option(name, value, meaning);
  }
  /// A number with limits, both allowed. A default outside of them stands for "not given".
  template <class Value>
  void add(const std::string& name, Value& value, const std::string& meaning,
           std::type_identity_t<Value> least,
           std::type_identity_t<Value> most = std::numeric_limits<Value>::max()) {
    CLI::Option* option = add_option(name, value, meaning);
    if (value < least || value > most) option->default_str("");
    const std::string limits = most == std::numeric_limits<Value>::max()
                                   ? "at least " + print(least)
                                   : "between " + print(least) + " and " + print(most);
    require(option, value, limits, [=](Value v) { return v >= least && v <= most; });
  }
  /// A number above zero.
  void add_positive(const std::string& name, double& value, const std::string& meaning) {
    require(add_option(name, value, meaning), value, "positive", [](double v) { return v > 0; });
  }
  /// A condition on all values together: a function that throws usage_error.
  void check(std::function<void()> condition) { conditions_.push_back(std::move(condition)); }

  /// Reads the arguments into the variables. Throws help_requested and usage_error.
  void parse(int argc, const char* const* argv) {
    try {
      app_.parse(argc, const_cast<char**>(argv));
    } catch (const CLI::CallForHelp&) {
      throw help_requested(app_.help());
    } catch (const CLI::ParseError& e) {
      throw usage_error(std::string(e.what()) + "; see --help");
    }
    if (const auto unknown = app_.remaining(); !unknown.empty()) refuse(unknown.front());
    for (const auto& condition : conditions_) condition();
  }

 private:
  template <class Value>
  static std::string print(const Value& value) {
    std::ostringstream text;
    text << value;
    return text.str();
  }

  template <class Value>
  CLI::Option* add_option(const std::string& name, Value& value, const std::string& meaning) {
    names_.push_back(name);
    if constexpr (std::same_as<Value, bool>) {
      return app_.add_flag(name, value, meaning)
          ->multi_option_policy(CLI::MultiOptionPolicy::Throw);
    } else if constexpr (std::same_as<Value, std::string>) {
      return app_.add_option(name, value, meaning)->capture_default_str();
    } else {
      static_assert(std::integral<Value> || std::floating_point<Value>,
                    "an option holds a number, a bool or a std::string");
      return app_.add_option(name, value, meaning)
          ->capture_default_str()
          ->check([](const std::string& s) {
            Value number{};
            const bool wraps = std::unsigned_integral<Value> && s.starts_with('-');
            if (!wraps && CLI::detail::lexical_cast(s, number)) {
              if constexpr (std::integral<Value>) return std::string();
              if (std::isfinite(static_cast<double>(number))) return std::string();
            }
            return std::string(std::unsigned_integral<Value> ? "needs a whole number of at least 0"
                               : std::integral<Value>        ? "needs a whole number"
                                                             : "needs a finite number") +
                   ", but is '" + s + "'";
          });
    }
  }

  template <class Value, class Allowed>
  void require(CLI::Option* option, const Value& value, std::string what, Allowed allowed) {
    check([option, &value, what = std::move(what), allowed] {
      if (option->count() > 0 && !allowed(value))
        throw usage_error(option->get_name() + " must be " + what + ", but is " + print(value) +
                          "; see --help");
    });
  }

  [[noreturn]] void refuse(const std::string& argument) const {
    const std::string name = argument.substr(0, argument.find('='));
    const auto closest = std::min_element(names_.begin(), names_.end(),
                                          [&](const std::string& a, const std::string& b) {
                                            return edits(name, a) < edits(name, b);
                                          });
    const bool close = edits(name, *closest) <= std::max<std::size_t>(2, closest->size() / 3);
    throw usage_error("'" + argument + "' is not an option of this program; " +
                      (close ? "did you mean " + *closest + "? " : "") + "see --help");
  }

  /// Insertions, deletions and changes of letters between two words (Levenshtein).
  static std::size_t edits(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
      std::size_t diagonal = std::exchange(row[0], i);
      for (std::size_t j = 1; j <= b.size(); ++j)
        diagonal = std::exchange(
            row[j], std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])}));
    }
    return row.back();
  }

  CLI::App app_;
  std::vector<std::string> names_{"--help"};
  std::vector<std::function<void()>> conditions_;
};

/// What every example can be told. A scenario derives from it to set defaults and add its own:
///   struct well_options : talus::options {
///     int spheres = 3000;
///     well_options() { steps = 6000; }
///     void describe(auto& cli) {
///       options::describe(cli);
///       cli.add("--spheres", spheres, "number of spheres", 0);
///     }
///   };
struct options {
  std::size_t steps = 1000;    ///< time steps
  double dt = 0.005;           ///< length of a step, in units of time
  int ranks = 0;               ///< ranks to start; 0: as the decomposition says
  int iterations = 10;         ///< of the contact solver, per step
  double tolerance = 0;        ///< contact residual to iterate to; 0: fixed iterations
  int max_iterations = 0;      ///< at most, with a tolerance; 0: the solver's own limit
  std::uint64_t seed = 1;      ///< of all random numbers
  std::string json;            ///< file for the results; empty: none
  std::string csv;             ///< file for a time series; empty: none
  std::size_t csv_every = 10;  ///< steps between its lines
  bool quiet = false;          ///< no progress, no summary
  std::string frames;          ///< folder for pictures; empty: none
  std::size_t every = 100;     ///< steps between pictures
  std::string colour;          ///< "rank" or "speed"; empty: as the scene likes it
  bool copies = false;         ///< pictures show shadow copies
  bool domains = false;        ///< pictures show what each rank owns

  void describe(auto& cli) {
    cli.add("--steps", steps, "time steps");
    cli.add_positive("--dt", dt, "length of a time step");
    cli.add("--ranks", ranks, "ranks to start (default: as the decomposition says)", 1);
    cli.add("--iterations", iterations, "iterations of the solver per step", 1);
    cli.add("--tolerance", tolerance, "contact residual to iterate to (default: fixed iterations)",
            1e-14, 0.5);
    cli.add("--max-iterations", max_iterations, "at most, with --tolerance (default: 1000)", 1);
    cli.add("--seed", seed, "seed of all random numbers");
    cli.add("--json", json, "write the results to this file");
    cli.add("--csv", csv, "write a time series, comma-separated, to this file");
    cli.add("--csv-every", csv_every, "steps from one of its lines to the next", 1);
    cli.add("--quiet", quiet, "no progress, no summary");
    cli.add("--frames", frames, "write pictures for POV-Ray into this folder");
    cli.add("--every", every, "steps from one picture to the next", 1);
    cli.add("--colour", colour, "of bodies in pictures: by rank or by speed");
    cli.add("--show-copies", copies, "pictures show shadow copies too");
    cli.add("--show-domains", domains, "pictures show what each rank owns");
    cli.check([this] {
      if (!colour.empty() && colour != "rank" && colour != "speed")
        throw usage_error("--colour must be rank or speed, but is '" + colour + "'; see --help");
    });
  }
};

/// Reads a command line; `defaults` holds the values of what it does not name. Throws
/// help_requested and usage_error, and never ends the program.
template <class Options = options>
[[nodiscard]] Options parse(int argc, const char* const* argv, Options defaults = {},
                            const std::string& description = "") {
  command_line cli(description);
  defaults.describe(cli);
  cli.parse(argc, argv);
  return defaults;
}

}  // namespace talus
