#pragma once
// A line with the progress of a run: rewritten in place on a terminal, printed at intervals
// elsewhere.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>

#include "talus/core/clock.hpp"
#include "talus/core/error.hpp"

namespace talus {

class progress_line {
 public:
  /// Writes to `out`, unless that is null, as long as that takes it, and every 10 s to `log`,
  /// unless that is empty.
  explicit progress_line(std::FILE* out, std::function<void(const std::string&)> log = {})
      : out_(out), terminal_(out != nullptr && isatty(fileno(out)) != 0), log_(std::move(log)) {}

  /// The run continues from this step: speed counts from here.
  void begin_at(std::uint64_t step);

  /// Call after each step; `last` is the final step of the run if known. A line appears every 0.2 s
  /// on a terminal, every 10 s elsewhere. `note` is added to it, as in ", overlap 1e-5".
  void update(std::uint64_t step, std::uint64_t last, const std::string& note = {});
  /// Call at the end of the run, in any case: the last line.
  void finish(std::uint64_t step, const std::string& note = {});

 private:
  [[nodiscard]] std::string line(std::uint64_t step, std::uint64_t last,
                                 const std::string& note) const;
  void show(const std::string& line);
  static std::string duration(double seconds);

  std::FILE* out_;
  bool terminal_;
  std::uint64_t first_ = 0;
  double start_ = detail::wall_seconds();
  double shown_ = start_;
  std::function<void(const std::string&)> log_;
  double logged_ = start_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/progress_definitions.hpp"
#endif
