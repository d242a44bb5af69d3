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
  void set(const std::string& name, double value, const std::string& dimension);
  [[nodiscard]] const std::vector<recorded_value>& all() const { return all_; }
  void replace(std::vector<recorded_value> all) { all_ = std::move(all); }

 private:
  [[gnu::cold]] void add(const std::string& name, double value, const std::string& dimension);

  std::vector<recorded_value> all_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/state/recorded_values_definitions.hpp"
#endif
