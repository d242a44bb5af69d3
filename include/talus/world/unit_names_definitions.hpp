#pragma once
// The definitions of unit_names.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/world/unit_names.hpp"

namespace talus::detail {

TALUS_INLINE void require_sane(const unit_names& names) {
  for (const std::string* name : {&names.length, &names.mass, &names.time})
    if (name->find_first_of(",\"\n\r[]") != std::string::npos)
      fail<std::invalid_argument>(
          "world.units cannot write the unit '{}' at the head of a column: give one without a "
          "comma, a quote, a bracket or a line feed, such as mm",
          *name);
}

TALUS_INLINE std::string in_units(std::string_view dimension, const unit_names& names) {
  const auto letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  std::string words;
  for (std::size_t at = 0; at < dimension.size();) {
    std::size_t end = at;
    while (end < dimension.size() && letter(dimension[end])) ++end;
    if (end == at) ++end;
    const std::string_view part = dimension.substr(at, end - at);
    const std::string* const name = part == "L"   ? &names.length
                                    : part == "M" ? &names.mass
                                    : part == "T" ? &names.time
                                                  : nullptr;
    words += name == nullptr || name->empty() ? part : std::string_view(*name);
    at = end;
  }
  return words;
}

TALUS_INLINE std::string unit_behind(std::string_view dimension, const unit_names& names) {
  if (dimension.empty() || dimension == "1") return {};
  if (names.length.empty() && names.mass.empty() && names.time.empty()) return {};
  return " " + in_units(dimension, names);
}

}  // namespace talus::detail
