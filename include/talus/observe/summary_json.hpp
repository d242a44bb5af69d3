#pragma once
// The summary of a run as JSON.
#include <cmath>
#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/observe/summary_figures.hpp"

namespace talus {

namespace detail {

/// One flat JSON object, field by field.
class json_object {
 public:
  [[gnu::cold]] void add(std::string_view key, std::string_view text);
  void add(std::string_view key, const std::string& text) { add(key, std::string_view(text)); }
  /// JSON has no NaN and no infinity: they become null.
  [[gnu::cold]] void add(std::string_view key, double value);
  void add(std::string_view key, std::uint64_t value) { put(key, std::to_string(value)); }
  void add(std::string_view key, int value) { put(key, std::to_string(value)); }
  void add(std::string_view key, std::same_as<bool> auto value);
  [[nodiscard, gnu::cold]] bool has(std::string_view key) const;
  [[nodiscard]] std::string str() const { return "{\n" + text_ + "\n}\n"; }

 private:
  [[gnu::cold]] void put(std::string_view key, const std::string& value);
  std::string text_;
  std::vector<std::string> keys_;
};

}  // namespace detail

/// The figures as one flat JSON object. The time of a function named "height of the heap" is
/// "seconds_height_of_the_heap". A result of the scenario whose name is taken, such as "dt",
/// is written as "result_dt".
[[nodiscard, gnu::cold]] std::string to_json(const summary& r);

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/summary_json_definitions.hpp"
#endif
