#pragma once
// User-defined numbers that a run writes to its table: world.record(name, value).
#include <stdexcept>
#include <string>
#include <vector>

#include "talus/core/error.hpp"

namespace talus::detail {

struct recorded_value {
  std::string name, dimension;
  double value = 0;
};

/// In the order of their first record.
class recorded_values {
 public:
  /// Throws invalid_argument for a name that cannot be the head of a column.
  void set(const std::string& name, double value, const std::string& dimension) {
    for (recorded_value& r : all_)
      if (r.name == name) {
        r.value = value;
        return;
      }
    add(name, value, dimension);
  }
  [[nodiscard]] const std::vector<recorded_value>& all() const { return all_; }
  void replace(std::vector<recorded_value> all) { all_ = std::move(all); }

 private:
  [[gnu::cold]] void add(const std::string& name, double value, const std::string& dimension) {
    const auto plain = [](const std::string& text) {
      return text.find_first_of(",\"\n\r[]") == text.npos;
    };
    if (name.empty() || !plain(name) || !plain(dimension))
      fail<std::invalid_argument>(
          "world.record cannot make a column of '{}' with the dimension '{}': give it a name, and "
          "neither of the two a comma, a quote, a bracket or a line feed",
          name, dimension);
    all_.push_back({name, dimension, value});
  }

  std::vector<recorded_value> all_;
};

}  // namespace talus::detail
