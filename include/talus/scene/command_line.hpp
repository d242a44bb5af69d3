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

/// Collects the options of a program and reads its command line.
class command_line {
  /// Holds the numbers of all types exactly.
  using number = long double;
  static_assert(std::numeric_limits<number>::digits >= std::numeric_limits<std::size_t>::digits);

  enum class kind { flag, text, natural, whole, real };  // in the order of help()

  struct option {
    std::string name, meaning, initial;  ///< `initial`: as help shows it; empty: not at all
    kind holds;
    void* target;
    void (*store)(void* target, number value);
    number least, most;    ///< what `store` can take
    std::string limits{};  ///< what is allowed, in words; empty: everything
    number lower{}, upper{};
    bool given = false;
    std::string refusal{};  ///< why this program cannot use it; empty: it can
  };

 public:
  explicit command_line(std::string_view description) : description_(description) {}
  command_line(const command_line&) = delete;
  command_line& operator=(const command_line&) = delete;

  /// An option `name` ("--spheres") for a number or a text; the variable holds the default. A bool
  /// makes an option without a value, which sets it.
  template <class Value>
  void add(std::string_view name, Value& value, std::string_view meaning) {
    if constexpr (std::same_as<Value, bool>) {
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
  /// Whether the command line has the option; for conditions.
  [[nodiscard]] bool given(std::string_view name) {
    const option* o = find(name);
    return o != nullptr && o->given;
  }
  /// Withdraws an option that has no effect in this program: the help omits it, and its use is
  /// refused with the message `refusal`. Has no effect unless an option fills that variable.
  void withdraw(std::string_view name, const void* target, std::string_view refusal);
  /// A condition on all values together: a function that throws usage_error.
  void check(std::function<void()> condition) { conditions_.push_back(std::move(condition)); }

  /// Reads the arguments into the variables. Throws help_requested and usage_error.
  void parse(int argc, const char* const* argv);

 private:
  void add_option(std::string_view name, std::string_view meaning, kind holds, void* target);
  void add_number(std::string_view name, std::string_view meaning, kind holds, void* target,
                  number initial, void (*store)(void*, number), number least, number most);
  void limit(number lower, number upper, number initial);
  void limit_to_positive();

  [[nodiscard]] option* find(std::string_view name);
  [[nodiscard]] std::string help(std::string_view program) const;
  /// Each of these returns what is wrong, or nothing.
  static std::string read(option& o, std::string_view value);
  static std::string read_number(option& o, std::string_view value);
  [[nodiscard]] std::string unknown(std::string_view word) const;

  static std::string print(number value, kind holds);
  static std::size_t edits(std::string_view a, std::string_view b);

  std::string description_;
  std::vector<option> options_;
  std::vector<std::function<void()>> conditions_;
  std::vector<std::string>* rest_ = nullptr;
  std::string rest_name_, rest_meaning_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/detail/command_line_definitions.hpp"
#endif
