#pragma once
// A line that says how far a run has come: rewritten in place on a terminal, now and then elsewhere.
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

#include "talus/core/error.hpp"

namespace talus {

class progress_line {
 public:
  /// Writes to `out`; says nothing if that is null.
  explicit progress_line(std::FILE* out)
      : out_(out), terminal_(out != nullptr && isatty(fileno(out)) != 0), start_(clock::now()) {}

  /// Call after each step; a line appears every 0.2 s on a terminal, every 10 s elsewhere.
  void update(std::uint64_t step, std::uint64_t steps) {
    if (out_ == nullptr) return;
    const auto now = clock::now();
    if (step < steps && now - shown_ < std::chrono::milliseconds(terminal_ ? 200 : 10000)) return;
    shown_ = now;
    const double seconds = std::chrono::duration<double>(now - start_).count();
    const double speed = seconds > 0 ? static_cast<double>(step) / seconds : 0;
    const double left = speed > 0 ? static_cast<double>(steps - step) / speed : 0;
    fmt::print(out_, "{}step {} of {} ({:.0f} %), {:.4g} steps/s, {} left{}", terminal_ ? "\r" : "", step,
               steps, 100.0 * static_cast<double>(step) / static_cast<double>(steps), speed,
               duration(left), terminal_ ? "\x1b[K" : "\n");
    if (terminal_ && step == steps) fmt::print(out_, "\n");
    std::fflush(out_);
  }

 private:
  using clock = std::chrono::steady_clock;

  static std::string duration(double seconds) {
    const auto s = static_cast<long>(seconds + 0.5);
    if (s < 60) return fmt::format("{} s", s);
    if (s < 3600) return fmt::format("{} min {} s", s / 60, s % 60);
    return fmt::format("{} h {} min", s / 3600, s / 60 % 60);
  }

  std::FILE* out_;
  bool terminal_;
  clock::time_point start_;
  clock::time_point shown_ = clock::now();
};

}  // namespace talus
