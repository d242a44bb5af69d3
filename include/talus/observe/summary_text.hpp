#pragma once
// The summary of a run as text.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "talus/core/error.hpp"
#include "talus/observe/summary_figures.hpp"
#include "talus/observe/time_shares.hpp"
#include "talus/observe/warnings_of_scales.hpp"

namespace talus {

namespace detail {

/// "1 body", "2 bodies".
[[nodiscard, gnu::cold]] std::string counted(std::uint64_t n, const char* one, const char* many);

/// The lines on overlaps and on how well the contact law and the balance of momentum hold.
[[nodiscard, gnu::cold]] std::string error_text(const talus::summary& r);

/// The values of the monitors, in words.
[[nodiscard, gnu::cold]] std::string monitors_text(const talus::summary& r);

/// What several ranks sent each other, and how evenly they shared the work; empty for one rank.
[[nodiscard, gnu::cold]] std::string ranks_text(const talus::summary& r);

/// Warnings for errors that the residual alone hides.
[[nodiscard, gnu::cold]] std::string balance_warnings(const talus::summary& r);

}  // namespace detail

/// The figures as text.
[[nodiscard, gnu::cold]] std::string to_text(const summary& r);

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/summary_text_definitions.hpp"
#endif
