#pragma once
// Wall time of what is no stage of a step: functions of the program, outputs and monitors, by name.
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talus/core/clock.hpp"

namespace talus::detail {

/// The name of the first entry: the part of steps that is no stage, such as the exchange of bodies
/// with itself of a single rank.
inline constexpr const char* name_of_other_work = "other work of steps";
/// The name of functions that the program gave without a name.
inline constexpr const char* name_of_program = "functions of the program";
/// The name of all conditions that end a call of simulate().
inline constexpr const char* name_of_conditions = "stop conditions";
/// The name of all monitors together.
inline constexpr const char* name_of_monitors = "monitors";

/// Seconds by name, in the order of the first use of the names.
class function_times {
 public:
  function_times();
  /// The number of a name, which it keeps. An empty one is that of functions of the program.
  [[nodiscard]] std::size_t number(std::string_view name);
  void add(std::size_t number, double seconds) { all_[number].second += seconds, sum_ += seconds; }
  /// Of all names together.
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] const std::vector<std::pair<std::string, double>>& all() const { return all_; }

 private:
  std::vector<std::pair<std::string, double>> all_;
  double sum_ = 0;
};

/// Adds the wall time of its life to a name, without that of stages and of other names in it.
template <class State>
class function_clock {
 public:
  function_clock(State& s, std::size_t number) : s_(s), number_(number) {}
  function_clock(const function_clock&) = delete;
  function_clock& operator=(const function_clock&) = delete;
  ~function_clock() {
    s_.functions.add(number_, wall_seconds() - began_ - (counted() - before_));
  }

 private:
  [[nodiscard]] double counted() const {
    const auto& t = s_.seconds;
    return t.detect + t.respond + t.integrate + t.exchange + s_.functions.sum();
  }

  State& s_;
  std::size_t number_;
  double before_ = counted(), began_ = wall_seconds();
};

/// A function that a world calls, and the number of the name of its time.
template <class F>
struct named_function {
  F f;
  std::size_t number;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/state/function_times_definitions.hpp"
#endif
