#pragma once
// Checks of measured values against expected ones: each prints its line, and if the environment
// variable TALUS_VALIDATION_TSV names a file, appends it there too, for the report: test, quantity,
// expected, measured, error, tolerance, ok (1 or 0), separated by tabs, without a header. Call them
// on one rank only.
#include <doctest/doctest.h>
#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace talus::validation {

namespace detail {

inline bool judge(const std::string& test, const std::string& quantity, double expected,
                  double measured, double error, double tolerance) {
  const bool ok = error <= tolerance;  // false for NaN
  MESSAGE(
      fmt::format("{}: {}: expected {:.10g}, measured {:.10g}, error {:.3g}, tolerance {:.3g}{}",
                  test, quantity, expected, measured, error, tolerance, ok ? "" : ": WRONG"));
  if (const char* name = std::getenv("TALUS_VALIDATION_TSV"); name != nullptr && *name != '\0') {
    const std::string line =
        fmt::format("{}\t{}\t{:.17g}\t{:.17g}\t{:.17g}\t{:.17g}\t{}\n", test, quantity, expected,
                    measured, error, tolerance, ok ? 1 : 0);
    // Opened to append, and written at once: programs that run side by side do not mix their lines.
    std::FILE* file = std::fopen(name, "a");
    REQUIRE_MESSAGE(file != nullptr,
                    "TALUS_VALIDATION_TSV names a file that cannot be opened: ", name);
    std::fwrite(line.data(), 1, line.size(), file);
    std::fclose(file);
  }
  CHECK_MESSAGE(ok, test, ": ", quantity);
  return ok;
}

}  // namespace detail

/// |measured - expected| <= tolerance.
inline bool check_absolute(const std::string& test, const std::string& quantity, double expected,
                           double measured, double tolerance) {
  return detail::judge(test, quantity, expected, measured, std::abs(measured - expected),
                       tolerance);
}
/// |measured / expected - 1| <= tolerance.
inline bool check_relative(const std::string& test, const std::string& quantity, double expected,
                           double measured, double tolerance) {
  return detail::judge(test, quantity, expected, measured, std::abs(measured / expected - 1),
                       tolerance);
}
/// An error that is measured directly: not above the tolerance.
inline bool check_error(const std::string& test, const std::string& quantity, double error,
                        double tolerance) {
  return detail::judge(test, quantity, 0, error, std::abs(error), tolerance);
}
/// measured >= least: an order of convergence, a number of events. The error is the deficit.
inline bool check_at_least(const std::string& test, const std::string& quantity, double least,
                           double measured) {
  const double lacking = measured >= least ? 0 : least - measured;
  return detail::judge(test, quantity, least, measured, lacking, 0);
}
/// A condition that must hold, or must not: expected and measured are 1 for yes and 0 for no.
inline bool check_holds(const std::string& test, const std::string& quantity, bool expected,
                        bool measured) {
  return detail::judge(test, quantity, expected, measured, expected == measured ? 0 : 1, 0);
}

}  // namespace talus::validation
