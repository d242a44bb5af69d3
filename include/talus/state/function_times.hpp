#pragma once
// Wall time of what is no stage of a step: functions of the program, outputs and monitors, by name.
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talus/core/clock.hpp"

namespace talus::detail {

/// The name of the first entry: the part of steps of simulate() that is no stage.
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
  /// Seconds of all names together.
  [[nodiscard]] double sum() const { return sum_; }
  [[nodiscard]] const std::vector<std::pair<std::string, double>>& all() const { return all_; }

 private:
  std::vector<std::pair<std::string, double>> all_;
  double sum_ = 0;
};

/// Divides the time from its beginning on among names.
template <class State>
class lap_clock {
 public:
  explicit lap_clock(State& s) : s_(s) {}
  /// Adds to a name the wall time since the last call, without that of stages and of other names.
  void lap(std::size_t number) {
    const double now = wall_seconds(), here = now - began_ - (counted() - before_);
    s_.functions.add(number, here);
    began_ = now, before_ = counted();
  }

 private:
  [[nodiscard]] double counted() const {
    const auto& t = s_.seconds;
    return t.detect + t.respond + t.integrate + t.exchange + s_.functions.sum();
  }

  State& s_;
  double before_ = counted(), began_ = wall_seconds();
};

/// Adds the wall time of its life to a name.
template <class State>
class function_clock {
 public:
  function_clock(State& s, std::size_t number) : clock_(s), number_(number) {}
  function_clock(const function_clock&) = delete;
  function_clock& operator=(const function_clock&) = delete;
  ~function_clock() { clock_.lap(number_); }

 private:
  lap_clock<State> clock_;
  std::size_t number_;
};

/// A function that a world calls, and the number of the name of its time.
template <class F>
struct named_function {
  F f;
  std::size_t number;
  /// The function may change bodies or parameters after steps whose number is a multiple of this;
  /// 0: never.
  std::uint64_t acts_every = 1;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/state/function_times_definitions.hpp"
#endif
