#pragma once
// The summary of a run as text.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "talus/core/error.hpp"
#include "talus/observe/summary_figures.hpp"
#include "talus/observe/warnings_of_scales.hpp"

namespace talus {

namespace detail {

/// "1 body", "2 bodies".
[[nodiscard, gnu::cold]] std::string counted(std::uint64_t n, const char* one, const char* many);

/// Integer percentages of the time of a run whose sum is at most 100.
struct time_shares {
  long detect, respond, exchange;

  time_shares(const stage_seconds& s, double wall);
};

/// The line on the balance of momentum and the largest overlap.
[[nodiscard, gnu::cold]] std::string balance_text(const talus::summary& r);

/// Warnings for errors that the residual alone hides.
[[nodiscard, gnu::cold]] std::string balance_warnings(const talus::summary& r);

}  // namespace detail

/// The figures as text.
[[nodiscard, gnu::cold]] std::string to_text(const summary& r);

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/summary_text_definitions.hpp"
#endif
