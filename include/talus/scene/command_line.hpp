#pragma once
// The reader of the command line. It is compiled once per program and optimised for size: a library
// for this took longer to compile than a world of spheres.
#include <concepts>
#include <cstddef>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace talus {

/// Thrown by parse() for --help: what() is the text to print; not a failure.
struct help_requested : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Thrown by parse() for an invalid command line: what() is one line for the user.
struct usage_error : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// One value of a file of settings (--config).
struct setting {
  enum class kind { text, number, boolean, other };
  std::string key;    ///< with the names of its tables, as in "stone.friction"
  std::string value;  ///< as text; of `other`, what it is, as in "a date"
  kind holds = kind::text;
  std::size_t line = 0;
};
/// Reads a file and passes its values on in the order of its lines. Throws usage_error.
using settings_reader = void(const std::string& file,
                             const std::function<void(const setting&)>& take);

/// Thrown by a settings_reader for a file that it cannot read; this may concern one machine only.
struct unreadable_settings : usage_error {
  using usage_error::usage_error;
};

/// Collects the options of a program and reads its command line.
class command_line {
  /// Holds the numbers of all types exactly.
  using number = long double;
  static_assert(std::numeric_limits<number>::digits >= std::numeric_limits<std::size_t>::digits);

  enum class kind { flag, text, natural, whole, real, file, pair };  // in the order of help()
  enum class origin : unsigned char { none, file, set, word };       // in the order of precedence

  struct option {
    std::string name, meaning, initial;  ///< `initial`: as help shows it; empty: not at all
    kind holds;
    void* target;
    void (*store)(void* target, number value);
    number (*load)(const void* target);
    number least, most;    ///< what `store` can take
    std::string limits{};  ///< what is allowed, in words; empty: everything
    number lower{}, upper{};
    origin from = origin::none;
    std::string place{};    ///< file and line that set it
    std::size_t files = 0;  ///< number of files read before that one
    bool soft = false;      ///< only soft contacts use it
    std::string refusal{};  ///< why this program cannot use it; empty: it can
  };

 public:
  explicit command_line(std::string_view description) : description_(description) {}
  command_line(const command_line&) = delete;
  command_line& operator=(const command_line&) = delete;

  /// An option `name` ("--spheres") for a number or a text; the variable holds the default. A bool
  /// makes an option without a value, which sets it. A material and a distribution of sizes make an
  /// option for each of their fields, as in --stone.friction (option_groups.hpp).
  template <class Value>
  void add(std::string_view name, Value& value, std::string_view meaning) {
    if constexpr (requires { add_options(*this, name, value, meaning); }) {
      add_options(*this, name, value, meaning);
    } else if constexpr (std::same_as<Value, bool>) {
      add_option(name, meaning, kind::flag, &value);
    } else if constexpr (std::same_as<Value, std::string>) {
      add_option(name, meaning, kind::text, &value);
    } else {
      static_assert(std::integral<Value> || std::floating_point<Value>,
                    "an option holds a number, a bool or a std::string");
      add_number(
          name, meaning,
          std::floating_point<Value>      ? kind::real
          : std::unsigned_integral<Value> ? kind::natural
                                          : kind::whole,
          &value, value,
          [](void* target, number v) { *static_cast<Value*>(target) = static_cast<Value>(v); },
          [](const void* target) {
            return static_cast<number>(*static_cast<const Value*>(target));
          },
          std::numeric_limits<Value>::lowest(), std::numeric_limits<Value>::max());
    }
  }
  /// A number with limits, both allowed. A default outside of them stands for "not given".
  template <class Value>
  void add(std::string_view name, Value& value, std::string_view meaning,
           std::type_identity_t<Value> least,
           std::type_identity_t<Value> most = std::numeric_limits<Value>::max()) {
    add(name, value, meaning);
    limit(least, most, value);
  }
  /// A number above zero.
  void add_positive(std::string_view name, double& value, std::string_view meaning) {
    add(name, value, meaning);
    limit_to_positive();
  }
  /// The arguments besides the options, `name` ("FILES") in the help. Without this call they are
  /// refused.
  void add_rest(std::string_view name, std::vector<std::string>& values, std::string_view meaning);
  /// Whether the command line has the option, by its name or by --set; for conditions. Files do not
  /// count: what they say about an option that is not in use has no effect.
  [[nodiscard]] bool given(std::string_view name) {
    const option* o = find(name);
    return o != nullptr && o->from >= origin::set;
  }
  /// Adds --config FILE and --set NAME=VALUE. `read` is null if this program cannot read files.
  void add_settings(settings_reader* read);
  /// Withdraws an option that has no effect in this program: the help omits it, and its use is
  /// refused with the message `refusal`. Has no effect unless an option fills that variable.
  void withdraw(std::string_view name, const void* target, std::string_view refusal);
  /// Marks the option added last as one that only soft contacts use.
  void mark_soft() { options_.back().soft = true; }
  /// Withdraws the options that only soft contacts use.
  void withdraw_soft(std::string_view refusal);
  /// A condition on all values together: a function that throws usage_error.
  void check(std::function<void()> condition) { conditions_.push_back(std::move(condition)); }

  /// Reads the arguments into the variables: first the files of --config, in their order, then
  /// options and --set, in theirs. Throws help_requested and usage_error.
  void parse(int argc, const char* const* argv);

  /// After parse(): all options with their values, a line each, as a file that --config accepts. A
  /// comment at the end of each line says where the value comes from.
  [[nodiscard]] std::string configuration() const;

 private:
  void add_option(std::string_view name, std::string_view meaning, kind holds, void* target);
  void add_number(std::string_view name, std::string_view meaning, kind holds, void* target,
                  number initial, void (*store)(void*, number), number (*load)(const void*),
                  number least, number most);
  void limit(number lower, number upper, number initial);
  void limit_to_positive();

  [[nodiscard]] option* find(std::string_view name);
  [[nodiscard]] option* find_key(std::string_view key);
  [[nodiscard]] std::string help(std::string_view program) const;
  /// Each of these returns what is wrong, or nothing.
  [[nodiscard]] std::string walk(int argc, const char* const* argv, bool files);
  [[nodiscard]] std::string read_file(const std::string& file);
  [[nodiscard]] std::string read_setting(const std::string& file, const setting& s);
  [[nodiscard]] std::string read_pair(std::string_view pair);
  [[nodiscard]] static std::string without_value(const std::string& name);
  [[nodiscard]] static std::string read_value(option& o, origin from, std::string_view value);
  static std::string read(option& o, std::string_view value, const std::string& name);
  static std::string read_number(option& o, std::string_view value, const std::string& name);
  [[nodiscard]] std::string unknown(std::string_view word, bool key) const;

  static std::string value_text(const option& o);
  static std::string print(number value, kind holds);
  static std::size_t edits(std::string_view a, std::string_view b);

  std::string description_;
  std::vector<option> options_;
  std::vector<std::function<void()>> conditions_;
  std::vector<std::string>* rest_ = nullptr;
  std::string rest_name_, rest_meaning_;
  settings_reader* reader_ = nullptr;
  std::size_t files_ = 0;  ///< read so far
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/detail/command_line_definitions.hpp"
#include "talus/scene/detail/settings_definitions.hpp"
#endif
