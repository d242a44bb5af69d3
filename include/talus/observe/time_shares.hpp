#pragma once
// What the wall time of a run was needed for, in percent.
#include <string>

#include "talus/observe/summary_figures.hpp"

namespace talus::detail {

/// Percentages of the wall time of a run, on the mean rank: whole numbers whose sum is 100. What
/// took less than 1 % is part of the last one; `small` gets its names.
[[nodiscard, gnu::cold]] results time_shares(const talus::summary& r, std::string& small);

/// The lines of the summary on wall time, CPU time, and what the wall time was needed for.
[[nodiscard, gnu::cold]] std::string time_text(const talus::summary& r);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/observe/time_shares_definitions.hpp"
#endif
