#pragma once
// A line that says how far a run has come: rewritten in place on a terminal, now and then
// elsewhere.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>

#include "talus/core/clock.hpp"
#include "talus/core/error.hpp"

namespace talus {

class progress_line {
 public:
  /// Writes to `out`; says nothing if that is null.
  explicit progress_line(std::FILE* out)
      : out_(out), terminal_(out != nullptr && isatty(fileno(out)) != 0) {}

  /// The run goes on from this step: speed counts from here.
  void begin_at(std::uint64_t step) {
    first_ = step;
    start_ = detail::wall_seconds();
  }

  /// Call after each step; `last` is the step with which the run ends as far as is known. A line
  /// appears every 0.2 s on a terminal, every 10 s elsewhere. `note` is added to it, as in
  /// ", overlap 1e-5".
  void update(std::uint64_t step, std::uint64_t last, const std::string& note = {}) {
    if (out_ == nullptr) return;
    const double now = detail::wall_seconds();
    if (now - shown_ < (terminal_ ? 0.2 : 10)) return;
    shown_ = now;
    show(step, last, note);
  }
  /// Call at the end of the run, whatever it was asked for: the last line.
  void finish(std::uint64_t step, const std::string& note = {}) {
    if (out_ == nullptr || step == first_) return;
    show(step, step, note);
    if (terminal_) std::fputs("\n", out_);
    std::fflush(out_);
  }

 private:
  void show(std::uint64_t step, std::uint64_t last, const std::string& note) {
    const double seconds = detail::wall_seconds() - start_;
    const double speed = seconds > 0 ? static_cast<double>(step - first_) / seconds : 0;
    last = std::max(last, step);
    const double left = speed > 0 ? static_cast<double>(last - step) / speed : 0;
    const double part = static_cast<double>(step) / static_cast<double>(last);
    const std::string line =
        detail::compose("{}step {} of {} ({} %), {} steps/s, {} left{}{}", terminal_ ? "\r" : "",
                        step, last, std::lround(100 * part), detail::text(speed, 4), duration(left),
                        note, terminal_ ? "\x1b[K" : "\n");
    std::fputs(line.c_str(), out_);
    std::fflush(out_);
  }
  static std::string duration(double seconds) {
    const long s = std::lround(seconds);
    if (s < 60) return detail::compose("{} s", s);
    if (s < 3600) return detail::compose("{} min {} s", s / 60, s % 60);
    return detail::compose("{} h {} min", s / 3600, s / 60 % 60);
  }

  std::FILE* out_;
  bool terminal_;
  std::uint64_t first_ = 0;
  double start_ = detail::wall_seconds();
  double shown_ = start_;
};

}  // namespace talus
