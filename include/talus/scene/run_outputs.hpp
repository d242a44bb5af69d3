#pragma once
// Checks of output files before a run writes its results, its time series, and other outputs.
#include <cerrno>
#include <list>
#include <string>

#include "talus/core/error.hpp"
#include "talus/core/output_file.hpp"
#include "talus/core/run_lock.hpp"
#include "talus/io/output_kinds.hpp"

namespace talus::detail {

/// Checks the file of one option on rank 0, which is no stream: throws runtime_error if it must not
/// be replaced or cannot be written. Returns true if a file of its kind exists.
[[gnu::cold]] inline bool inspect_output(const char* option, const std::string& file,
                                         const output_kind& kind, bool force) {
  const output_target target = inspect_target(file, kind, force);
  if (!target.objection.empty())
    fail<std::runtime_error>("{} {} {}", option, file, target.objection);
  if (!part_file(file).good())
    fail<std::runtime_error>("{} {} cannot be written: {}", option, file,
                             words_of_failed_write(file, 0, errno));
  return target.replaces;
}

/// Checks --json, --view and --csv on rank 0 before anything is written, and takes their locks.
/// Returns a text that lists the files to be replaced.
template <class Options>
[[nodiscard, gnu::cold]] std::string inspect_outputs(const Options& options,
                                                     std::list<run_lock>& locks) {
  std::string words;
  const auto each = [&](const char* option, const std::string& file, const output_kind& kind,
                        bool goes_on) {
    if (file.empty() || is_stream(file)) return;
    if (inspect_output(option, file, kind, options.force) && !goes_on)
      words += compose("{} {} replaces {}\n", option, file, kind.name);
    locks.emplace_back(file, compose("{} {}", option, file));
  };
  each("--json", options.json, results_output, false);
  each("--view", options.view, view_output, false);
  each("--csv", options.csv, table_output, !options.restart.empty());
  return words;
}

}  // namespace talus::detail
