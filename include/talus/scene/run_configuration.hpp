#pragma once
// The effective configuration of a run, beside each of its outputs: docs/runs.md.
#include <string>

#include "talus/scene/options.hpp"

namespace talus::detail {

/// The files OUTPUT.config.toml of a run, written by rank 0.
class run_configuration {
 public:
  /// Throws runtime_error if a file cannot be written, or is not one that talus wrote.
  [[gnu::cold]] run_configuration(const options& o, const std::string& program);
  /// Writes them, once. Throws runtime_error.
  [[gnu::cold]] void write();

 private:
  /// Calls f(option, path of the configuration) for each output.
  template <class F>
  void each_file(F&& f) const;

  const options& options_;
  std::string text_;
  bool written_ = false;
};

/// A number that differs if the configurations of two ranks do.
[[nodiscard, gnu::cold]] double configuration_mark(const std::string& configuration);

/// The options of the program that differ between two configurations, as in "spheres is 300 and was
/// 200"; empty if none. Those of talus itself do not count: a restart reports the parameters of the
/// world on its own, and files and numbers of steps may differ.
[[nodiscard, gnu::cold]] std::string differing_options(const std::string& mine,
                                                       const std::string& theirs);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/run_configuration_definitions.hpp"
#endif
