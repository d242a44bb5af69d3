#pragma once
// Names of the units of a program: text in its summary, tables and results.
#include <string>
#include <string_view>

#include "talus/core/error.hpp"

namespace talus {

/// Names of units; an empty one is unknown.
struct unit_names {
  std::string length{};  ///< as "m"
  std::string mass{};    ///< as "kg"
  std::string time{};    ///< as "s"
};

namespace detail {

/// Throws invalid_argument for a name that cannot be part of the head of a column.
[[gnu::cold]] void require_sane(const unit_names& names);

/// A dimension, as "M L^2/T^2", in these units: "kg m^2/s^2".
[[nodiscard, gnu::cold]] std::string in_units(std::string_view dimension, const unit_names& names);

/// A dimension in these units behind a number in a text: with a space before it; empty without
/// units, and for the dimension 1.
[[nodiscard, gnu::cold]] std::string unit_behind(std::string_view dimension,
                                                 const unit_names& names);

}  // namespace detail
}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/world/unit_names_definitions.hpp"
#endif
