#pragma once
// The effective configuration of a run, beside each of its outputs: docs/runs.md.
#include <array>
#include <list>
#include <span>
#include <string>

#include "talus/core/run_lock.hpp"
#include "talus/scene/options.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// The files OUTPUT.config.toml of a run, written by rank 0.
class run_configuration {
 public:
  /// Locks them. Throws runtime_error if a file cannot be written, is not one that talus wrote, or
  /// belongs to another run. The options must outlive this.
  [[gnu::cold]] void prepare(const options& o, const std::string& program);
  /// Writes them, once, if they are prepared. Throws runtime_error.
  [[gnu::cold]] void write();

 private:
  /// Calls f(option, path of the configuration) for each output.
  template <class F>
  void each_file(F&& f) const;

  std::list<run_lock> locks_;         ///< to the end of the run: other runs do not replace them
  const options* options_ = nullptr;  ///< null: there is nothing to write
  std::string text_;
};

/// A number that differs if the configurations of two ranks do.
[[nodiscard, gnu::cold]] double configuration_mark(const std::string& configuration);

/// Throws usage_error, alike on all ranks, if the ranks have read different files of options.
template <class Scenario>
[[gnu::cold]] void require_same_options(world<Scenario>& w, const std::string& configuration) {
  if (w.ranks() == 1) return;
  const double mine = configuration_mark(configuration);
  std::array<double, 2> ends{mine, -mine};
  w.link().reduce(reduction::max, std::span<double>(ends));
  if (ends[0] != -ends[1])
    throw usage_error(
        "the ranks have different options: a file of --config is not the same on all machines; put "
        "it where all of them read the same");
}

/// The options of the program that differ between two configurations, as in "spheres is 300 and was
/// 200"; empty if none. Those of talus itself do not count: a restart reports the parameters of the
/// world on its own, and files and numbers of steps may differ.
[[nodiscard, gnu::cold]] std::string differing_options(const std::string& mine,
                                                       const std::string& theirs);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/run_configuration_definitions.hpp"
#endif
