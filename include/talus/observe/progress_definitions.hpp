#pragma once
// The definitions of progress.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/observe/progress.hpp"

namespace talus {

TALUS_INLINE void progress_line::begin_at(std::uint64_t step) {
  first_ = step;
  start_ = detail::wall_seconds();
}

TALUS_INLINE void progress_line::update(std::uint64_t step, std::uint64_t last,
                                        const std::string& note) {
  if (out_ == nullptr && !log_) return;
  const double now = detail::wall_seconds();
  const bool shows = out_ != nullptr && now - shown_ >= (terminal_ ? 0.2 : 10);
  const bool logs = log_ && now - logged_ >= 10;
  if (!shows && !logs) return;
  const std::string words = line(step, last, note);
  if (shows) shown_ = now, show(words);
  if (logs) logged_ = now, log_(words + '\n');
}

TALUS_INLINE void progress_line::finish(std::uint64_t step, const std::string& note) {
  if ((out_ == nullptr && !log_) || step == first_) return;
  const std::string words = line(step, step, note);
  if (log_) log_(words + '\n');
  if (out_ == nullptr) return;
  show(words + (terminal_ ? "\n" : ""));
}

TALUS_INLINE std::string progress_line::line(std::uint64_t step, std::uint64_t last,
                                             const std::string& note) const {
  const double seconds = detail::wall_seconds() - start_;
  const double speed = seconds > 0 ? static_cast<double>(step - first_) / seconds : 0;
  last = std::max(last, step);
  const double left = speed > 0 ? static_cast<double>(last - step) / speed : 0;
  const double part = static_cast<double>(step) / static_cast<double>(last);
  return detail::compose("step {} of {} ({} %), {} steps/s, {} left{}", step, last,
                         std::lround(100 * part), detail::text(speed, 4), duration(left), note);
}

TALUS_INLINE void progress_line::show(const std::string& line) {
  const std::string words = (terminal_ ? "\r\x1b[K" : "") + line + (terminal_ ? "" : "\n");
  if (std::fputs(words.c_str(), out_) < 0 || std::fflush(out_) != 0) out_ = nullptr;
}

TALUS_INLINE std::string progress_line::duration(double seconds) {
  const long s = std::lround(seconds);
  if (s < 60) return detail::compose("{} s", s);
  if (s < 3600) return detail::compose("{} min {} s", s / 60, s % 60);
  return detail::compose("{} h {} min", s / 3600, s / 60 % 60);
}

}  // namespace talus
