#pragma once
// The definitions of recorded_values.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/state/recorded_values.hpp"

namespace talus::detail {

TALUS_INLINE void recorded_values::set(const std::string& name, double value,
                                       const std::string& dimension) {
  for (recorded_value& r : all_)
    if (r.name == name) {
      r.value = value;
      return;
    }
  add(name, value, dimension);
}

TALUS_INLINE void recorded_values::add(const std::string& name, double value,
                                       const std::string& dimension) {
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

}  // namespace talus::detail
