#pragma once
// The summary of a run as JSON.
#include <cmath>
#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

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
  [[nodiscard]] std::string str() const { return "{\n" + text_ + "\n}\n"; }

 private:
  [[gnu::cold]] void put(std::string_view key, const std::string& value);
  std::string text_;
};

}  // namespace detail

/// The figures as one flat JSON object.
[[nodiscard, gnu::cold]] std::string to_json(const summary& r);

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/summary_json_definitions.hpp"
#endif
